//! `orrery check`: every problem of a scene file, and what is right in it.

use std::path::Path;

use crate::assets::find_scene;
use crate::failure::Failure;
use crate::output::say;

/// Checks a file; bad ones fail after everything was said.
pub fn run(file: &Path) -> Result<(), Failure> {
    let path = find_scene(file)?;
    let report = orrery_engine::scene::check(&path);
    for problem in &report.problems.0 {
        say(problem);
    }
    for warning in &report.warnings {
        say(format_args!("{warning} (a warning)"));
    }
    say(format_args!("{}: {}", path.display(), report.summary));
    match report.problems.0.len() {
        0 => Ok(()),
        1 => Err(Failure::Input("1 problem".into())),
        count => Err(Failure::Input(format!("{count} problems"))),
    }
}
