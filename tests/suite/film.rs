//! `orrery render --video`: pictures become a film through a program named ffmpeg; here a stand-in that notes what it was told.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

use orrery_tests::program::program;

use crate::cli::folder;

/// Renders three small frames with only this folder's programs within reach.
fn film(folder: &Path, programs: &Path) -> Output {
    Command::new(program())
        .args([
            "render",
            "two_spheres",
            "--backend",
            "cpu",
            "--size",
            "32x24",
        ])
        .args(["--frames", "2..5", "--fps", "24", "--video", "film.mp4"])
        .current_dir(folder)
        .env("PATH", programs)
        .env("ORRERY_CACHE_DIR", "")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts")
}

/// A program named ffmpeg that notes its arguments and runs `then`, in which `$last` is the last of them.
fn stand_in(programs: &Path, then: &str) {
    std::fs::create_dir_all(programs).expect("a folder for programs");
    let path = programs.join("ffmpeg");
    let script = format!(
        "#!/bin/sh\necho \"$@\" >> told.txt\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\n{then}\n"
    );
    std::fs::write(&path, script).expect("writable");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("a script");
}

#[test]
fn pictures_become_a_film_that_appears_whole() {
    let folder = folder("film");
    let programs = folder.join("bin");
    stand_in(&programs, "echo film > \"$last\"");
    let done = film(&folder, &programs);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    assert!(String::from_utf8_lossy(&done.stdout).contains("film.mp4"));
    let told = std::fs::read_to_string(folder.join("told.txt")).expect("what it was told");
    let words = "-framerate 24 -start_number 2 -i frames/frame_%04d.png -frames:v 3";
    assert!(told.contains(words), "{told}");
    assert_eq!(
        std::fs::read(folder.join("film.mp4")).expect("a film"),
        b"film\n"
    );
    assert!(folder.join("frames/frame_0004.png").is_file());
    assert!(!folder.join(".unfinished_film.mp4").exists());
}

#[test]
fn a_film_that_fails_says_why_and_leaves_the_pictures() {
    let folder = folder("film_fails");
    let programs = folder.join("bin");
    stand_in(
        &programs,
        "echo half > \"$last\"; echo 'no such codec' >&2; exit 7",
    );
    let done = film(&folder, &programs);
    assert_eq!(done.status.code(), Some(1), "{done:?}");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(
        said.contains("film.mp4") && said.contains("no such codec"),
        "{said}"
    );
    assert!(folder.join("frames/frame_0004.png").is_file());
    assert!(!folder.join("film.mp4").exists() && !folder.join(".unfinished_film.mp4").exists());
}

#[test]
fn without_the_program_nothing_is_rendered_in_vain() {
    let folder = folder("film_without");
    let done = film(&folder, &folder.join("nothing"));
    assert_eq!(done.status.code(), Some(2), "{done:?}");
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(said.contains("install"), "{said}");
    assert!(!folder.join("frames").exists());
}
