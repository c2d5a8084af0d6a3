//! What is said to the user: results to stdout, complaints and progress to stderr.
//!
//! A closed pipe (`orrery adapters | head -1`) ends the talking, never the program.

use std::fmt::Display;
use std::io::{Write, stderr, stdout};

use indicatif::{ProgressBar, ProgressStyle};

/// A line of result.
pub fn say(line: impl Display) {
    // A reader that went away is no failure of the command.
    let _ = writeln!(stdout(), "{line}");
}

/// A line about how the command is done.
pub fn note(line: impl Display) {
    let _ = writeln!(stderr(), "{line}");
}

/// Why the command failed.
pub fn complain(why: impl Display) {
    let _ = writeln!(stderr(), "orrery: {why}");
}

/// A progress bar of `count` steps called `what`; silent where stderr is no terminal.
pub fn progress(count: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(count);
    let style = ProgressStyle::with_template(
        "{msg} {wide_bar} {pos}/{len}  {elapsed_precise} gone, {eta_precise} to go",
    );
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}
