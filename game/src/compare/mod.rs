//! `orrery compare A B`: two captures side by side; a regression past the limit is exit code 1.

mod rows;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use orrery_engine::profile::export::capture::{Capture, read};

use self::rows::{Kind, Row, rows};
use crate::args::CompareRequest;
use crate::failure::Failure;
use crate::output::{note, say};

/// With fewer frames a median is one frame's mood.
const ENOUGH_FRAMES: usize = 20;

/// Compares what was asked for.
pub fn run(request: &CompareRequest) -> Result<(), Failure> {
    let a = open(&request.a)?;
    let b = open(&request.b)?;
    for (name, path, capture) in [("A", &request.a, &a), ("B", &request.b, &b)] {
        let count = capture.frames.len();
        say(format_args!(
            "{name}  {}: {count} frames on {}",
            path.display(),
            capture.device
        ));
        if count < ENOUGH_FRAMES {
            note(format_args!(
                "note: {} has {count} frames; of fewer than {ENOUGH_FRAMES}, medians say little",
                path.display()
            ));
        }
    }
    if a.device != b.device {
        note("note: the captures are of different devices");
    }
    let rows = rows(&a, &b, request.limit);
    print(&rows, request.all);
    let worse: Vec<&Row> = rows.iter().filter(|row| row.is_regression).collect();
    let limit = request.limit;
    match worse.as_slice() {
        [] => {
            say(format_args!("no regression past {limit} %"));
            Ok(())
        }
        [first, ..] => Err(Failure::Missed(format!(
            "{} past {limit} %, first of all {}: {}",
            match worse.len() {
                1 => "a regression".to_owned(),
                count => format!("{count} regressions"),
            },
            first.name,
            first.change()
        ))),
    }
}

fn open(path: &Path) -> Result<Capture, Failure> {
    let bad = |why: String| Failure::Input(format!("{}: {why}", path.display()));
    if path.is_dir() {
        return Err(bad(
            "a folder; expected a file that `--profile NAME.cap` wrote".into(),
        ));
    }
    let file = File::open(path).map_err(|error| bad(format!("cannot be opened: {error}")))?;
    read(BufReader::new(file)).map_err(|error| bad(error.to_string()))
}

fn print(rows: &[Row], all: bool) {
    let shown: Vec<&Row> = rows.iter().filter(|row| all || row.is_notable).collect();
    let widest = shown.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let wide = widest.max(12) + 2;
    say(format_args!(
        "{:<8}{:<wide$}{:>12}{:>12}{:>10}{:>12}{:>12}",
        "", "median, ms", "A", "B", "B / A", "A 95 %", "B 95 %"
    ));
    for row in &shown {
        let kind = row.kind.word();
        let [a, b] = row.medians.map(|value| row.kind.value(value));
        let [a95, b95] = row.p95.map(|value| row.kind.value(value));
        let mark = if row.is_regression {
            "  REGRESSION"
        } else {
            ""
        };
        let (name, change) = (&row.name, row.ratio_in_words());
        say(format_args!(
            "{kind:<8}{name:<wide$}{a:>12}{b:>12}{change:>10}{a95:>12}{b95:>12}{mark}"
        ));
    }
    let left_out = rows.len() - shown.len();
    if left_out > 0 {
        say(format_args!(
            "{left_out} rows that hardly differ are left out; `--all` has them"
        ));
    }
    debug_assert!(rows.first().is_none_or(|row| row.kind == Kind::Frame));
}
