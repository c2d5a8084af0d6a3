//! The benchmark `import`: every file of folders that others made to trip importers up. Each is read or refused with a
//! reason; a panic, too long a time or too much memory is a mistake of ours.
//!
//! The files do not come along; folders that are not there are skipped with a note.

use std::path::{Path, PathBuf};
use std::time::Instant;

use orrery_engine::import::{self, import};

use super::report::{Better, Report, Row};
use crate::args::{BenchRequest, Common};
use crate::failure::Failure;
use crate::output::{note, progress};

/// Where the folders are unless it is said otherwise.
const FOLDER: &str = "../shared/scenes";
/// Folders of files that are odd, broken or traps.
const FOLDERS: [&str; 6] = [
    "ufbx-fbx",
    "assimp-models",
    "tinyobj-models",
    "tobj-models",
    "trimesh-models",
    "manifold-meshes",
];
/// In the names of files that must be refused.
const MUST_FAIL: &str = "_fail";
/// What any file may take.
const MOST_SECS: f64 = 10.0;
/// What reading any file may add to the most memory held, MiB.
const MOST_MIB: f64 = 1024.0;
/// Ends the names of rows that count panics, files that should have been refused, and the bounds.
const MUST: [&str; 4] = ["panics", "wrongly loaded", "worst time", "worst memory"];

/// What became of a file.
struct Outcome {
    path: PathBuf,
    /// Triangles and warnings, or the reason why it was refused.
    result: Result<(usize, Vec<String>), String>,
    secs: f64,
    /// None: this system does not tell.
    mib: Option<f64>,
}

impl Outcome {
    fn panicked(&self) -> bool {
        matches!(&self.result, Err(why) if import::is_of_a_panic(why))
    }

    fn wrongly_loaded(&self) -> bool {
        let name = self.path.to_string_lossy();
        self.result.is_ok() && name.contains(MUST_FAIL)
    }
}

/// Whether a row of that name must be as it should.
pub fn must_be_met(row: &str) -> bool {
    MUST.iter().any(|end| row.ends_with(end))
}

/// Reads every file of every folder that is there, one after the other.
pub fn run(request: &BenchRequest, _: &Common) -> Result<Report, Failure> {
    let folder = request
        .files
        .clone()
        .unwrap_or_else(|| PathBuf::from(FOLDER));
    let (mut rows, mut all) = (Vec::new(), Vec::new());
    for name in FOLDERS {
        let files = files_below(&folder.join(name));
        if files.is_empty() {
            note(format_args!("{name}: not in {}; skipped", folder.display()));
            continue;
        }
        let (models, others): (Vec<PathBuf>, Vec<PathBuf>) =
            files.into_iter().partition(|path| import::is_model(path));
        let bar = progress(models.len() as u64, name);
        let mut outcomes = Vec::with_capacity(models.len());
        for path in models {
            outcomes.push(outcome(path));
            bar.inc(1);
        }
        bar.finish_and_clear();
        rows.extend(rows_of(name, &outcomes, others.len()));
        all.extend(outcomes);
    }
    if all.is_empty() {
        return Err(Failure::Input(format!(
            "{}: none of the folders {} is there; expected the folder of these after `--files`",
            folder.display(),
            FOLDERS.join(", ")
        )));
    }
    if let Some(report) = &request.report {
        write_list(report, &folder, &all)?;
    }
    Ok(Report {
        rows,
        remarks: remarks(&all),
        ..Report::new("import", &["the importers, one file at a time".to_owned()])
    })
}

fn outcome(path: PathBuf) -> Outcome {
    let before = memory::reset_peak();
    let start = Instant::now();
    let model = import(&path);
    let secs = start.elapsed().as_secs_f64();
    let after = memory::peak_mib();
    Outcome {
        result: model.map(|model| (model.triangles(), model.warnings.sentences())),
        path,
        secs,
        mib: before
            .zip(after)
            .map(|(before, after)| (after - before).max(0.0)),
    }
}

fn rows_of(name: &str, outcomes: &[Outcome], others: usize) -> Vec<Row> {
    let count = |what: &str, better, count: usize| {
        Row::single(format!("{name}.{what}"), "files", better, count as f64)
    };
    let number = |wanted: fn(&Outcome) -> bool| outcomes.iter().filter(|o| wanted(o)).count();
    let worst = |value: fn(&Outcome) -> Option<f64>| {
        let values = outcomes.iter().filter_map(value);
        values.reduce(f64::max)
    };
    let mut rows = vec![
        count("of other formats", Better::Lower, others),
        count("tried", Better::Higher, outcomes.len()),
        count("loaded", Better::Higher, number(|o| o.result.is_ok())),
        count("refused", Better::Lower, number(|o| o.result.is_err())),
        count("panics", Better::Lower, number(Outcome::panicked)).with_target(0.0),
        count(
            "wrongly loaded",
            Better::Lower,
            number(Outcome::wrongly_loaded),
        )
        .with_target(0.0),
    ];
    let bounds = [
        ("worst time", "s", MOST_SECS, worst(|o| Some(o.secs))),
        ("worst memory", "MiB", MOST_MIB, worst(|o| o.mib)),
    ];
    for (what, unit, most, value) in bounds {
        let row = |value| Row::single(format!("{name}.{what}"), unit, Better::Lower, value);
        rows.extend(value.map(|value| row(value).with_target(most)));
    }
    rows
}

/// Every file that was refused, with the reason.
fn remarks(all: &[Outcome]) -> Vec<String> {
    let refused = all.iter().filter_map(|outcome| {
        let why = outcome.result.as_ref().err()?;
        Some(format!("refused: {}: {why}", outcome.path.display()))
    });
    refused.collect()
}

/// Writes what became of each file as a table with tabs between.
fn write_list(report: &Path, folder: &Path, all: &[Outcome]) -> Result<(), Failure> {
    let mut text = "file\tresult\ttriangles\tms\tMiB\treason or warnings\n".to_owned();
    for outcome in all {
        let path = outcome.path.strip_prefix(folder).unwrap_or(&outcome.path);
        let (result, triangles, said) = match &outcome.result {
            Ok((triangles, warnings)) => ("loaded", triangles.to_string(), warnings.join("; ")),
            Err(why) => ("refused", String::new(), why.clone()),
        };
        let memory = outcome.mib.map_or(String::new(), |mib| format!("{mib:.1}"));
        let said = said.replace(['\t', '\n'], " ");
        text += &format!(
            "{}\t{result}\t{triangles}\t{:.2}\t{memory}\t{said}\n",
            path.display(),
            outcome.secs * 1e3
        );
    }
    let path = report.join("import.tsv");
    let written = std::fs::create_dir_all(report).and_then(|()| std::fs::write(&path, text));
    written.map_err(|error| {
        Failure::Input(format!(
            "{}: cannot write the list: {error}",
            path.display()
        ))
    })
}

/// Files below a folder, in order; none where it is not there.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
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

/// The most memory this program held, where the system tells (Linux's `/proc`).
mod memory {
    use std::fs;

    /// Starts anew from what is held now, MiB.
    pub fn reset_peak() -> Option<f64> {
        fs::write("/proc/self/clear_refs", "5").ok()?;
        peak_mib()
    }

    /// Since the last reset, MiB.
    pub fn peak_mib() -> Option<f64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
        let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kib / 1024.0)
    }
}
