//! The program `orrery` from outside: exit codes, messages, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use orrery_tests::program::program;

/// A fresh folder for one test.
pub fn folder(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("orrery_cli_{}_{test}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

/// Runs the program in a folder without a display.
fn orrery_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(program())
        .args(arguments)
        .current_dir(folder)
        // The user's own cache is no place for tests.
        .env("ORRERY_CACHE_DIR", "")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program starts")
}

/// Runs the program in the project's root without a display.
pub fn orrery(arguments: &[&str]) -> Output {
    orrery_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."), arguments)
}

/// Holds the exit code, and that the words are among what was said; never a panic.
pub fn expect(arguments: &[&str], code: i32, words: &[&str]) -> Output {
    let output = orrery(arguments);
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments:?}: no `{word}` in: {said}");
    }
    output
}

#[test]
fn instructions_that_nobody_knows_are_an_error() {
    let output = Command::new(program())
        .args(["bench", "cpu", "--small", "--repeat", "20"])
        .env("ORRERY_CPU", "mmx")
        .env("ORRERY_CACHE_DIR", "")
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    for word in ["ORRERY_CPU", "`mmx`", "avx512, avx2, portable"] {
        assert!(said.contains(word), "no `{word}` in: {said}");
    }
}

#[test]
fn help_teaches_by_examples() {
    expect(
        &["--help"],
        0,
        &["Examples:", "orrery render", "Exit codes"],
    );
    expect(
        &["render", "--help"],
        0,
        &["--frames", "--resume", "--levels", "bit for bit"],
    );
    expect(&["bench", "--list"], 0, &["frame", "motion", "structures"]);
}

#[test]
fn wrong_words_are_usage() {
    expect(&["--nonsense"], 2, &["--nonsense"]);
    expect(&["render"], 2, &["SCENE"]);
    expect(&["render", "demo", "--size", "12"], 2, &["1280x720"]);
    expect(&["render", "demo", "--frames", "9..3"], 2, &["0..90"]);
    expect(&["render", "demo", "--samples", "257"], 2, &["1..=256"]);
    expect(&["render", "demo", "--cutoff", "small"], 2, &["from 0 on"]);
    expect(&["render", "demo", "--backend", "fpga"], 2, &["reference"]);
    expect(
        &["render", "demo", "--without", "speed"],
        2,
        &["away", "still"],
    );
    expect(&["render", "demo", "--out", "x.jpg"], 2, &[".png"]);
    expect(
        &["render", "demo", "--frames", "0..2", "--out", "x.png"],
        2,
        &["####"],
    );
    expect(&["render", "demo", "--levels", "0"], 2, &["1 to 9"]);
    expect(
        &["render", "demo", "--levels", "3", "--out", "x.exr"],
        2,
        &["--levels", ".png"],
    );
    let of_reference = [
        "render",
        "two_spheres",
        "--levels",
        "1",
        "--backend",
        "reference",
    ];
    expect(&of_reference, 2, &["gpu and cpu"]);
    expect(&["render", "demo", "--depth", "0"], 2, &["1..=64"]);
    expect(
        &["bench", "nonsense"],
        2,
        &["frame", "motion", "structures"],
    );
    let all = format!("0..{}", u64::MAX);
    expect(&["render", "demo", "--frames", &all], 2, &["too many"]);
    let last = u64::MAX.to_string();
    expect(&["bench", "--frame", &last], 2, &["--frame", "at most"]);
    expect(&["bench", "--profile", "p.csv"], 2, &["--profile"]);
    expect(&["--scale", "2"], 2, &["0.05 to 1"]);
    expect(&["--log", "loud=very=loud", "adapters"], 2, &["warn"]);
}

#[test]
fn a_missing_scene_is_bad_input_and_the_nearest_is_told() {
    expect(
        &["render", "two_sheres"],
        1,
        &["two_sheres", "looked in", "two_spheres.ron"],
    );
    expect(&["check", "no/such/file.ron"], 1, &["no/such/file.ron"]);
    expect(&["check", "assets"], 1, &["folder"]);
}

#[test]
fn check_lists_every_problem_and_what_is_right() {
    let folder = folder("check");
    let scene = folder.join("broken.ron");
    let text = r#"(
    version: 1,
    entities: [
        (id: "good", sphere: (radius: 1)),
        (id: "bad", sphere: (radus: 1)),
        (id: "worse", sphere: (radius: -1)),
    ],
)"#;
    std::fs::write(&scene, text).expect("writable");
    let scene = scene.display().to_string();
    let words = ["broken.ron:5", "radius", "broken.ron:6", "problem"];
    expect(&["check", &scene], 1, &words);
    expect(
        &["render", &scene, "--backend", "cpu"],
        1,
        &["broken.ron:5"],
    );
    expect(&["check", "two_spheres"], 0, &["entities"]);
}

#[test]
fn rendering_twice_gives_the_same_bytes_and_resumes() {
    let folder = folder("render");
    let render = |name: &str, more: &[&str]| {
        let out = folder.join(format!("{name}_##.png")).display().to_string();
        let scene = [
            "render",
            "two_spheres",
            "--frames",
            "3..5",
            "--size",
            "64x48",
        ];
        let mut arguments = scene.to_vec();
        arguments.extend(["--backend", "cpu", "--out", &out]);
        arguments.extend(more);
        expect(&arguments, 0, &[]);
        [3, 4].map(|i| std::fs::read(folder.join(format!("{name}_0{i}.png"))).expect("a picture"))
    };
    let first = render("a", &[]);
    assert_ne!(first[0], first[1], "frames 3 and 4 are the same");
    assert_eq!(first, render("b", &[]));
    std::fs::write(folder.join("a_03.png"), b"kept").expect("writable");
    std::fs::remove_file(folder.join("a_04.png")).expect("removable");
    let resumed = render("a", &["--resume"]);
    assert_eq!(resumed, [b"kept".to_vec(), first[1].clone()]);
    let left: Vec<_> = std::fs::read_dir(&folder)
        .expect("readable")
        .flatten()
        .collect();
    assert_eq!(left.len(), 4, "something was left behind: {left:?}");
}

/// A polygon under every structure, each with triangles enough for a tree of two levels.
fn structures_scene() -> String {
    let corners: Vec<String> = (0..16)
        .map(|i| {
            let (sin, cos) = (f64::from(i) / 16.0 * std::f64::consts::TAU).sin_cos();
            format!("({}, {}, 0)", 2.0 * cos, 2.0 * sin)
        })
        .collect();
    let corners = corners.join(", ");
    let structures = ["NoTree", "Boxes4", "Boxes2", "Spheres(leaf: 2)"];
    let entities: Vec<String> = (0..)
        .zip(structures)
        .map(|(i, structure)| {
            let x = f64::from(i) * 4.6 - 6.9;
            format!(
                r#"(id: "p{i}", polygon: (corners: [{corners}]), structure: {structure}, transform: (translation: ({x}, 0, -9)))"#
            )
        })
        .collect();
    format!(
        r#"(version: 1, entities: [(id: "camera", camera: (fov: 60)), {}])"#,
        entities.join(", ")
    )
}

#[test]
fn levels_are_drawn_over_every_structure() {
    let folder = folder("levels");
    let scene = folder.join("structures.ron").display().to_string();
    std::fs::write(&scene, structures_scene()).expect("writable");
    let render = |name: &str, more: &[&str], words: &[&str]| {
        let out = folder.join(format!("{name}.png"));
        let path = out.display().to_string();
        let mut arguments = vec!["render", &scene, "--size", "160x90", "--backend", "cpu"];
        arguments.extend(["--out", &path]);
        arguments.extend(more);
        expect(&arguments, 0, words);
        image::open(out).expect("a picture").to_rgb8()
    };
    let plain = render("plain", &[], &[]);
    let leaves = render("leaves", &["--levels", "leaves"], &["boxes", "spheres"]);
    // No tree has no levels but leaves, so the first of the four is left alone.
    let second = render("second", &["--levels", "2"], &["level 2: "]);
    let deep = render("deep", &["--levels", "9"], &["level 9: nothing"]);
    let differs = |other: &image::RgbImage, quarter: u32| {
        let pixels = plain.enumerate_pixels();
        let here = pixels.filter(|(x, _, _)| x / 40 == quarter);
        here.filter(|(x, y, pixel)| other.get_pixel(*x, *y) != *pixel)
            .count()
    };
    for quarter in 0..4 {
        assert!(
            differs(&leaves, quarter) > 50,
            "leaves of polygon {quarter}"
        );
        assert_eq!(
            differs(&second, quarter) > 50,
            quarter > 0,
            "level of {quarter}"
        );
        assert_eq!(differs(&deep, quarter), 0);
    }
}

#[test]
fn a_profile_names_systems_and_passes() {
    let folder = folder("profile");
    for ending in ["csv", "json"] {
        let log = folder.join(format!("spans.{ending}")).display().to_string();
        let out = folder.join("still.exr").display().to_string();
        let arguments = [
            "render",
            "two_spheres",
            "--size",
            "32x24",
            "--backend",
            "cpu",
        ];
        let mut arguments = arguments.to_vec();
        arguments.extend(["--out", &out, "--profile", &log]);
        expect(&arguments, 0, &["still.exr"]);
        let text = std::fs::read_to_string(&log).expect("a profile");
        assert!(text.contains("propagate<GlobalTransform>"), "{text}");
        assert!(text.contains("step") && text.contains("whitted"), "{text}");
    }
    let text = std::fs::read_to_string(folder.join("spans.json")).expect("a profile");
    let events: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert!(events.as_array().is_some_and(|events| events.len() > 10));
}

#[test]
fn without_a_display_there_is_a_preview_in_files() {
    let folder = folder("preview");
    let profile = folder.join("spans.csv");
    let arguments = [
        "two_spheres",
        "--size",
        "64x36",
        "--backend",
        "cpu",
        "--profile",
    ];
    let mut arguments = arguments.to_vec();
    let log = profile.display().to_string();
    arguments.push(&log);
    let output = orrery_in(&folder, &arguments);
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(said.contains("no display"), "{said}");
    let last = said.lines().last().unwrap_or_default();
    let sheet = Path::new("frames").join("contact_sheet.png");
    assert!(last.ends_with(&sheet.display().to_string()), "{last}");
    assert!(image::open(folder.join(&sheet)).is_ok(), "no sheet");
    let entries = std::fs::read_dir(folder.join("frames")).expect("a folder");
    let mut pictures: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    pictures.retain(|path| !path.ends_with("contact_sheet.png"));
    pictures.sort();
    let [first, .., end] = pictures.as_slice() else {
        panic!("expected pictures, found {pictures:?}");
    };
    let read = |path| std::fs::read(path).expect("a picture");
    assert_ne!(read(first), read(end), "nothing moved");
    assert!(profile.is_file(), "no profile");
}

#[test]
fn a_place_that_cannot_be_written_is_bad_input() {
    let folder = folder("unwritable");
    let file = folder.join("file");
    std::fs::write(&file, b"").expect("writable");
    let out = file.join("x.png").display().to_string();
    let arguments = [
        "render",
        "two_spheres",
        "--size",
        "8x8",
        "--backend",
        "cpu",
        "--out",
        &out,
    ];
    expect(&arguments, 1, &["x.png"]);
}

#[test]
fn an_adapter_that_is_not_there_is_no_device() {
    let arguments = [
        "render",
        "two_spheres",
        "--backend",
        "gpu",
        "--adapter",
        "Riva 128",
    ];
    expect(&arguments, 3, &["Riva 128"]);
    expect(&["adapters"], 0, &["auto:"]);
}
