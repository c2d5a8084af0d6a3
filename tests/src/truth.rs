//! The ground-truth run: scenes of the set traced, measured against their reference pictures, judged.
//!
//! Who calls it: the program `ground_truth`, and the suite. A scene the engine cannot trace is a row that
//! says so and counts as missed; none is left out silently.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::present::write_png16_linear;
use orrery_engine::trace::{Backend, Picture, Tracer};

use crate::metrics::{Metrics, Pixels, QUANTUM, compare, edge_mask, every_edge, leaks};
use crate::scene_json::{self, SceneError, TruthScene};
use crate::tracers;

/// A folder of the form of the set: `scenes/*.json`, `reference/*.png`, `ambiguous_pixels.json`.
pub struct TruthSet {
    folder: PathBuf,
    ambiguous: BTreeMap<String, Vec<[u32; 2]>>,
}

/// How to run.
#[derive(Clone, Debug)]
pub struct TruthRun {
    /// Where pictures go as `NAME.png`, 16-bit linear; none: nowhere.
    pub out: Option<PathBuf>,
    /// Trace every n-th pixel across and down (odd, dividing the size): the very rays of the full picture
    /// through those pixels' centres. 1 is the whole picture.
    pub every: u32,
}

/// What became of a scene.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// What was measured.
    pub outcome: Outcome,
    /// What was missed; empty: every target is met.
    pub missed: Vec<String>,
}

/// What was measured.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Against a picture; `identical` says whether a moved scene gave its base's picture bit for bit.
    Compared {
        /// The measures.
        metrics: Metrics,
        /// Present where bit equality with the base scene is asked for.
        identical: Option<bool>,
    },
    /// Background seen through a closed scene.
    Leaks(usize),
    /// Not traced, and why.
    Failed(String),
}

impl TruthSet {
    /// Opens a folder.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub fn open(folder: &Path) -> Result<Self, String> {
        if !folder.join("scenes").is_dir() {
            return Err(format!(
                "{}: expected a folder `scenes` of JSON files in it",
                folder.display()
            ));
        }
        let list = folder.join("ambiguous_pixels.json");
        let ambiguous = match std::fs::read_to_string(&list) {
            Ok(text) => {
                serde_json::from_str(&text).map_err(|e| format!("{}: {e}", list.display()))?
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => BTreeMap::new(),
            Err(error) => return Err(format!("{}: {error}", list.display())),
        };
        Ok(Self {
            folder: folder.to_path_buf(),
            ambiguous,
        })
    }

    /// Names of all scenes, in order.
    ///
    /// # Errors
    /// A sentence, if the folder cannot be read.
    pub fn names(&self) -> Result<Vec<String>, String> {
        let scenes = self.folder.join("scenes");
        let entries =
            std::fs::read_dir(&scenes).map_err(|e| format!("{}: {e}", scenes.display()))?;
        let mut names: Vec<String> = entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|e| e == "json"))
            .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
            .collect();
        names.sort();
        Ok(names)
    }

    /// Traces and judges one scene.
    pub fn run(&self, name: &str, tracer: &mut dyn Tracer, run: &TruthRun) -> Row {
        let outcome = self
            .measure(name, tracer, run)
            .unwrap_or_else(Outcome::Failed);
        Row {
            missed: missed(name, tracer.backend(), &outcome),
            name: name.to_owned(),
            outcome,
        }
    }

    fn read(&self, name: &str) -> Result<TruthScene, String> {
        let path = self.folder.join("scenes").join(format!("{name}.json"));
        scene_json::read(&path).map_err(|error| match error {
            SceneError::NotSupported(shapes) => format!("not supported: {shapes}"),
            SceneError::Broken(why) => why,
        })
    }

    fn measure(
        &self,
        name: &str,
        tracer: &mut dyn Tracer,
        run: &TruthRun,
    ) -> Result<Outcome, String> {
        let scene = self.read(name)?;
        let picture = trace(tracer, &scene, run.every)?;
        if let Some(out) = &run.out {
            write_png16_linear(&out.join(format!("{name}.png")), &picture)
                .map_err(|error| error.to_string())?;
        }
        let test = Pixels::of_16_bit(&picture);
        if scene.is_leak_test {
            return Ok(Outcome::Leaks(leaks(
                &test,
                scene.frame.background.horizon.as_dvec3(),
            )));
        }
        let base = scene.invariant_with.as_deref().unwrap_or(name);
        let path = self.folder.join("reference").join(format!("{base}.png"));
        let whole = Pixels::read_png(&path)?;
        let size = UVec2::new(picture.size.x, picture.size.y) * run.every;
        if whole.size != size {
            return Err(format!(
                "{} is {}x{}, but the scene says {}x{}",
                path.display(),
                whole.size.x,
                whole.size.y,
                size.x,
                size.y
            ));
        }
        let edges = every_edge(&edge_mask(&whole), size, run.every);
        let identical = match bit_identical_base(&scene) {
            Some(base) => Some(trace(tracer, &self.read(base)?, run.every)? == picture),
            None => None,
        };
        Ok(Outcome::Compared {
            metrics: compare(
                &test,
                &whole.every(run.every),
                &edges,
                &self.ambiguous(base, run.every),
            ),
            identical,
        })
    }

    /// The pixels on which two double-precision tracers disagree, as far as they are traced.
    fn ambiguous(&self, base: &str, every: u32) -> Vec<UVec2> {
        let pixels = self.ambiguous.get(base).map_or(&[][..], Vec::as_slice);
        let centre = UVec2::splat(every / 2);
        pixels
            .iter()
            .map(|&pixel| UVec2::from(pixel))
            .filter(|&pixel| pixel % every == centre)
            .map(|pixel| pixel / every)
            .collect()
    }
}

fn trace(tracer: &mut dyn Tracer, scene: &TruthScene, every: u32) -> Result<Picture, String> {
    let settings = TraceSettings {
        size: scene.size / every,
        ..TraceSettings::default()
    };
    tracers::picture(tracer, &scene.frame, &settings).map_err(|error| error.to_string())
}

/// The scene whose picture this one must give bit for bit: it is the same, moved by what f64 holds exactly.
fn bit_identical_base(scene: &TruthScene) -> Option<&str> {
    scene
        .name
        .contains("_far_")
        .then_some(scene.invariant_with.as_deref()?)
}

/// The targets that an outcome misses, in words.
fn missed(name: &str, backend: Backend, outcome: &Outcome) -> Vec<String> {
    let (metrics, identical) = match outcome {
        Outcome::Failed(_) => return vec!["not traced".to_owned()],
        Outcome::Leaks(0) => return Vec::new(),
        Outcome::Leaks(count) => return vec![format!("{count} leaks > 0")],
        Outcome::Compared { metrics, identical } => (metrics, identical),
    };
    let deep_glass = name.starts_with("s07") || name.starts_with("s08");
    let mut missed = Vec::new();
    let mut limit = |what: &str, value: f64, limit: f64| {
        if value > limit {
            missed.push(format!("{what} {value:.3e} > {limit:.1e}"));
        }
    };
    limit("non_finite", metrics.non_finite as f64, 0.0);
    if backend == Backend::Reference {
        // A step of the 16-bit file, and what f64 rounds of it.
        limit("max", metrics.max, QUANTUM * (1.0 + 1e-9));
    } else if deep_glass {
        limit("mismatch_ppm", metrics.mismatch_ppm, 500.0);
        limit("p99.9", metrics.p999, 1e-3);
    } else {
        limit("mismatch_ppm", metrics.mismatch_ppm, 20.0);
        limit("mismatch_flat", metrics.mismatch_flat as f64, 0.0);
        limit("p99.9_flat", metrics.p999_flat, 3e-5);
    }
    if *identical == Some(false) {
        missed.push("not bit-identical to its base".to_owned());
    }
    missed
}

impl Row {
    /// The names over the columns of a printed row.
    pub fn head() -> String {
        format!(
            "{:<18}{:>11}{:>14}{:>14}{:>12}{:>12}{:>12}{:>12}  targets",
            "scene",
            "non_finite",
            "mismatch_ppm",
            "mismatch_flat",
            "p99.9",
            "p99.9_flat",
            "max",
            "relMSE"
        )
    }

    /// Whether every target is met.
    pub fn is_met(&self) -> bool {
        self.missed.is_empty()
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<18}", self.name)?;
        match &self.outcome {
            Outcome::Compared { metrics: m, .. } => write!(
                f,
                "{:>11}{:>14.2}{:>14}{:>12.2e}{:>12.2e}{:>12.2e}{:>12.2e}",
                m.non_finite,
                m.mismatch_ppm,
                m.mismatch_flat,
                m.p999,
                m.p999_flat,
                m.max,
                m.relative_mse
            )?,
            Outcome::Leaks(count) => write!(f, " leak pixels: {count}")?,
            Outcome::Failed(why) => write!(f, " {why}")?,
        }
        if self.is_met() {
            write!(f, "  met")
        } else {
            write!(f, "  MISSED: {}", self.missed.join(", "))
        }
    }
}
