//! The plan of the house, held: who may import whom, which crate is used where, how long a file may be;
//! and that no two systems of a frame touch the same data in an order nobody chose.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use orrery_engine::Engine;

/// For each module of the engine, the modules it may name besides itself and those of [`LOOP`].
const MAY_IMPORT: [(&str, &[&str]); 14] = [
    ("geom", &[]),
    ("pod", &[]),
    ("bvh", &["geom", "pod"]),
    // A mesh may bring its tree along.
    ("world", &["bvh", "geom", "pod"]),
    ("frame", &["bvh", "geom", "world"]),
    ("trace", &["bvh", "frame", "geom", "world"]),
    ("import", &["bvh", "pod", "world"]),
    ("scene", &["import", "world"]),
    ("present", &["frame", "trace", "world"]),
    ("profile", &["trace"]),
    ("input", &["frame", "world"]),
    (
        "editor",
        &[
            "frame", "input", "present", "profile", "scene", "trace", "world",
        ],
    ),
    (
        "window",
        &[
            "editor", "frame", "input", "present", "profile", "scene", "trace", "world",
        ],
    ),
    (
        "app",
        &[
            "editor", "frame", "present", "profile", "scene", "trace", "world",
        ],
    ),
];
/// What a module needs to add its systems to the frame; `time` is one of them itself.
const LOOP: [&str; 4] = ["app", "schedule", "time", "Engine"];
/// Crates and the only folders or files of the engine that may name them.
const ONLY_IN: [(&str, &[&str]); 14] = [
    ("wgpu", &["trace/gpu", "present"]),
    ("winit", &["window", "input"]),
    ("egui", &["editor", "present", "window"]),
    ("egui_wgpu", &["present"]),
    ("egui_winit", &["window"]),
    ("naga", &["trace/gpu"]),
    ("naga_oil", &["trace/gpu"]),
    ("tobj", &["import"]),
    ("gltf", &["import"]),
    ("image", &["import"]),
    ("exr", &["present"]),
    ("png", &["present"]),
    ("ufbx", &["import/fbx"]),
    ("x11_dl", &["window"]),
];
/// Lines of a file that are not blank. Longer ones are split along an idea.
const LINES: usize = 400;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file below a folder with that ending.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The file's code without comments and without its tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().map(|l| l.split("//").next().unwrap_or(l));
    lines.collect::<Vec<_>>().join("\n")
}

/// The words that follow `prefix` wherever it stands at the start of a word.
fn words_after(code: &str, prefix: &str) -> BTreeSet<String> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut words = BTreeSet::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].chars().next_back().is_some_and(is_word) {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        let group = rest.strip_prefix('{').and_then(|r| r.split('}').next());
        let names = group.map_or_else(|| vec![rest], |group| group.split(',').collect());
        let word = |name: &str| name.trim().chars().take_while(|&c| is_word(c)).collect();
        words.extend(names.into_iter().map(word));
    }
    words.remove("");
    words
}

/// Engine files with their place below `src`, in words of the plan: `trace/gpu/mod.rs`.
fn engine_files() -> Vec<(String, PathBuf)> {
    let src = root().join("engine/src");
    let place = |path: &PathBuf| {
        let place = path.strip_prefix(&src).expect("below src");
        place.to_string_lossy().replace('\\', "/")
    };
    files(&src, "rs")
        .iter()
        .map(|p| (place(p), p.clone()))
        .collect()
}

#[test]
fn modules_import_only_whom_they_may() {
    let mut wrong = Vec::new();
    for (place, path) in engine_files() {
        let module = place.split('/').next().unwrap_or_default();
        let module = module.trim_end_matches(".rs");
        let is_test = place.ends_with("tests.rs") || place.contains("/tests/");
        if is_test || ["lib", "schedule", "time", "testing"].contains(&module) {
            continue;
        }
        let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == module) else {
            wrong.push(format!("{place}: the plan has no module `{module}`"));
            continue;
        };
        for used in words_after(&code(&path), "crate::") {
            let may = used == module || LOOP.contains(&&*used) || allowed.contains(&&*used);
            if !may {
                wrong.push(format!("{place}: `{module}` may not import `{used}`"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn crates_are_named_only_where_they_belong() {
    let mut wrong = Vec::new();
    for (place, path) in engine_files() {
        let code = code(&path);
        for (name, places) in ONLY_IN {
            let used = !words_after(&code, &format!("{name}::")).is_empty();
            let belongs = |folder: &&&str| {
                place
                    .strip_prefix(**folder)
                    .is_some_and(|rest| rest.starts_with(['/', '.']))
            };
            if used && places.iter().find(belongs).is_none() {
                wrong.push(format!(
                    "{place}: `{name}` belongs into {}",
                    places.join(", ")
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_file_is_too_long_and_each_says_what_it_is() {
    let mut wrong = Vec::new();
    for folder in ["engine/src", "game/src", "tests/src", "tests/suite"] {
        for path in files(&root().join(folder), "rs") {
            let text = fs::read_to_string(&path).expect("readable");
            let lines = text.lines().filter(|line| !line.trim().is_empty()).count();
            if lines > LINES {
                wrong.push(format!("{}: {lines} lines, not blank", path.display()));
            }
            // A file of tests belongs to the module above it, which says what it is.
            if !text.starts_with("//!") && !path.ends_with("tests.rs") {
                wrong.push(format!(
                    "{}: its head does not say what it is",
                    path.display()
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_top_level_is_the_plan() {
    let planned = [
        "Cargo.lock",
        "Cargo.toml",
        "README.md",
        "assets",
        "engine",
        "game",
        "shaders",
        "tests",
    ];
    // What git does not track (build folders, pictures) is nobody's business here.
    let ignored = ["target", "frames", "screenshots"];
    for entry in fs::read_dir(root()).expect("readable").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let known = planned.contains(&&*name) || ignored.contains(&&*name);
        assert!(
            known || name.starts_with('.'),
            "`{name}` is not in the plan of the top level"
        );
    }
}

#[test]
fn no_two_systems_run_in_an_order_nobody_chose() {
    let mut engine = Engine::new();
    engine.add_plugin(orrery_engine::profile::plugin);
    assert_eq!(engine.validate(), Ok(()), "headless");
    let mut engine = Engine::new();
    engine
        .add_plugin(orrery_engine::profile::plugin)
        .add_plugin(orrery_engine::input::plugin)
        .add_plugin(orrery_engine::present::plugin)
        .add_plugin(orrery_engine::editor::plugin);
    assert_eq!(engine.validate(), Ok(()), "in a window");
}

#[test]
fn an_ambiguous_pair_is_an_error() {
    use orrery_engine::frame::TraceSettings;
    use orrery_engine::schedule::FrameSet;
    fn write(mut settings: bevy_ecs::prelude::ResMut<TraceSettings>) {
        settings.size += 1;
    }
    fn read(settings: bevy_ecs::prelude::Res<TraceSettings>) {
        assert!(settings.size.x > 0);
    }
    let mut engine = Engine::new();
    engine.add_systems(FrameSet::Edit, (write, read));
    assert!(engine.validate().is_err());
}
