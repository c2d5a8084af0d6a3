//! The program `orrery`, for tests that run it from outside.

use std::path::PathBuf;

/// The built program, beside the calling test's own.
///
/// # Panics
/// If it is not there: tests fail then, they do not pass unrun.
pub fn program() -> PathBuf {
    let suite = std::env::current_exe().expect("this program's path");
    let folder = suite.ancestors().nth(2).expect("target/release");
    let program = folder
        .join("orrery")
        .with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        program.is_file(),
        "{} is not there; `cargo build --release` makes it (tests/run does)",
        program.display()
    );
    program
}
