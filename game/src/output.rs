//! What is said to the user: results to stdout, complaints and progress to stderr.
//!
//! A closed pipe (`orrery adapters | head -1`) ends the talking, never the program.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr, stdout};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use orrery_engine::import::Progress;

/// What takes less needs no bar.
const PATIENCE: Duration = Duration::from_millis(300);
/// Between two looks at how far it is.
const LOOK: Duration = Duration::from_millis(100);

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

/// Does what tells of its progress; a bar shows it where it takes long and stderr is a terminal.
pub fn watch<T>(progress: &Progress, work: impl FnOnce() -> T) -> T {
    if !stderr().is_terminal() {
        return work();
    }
    let (done, is_done) = mpsc::channel();
    thread::scope(|scope| {
        scope.spawn(move || show(progress, &is_done));
        let result = work();
        drop::<mpsc::Sender<()>>(done);
        result
    })
}

/// Shows the steps of a progress until the other end of the channel is gone.
fn show(progress: &Progress, is_done: &Receiver<()>) {
    let waits = |time| is_done.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
    if !waits(PATIENCE) {
        return;
    }
    let bar = ProgressBar::no_length();
    let spinner = ProgressStyle::with_template("{spinner} {msg}  {elapsed} gone");
    let share = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}  {elapsed} gone");
    while waits(LOOK) {
        let step = progress.now();
        let style = if step.count > 1 { &share } else { &spinner };
        if let Ok(style) = style {
            bar.set_style(style.clone());
        }
        bar.set_length(step.count as u64);
        bar.set_position(step.done as u64);
        bar.set_message(step.what);
        bar.tick();
    }
    bar.finish_and_clear();
}
