//! `--rival PROGRAM`: other people's trees on the same boxes and triangles, in the same sitting.
//!
//! A program is given the folders of dumps (the format of [`crate::bench::dump`], without rays) and prints a line of
//! `key=value` words for each measurement, of which `scene`, `threads`, `build` and `commit_ms`, `update_ms` or
//! `ms` (and of the fastest run `commit_min_ms`, `min_ms`) are read here. `--dump` keeps the folders.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use orrery_engine::frame::FrameScene;

use crate::args::BenchRequest;
use crate::bench::dump;
use crate::bench::report::{Better, Row};
use crate::bench::work::Work;
use crate::failure::Failure;
use crate::output::note;

/// What a tree over instances may take of a rival's time.
const TREE_TARGET: f64 = 0.2;
/// What a refit of a mesh may take of a rival's time.
const REFIT_TARGET: f64 = 0.4;

/// Dumps for rivals.
pub struct Rivals {
    programs: Vec<PathBuf>,
    folder: PathBuf,
    /// The folder goes when this does.
    is_temporary: bool,
    scenes: Vec<String>,
}

impl Drop for Rivals {
    fn drop(&mut self) {
        if self.is_temporary {
            // Nobody is told: the rows are there, and the system's folder for such files is cleared anyway.
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// A line of a rival.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    scene: String,
    threads: String,
    build: String,
    millis: f64,
    /// Of the fastest run: what is left of it when other programs share the machine.
    least: Option<f64>,
}

impl Rivals {
    /// None where neither rivals nor dumps are asked for.
    pub fn of(request: &BenchRequest) -> Option<Self> {
        let is_temporary = request.dump.is_none();
        (!request.rival.is_empty() || !is_temporary).then(|| Self {
            programs: request.rival.clone(),
            folder: request.dump.clone().unwrap_or_else(|| {
                std::env::temp_dir().join(format!("orrery_bench_{}", std::process::id()))
            }),
            is_temporary,
            scenes: Vec::new(),
        })
    }

    /// Writes a frame's geometry.
    pub fn add(&mut self, name: &str, scene: &FrameScene) -> Result<(), Failure> {
        let work = Work::of(scene).map_err(Failure::Input)?;
        dump::write_geometry(&self.folder.join(name), name, &work)?;
        self.scenes.push(name.to_owned());
        Ok(())
    }

    /// Runs each program on all dumps; its rows, with the ratio of `ours` to them.
    pub fn run(&self, ours: &[Row]) -> Result<Vec<Row>, Failure> {
        let mut rows = Vec::new();
        for program in &self.programs {
            note(format_args!("rival: {}", program.display()));
            let output = Command::new(program)
                .args(self.scenes.iter().map(|scene| self.folder.join(scene)))
                .output()
                .map_err(|error| refused(program, &error.to_string()))?;
            if !output.status.success() {
                let said = String::from_utf8_lossy(&output.stderr);
                return Err(refused(program, said.trim()));
            }
            let text = String::from_utf8_lossy(&output.stdout);
            let name = program
                .file_stem()
                .map_or("rival".into(), |stem| stem.to_string_lossy());
            rows.extend(rows_of(&name, &text, ours));
        }
        Ok(rows)
    }
}

fn refused(program: &Path, why: &str) -> Failure {
    Failure::Input(format!(
        "--rival {}: expected a program that takes folders of dumps and prints key=value lines: {why}",
        program.display()
    ))
}

/// A rival's own rows, then ours over the best of its that does the same.
fn rows_of(rival: &str, text: &str, ours: &[Row]) -> Vec<Row> {
    let lines = text.lines().filter_map(parse);
    let lines: Vec<Line> = lines.filter(|line| line.kind().is_some()).collect();
    let name = |line: &Line, what: &str| format!("{rival}.{}.{}.{what}", line.scene, line.threads);
    let mut rows: Vec<Row> = lines
        .iter()
        .map(|line| Row::single(name(line, &line.build), "ms", Better::Lower, line.millis))
        .collect();
    let mut best: HashMap<(&str, &str, &str), &Line> = HashMap::new();
    for line in &lines {
        let Some(kind) = line.kind().filter(|_| line.is_update()) else {
            continue;
        };
        let key = (kind, line.scene.as_str(), line.threads.as_str());
        let least = best.entry(key).or_insert(line);
        if line.millis < least.millis {
            *least = line;
        }
    }
    let mut pairs: Vec<_> = best.into_iter().collect();
    pairs.sort_unstable_by_key(|(key, _)| *key);
    for ((kind, scene, threads), line) in pairs {
        let (works, target) = match kind {
            "tree" => (&["update", "refit", "rebuild"][..], TREE_TARGET),
            _ => (&["refit", "deform_refit"][..], REFIT_TARGET),
        };
        for &work in works {
            let mine = format!("{}.{threads}.{work}", own_name(kind, scene));
            let Some(mine) = ours.iter().find(|row| row.name == mine) else {
                continue;
            };
            let what = format!("{work}_over_{}", line.build);
            let ratio = Row::single(
                name(line, &what),
                "1",
                Better::Lower,
                mine.value / line.millis,
            );
            // What is chosen is held against the target; the rest shows why.
            rows.push(if work == works[0] {
                ratio.with_target(target)
            } else {
                ratio
            });
            if let (Some(mine), Some(least)) = (mine.p05, line.least) {
                let what = format!("{what}.least");
                rows.push(Row::single(
                    name(line, &what),
                    "1",
                    Better::Lower,
                    mine / least,
                ));
            }
        }
    }
    rows
}

impl Line {
    /// What is built: a tree over the instances of a crowd, or that of a large mesh. None: what is of no account.
    fn kind(&self) -> Option<&'static str> {
        let of_crowd = self.scene.starts_with("meshes.");
        match (of_crowd, self.build.starts_with("tlas")) {
            (true, true) => Some("tree"),
            (false, false) => Some("mesh"),
            _ => None,
        }
    }

    /// Whether it follows what moved; a mesh's may be built, too, which is shown but is not our refit's rival.
    fn is_update(&self) -> bool {
        self.build.starts_with("tlas") || self.build == "mesh_refit"
    }
}

/// What our rows of a dumped scene begin with.
fn own_name(kind: &str, scene: &str) -> String {
    match kind {
        "tree" => format!("tree.{scene}"),
        _ => scene.to_owned(),
    }
}

/// Reads the words of a line; none: it is not about building.
fn parse(line: &str) -> Option<Line> {
    let words: HashMap<&str, &str> = line
        .split_whitespace()
        .filter_map(|word| word.split_once('='))
        .collect();
    let number = |keys: &[&str]| -> Option<f64> {
        let word = keys.iter().find_map(|key| words.get(key))?;
        word.parse().ok()
    };
    Some(Line {
        scene: (*words.get("scene")?).to_owned(),
        threads: words
            .get("threads")
            .map_or("device".into(), |threads| format!("{threads}t")),
        build: (*words.get("build")?).to_owned(),
        millis: number(&["commit_ms", "update_ms", "ms"])?,
        least: number(&["commit_min_ms", "min_ms"]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rival_is_compared_by_its_best() {
        let text = "embree version=4\n\
            embree scene=meshes.10 threads=1 build=tlas_a instances=10 set_ms=9 commit_ms=4.0\n\
            embree scene=meshes.10 threads=1 build=tlas_b instances=10 set_ms=9 commit_ms=2.0\n\
            embree scene=mesh.99 threads=2 build=mesh_refit ms=10 min_ms=9\n\
            embree scene=mesh.99 threads=2 build=mesh_low ms=1 min_ms=1\n";
        let mine = |name: &str, value| Row {
            p05: Some(0.75 * value),
            ..Row::single(name, "ms", Better::Lower, value)
        };
        let ours = [
            mine("tree.meshes.10.1t.update", 0.5),
            mine("mesh.99.2t.refit", 3.0),
        ];
        let rows = rows_of("embree", text, &ours);
        let value = |name: &str| {
            rows.iter()
                .find(|row| row.name == name)
                .map(|row| row.value)
        };
        assert_eq!(value("embree.meshes.10.1t.tlas_a"), Some(4.0));
        assert_eq!(value("embree.meshes.10.1t.update_over_tlas_b"), Some(0.25));
        assert_eq!(value("embree.mesh.99.2t.refit_over_mesh_refit"), Some(0.3));
        let least = value("embree.mesh.99.2t.refit_over_mesh_refit.least");
        assert_eq!(least, Some(0.25));
        assert_eq!(rows.len(), 7);
    }
}
