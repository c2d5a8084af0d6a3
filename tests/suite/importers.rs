//! Importers against files that nobody here wrote, and against files that are broken: a model or a sentence, never a
//! panic, and no more memory than a file can ask for.

use std::path::{Path, PathBuf};

use orrery_engine::import::{Model, import, import_nff_text, read_fbx, read_gltf, read_obj};
use orrery_tests::mutate::Mutator;

/// Broken files tried of each file of a corpus.
const TRIES: u64 = 400;
/// Bytes of vertices that a broken file of a few hundred bytes may come to.
const MOST_BYTES: usize = 64 << 20;

/// Reads a file of the corpus in that folder.
type Reader = fn(&[u8], &Path) -> Result<Model, String>;

/// Formats by the folder of their corpus. The inner functions, so that a panic is a panic.
const READERS: &[(&str, Reader)] = &[
    ("fbx", read_fbx),
    ("gltf", read_gltf),
    // Its material file is the file itself, so that it is broken too.
    ("obj", |bytes, folder| {
        read_obj(bytes, folder, &|_| Ok(bytes.to_vec()))
    }),
    ("nff", |bytes, folder| {
        import_nff_text(&String::from_utf8_lossy(bytes), &|name| {
            std::fs::read_to_string(folder.join(name)).map_err(|error| error.to_string())
        })
    }),
];

#[test]
fn broken_files_are_read_or_refused() {
    for &(format, read) in READERS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(format);
        let files = files_below(&folder);
        assert!(!files.is_empty(), "no corpus in {}", folder.display());
        for (number, path) in (0..).zip(&files) {
            let whole = std::fs::read(path).expect("a file of the corpus");
            let model = read(&whole, &folder);
            assert!(model.is_ok(), "{}: {model:?}", path.display());
            let mut mutator = Mutator::new(number + 1);
            for _ in 0..TRIES {
                let broken = mutator.mutate(&whole);
                let size = read(&broken, &folder).map_or(0, |model| bytes_of(&model));
                assert!(
                    size <= MOST_BYTES,
                    "{size} bytes of a broken {}",
                    path.display()
                );
            }
        }
    }
}

fn bytes_of(model: &Model) -> usize {
    let parts = model.parts.iter();
    parts
        .map(|part| part.mesh.vertices.len() * 36 + part.mesh.triangles.len() * 12)
        .sum::<usize>()
        + model.nodes.len() * 200
}

/// Files below a folder, in order; none where it is not there.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(files_below(&path));
        } else {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// A folder of files of others, which do not come along; says so where it is not there.
fn of_others(folder: &str) -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let files = files_below(&scenes.join(folder));
    if files.is_empty() {
        eprintln!("skipped: there is no {folder} in {}", scenes.display());
    }
    files
}

fn with_ending(files: Vec<PathBuf>, ending: &str) -> impl Iterator<Item = (PathBuf, String)> {
    let named = files.into_iter().filter_map(|path| {
        let name = path.file_name()?.to_str()?.to_owned();
        Some((path, name))
    });
    named.filter(move |(_, name)| name.ends_with(ending))
}

#[test]
fn every_database_is_read_without_a_warning() {
    for (path, name) in with_ending(of_others("spd-nff"), ".nff") {
        let model = import(&path).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert_eq!(model.warnings.sentences(), Vec::<String>::new(), "{name}");
        assert!(model.contents().any(|content| content.is_light()), "{name}");
    }
}

#[test]
fn files_of_the_other_kinds_of_nff_are_read_or_refused_with_a_line() {
    for (path, name) in with_ending(of_others("assimp-models/NFF"), ".nff") {
        match import(&path) {
            Ok(model) => assert!(model.contents().count() > 0, "{name}"),
            Err(why) => assert!(why.contains("line "), "{name}: {why}"),
        }
    }
}

/// At least as many triangles and moving nodes as the authors of BART count, and its seconds.
#[test]
fn the_scenes_of_bart_are_all_there() {
    for (file, triangles, moving, seconds) in [
        ("kitchen/kitchen.aff", 110_561, 6, 20.0),
        ("robots/Robot.aff", 71_708, 150, 50.0),
        ("museum/museum5.aff", 11_167, 1, 6.0),
    ] {
        let (folder, name) = file.split_once('/').expect("a folder");
        let files = with_ending(of_others(&format!("bart-aff/{folder}")), name);
        for (path, name) in files {
            let model = import(&path).unwrap_or_else(|why| panic!("{name}: {why}"));
            let shown = model.contents().filter_map(|content| match content {
                orrery_engine::import::Content::Part { part, .. } => Some(*part),
                _ => None,
            });
            let shown: usize = shown
                .map(|part| model.parts[part].mesh.triangles.len())
                .sum();
            eprintln!(
                "{name}: {shown} triangles, {:?}",
                model.warnings.sentences()
            );
            let [clip] = model.clips.as_slice() else {
                panic!("{name}: {} clips", model.clips.len());
            };
            assert!(shown >= triangles, "{name}: {shown} triangles");
            assert_eq!(clip.end - clip.start, seconds, "{name}");
            let mut targets: Vec<usize> = clip.tracks.iter().map(|track| track.target).collect();
            targets.sort_unstable();
            targets.dedup();
            assert!(targets.len() >= moving, "{name}: {} moved", targets.len());
        }
    }
}

/// Clips of the files, by the ends of their names.
#[test]
fn every_gltf_is_read_with_its_clips() {
    let files = ["gltf-cc0", "gltf-ccby"].map(of_others).concat();
    for (path, name) in with_ending(files.clone(), ".gltf").chain(with_ending(files, ".glb")) {
        let model = match import(&path) {
            Ok(model) => model,
            Err(why) => {
                // The JSON of a binary file without its bytes.
                assert_eq!(name, "InterpolationTestGlb.gltf", "{why}");
                assert!(why.contains("binary chunk"), "{why}");
                continue;
            }
        };
        let clips = match name.as_str() {
            "InterpolationTest.gltf" | "InterpolationTest.glb" => 9,
            "Fox.glb" | "MorphStressTest.gltf" => 3,
            "Cameras.gltf" | "SimpleSparseAccessor.gltf" => 0,
            _ => 1,
        };
        assert_eq!(model.clips.len(), clips, "{name}");
        assert!(model.triangles() > 0, "{name}");
        let odd = model.warnings.sentences();
        let pictures = |sentence: &String| sentence.contains("cannot be read: No such file");
        assert!(odd.iter().all(pictures), "{name}: {odd:?}");
    }
}
