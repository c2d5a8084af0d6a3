//! The benchmark `start`: how long large scenes take from file to ready to trace, at the first start and, with what that
//! left in the cache, at the second.
//!
//! Timed is all between the name of a file and the first ray: reading, parsing, welding, smoothing, entities, trees, packed rows.
//! What a device and its pipelines take is apart. The system has the files themselves in memory at either start. BART's scenes do not
//! come along; those that are not in the folder are skipped with a note.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::import::{Cache, Loader};

use super::frame::backends;
use super::hills::hills;
use super::report::{Better, Report, Row};
use super::timing::{median, millis_row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::assets::is_there;
use crate::failure::Failure;
use crate::output::progress;
use crate::{device, stage};

/// Where the files are unless it is said otherwise.
const FOLDER: &str = "../shared/scenes";
/// Scenes and their files there.
const SCENES: [(&str, &str); 3] = [
    ("kitchen", "bart-aff/kitchen/kitchen.aff"),
    ("robots", "bart-aff/robots/Robot.aff"),
    ("museum", "bart-aff/museum/museum5.aff"),
];
/// Of the mesh that is made here.
const TRIANGLES: usize = 1_200_000;
/// Of a short run.
const SMALL_TRIANGLES: usize = 20_000;
/// Starts of each kind.
const STARTS: u64 = 7;
/// Of a short run.
const SMALL_STARTS: u64 = 2;
/// How many times as fast the second start of the first scene should be.
const TARGET: f64 = 5.0;

/// Starts every scene that is there.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let folder = request
        .files
        .clone()
        .unwrap_or_else(|| PathBuf::from(FOLDER));
    let room = Room::new()?;
    let (triangles, starts) = match request.small {
        true => (SMALL_TRIANGLES, SMALL_STARTS),
        false => (TRIANGLES, STARTS),
    };
    let mut scenes: Vec<(&str, PathBuf)> = SCENES
        .map(|(name, file)| (name, folder.join(file)))
        .into_iter()
        .filter(|(name, file)| is_there(name, file))
        .collect();
    scenes.push(("hills", room.hills(triangles)?));
    let mut rows = Vec::new();
    let mut devices = Vec::new();
    for choice in backends(common) {
        let begun = Instant::now();
        devices.push(device::open_choice(choice, common)?.device());
        let millis = begun.elapsed().as_secs_f64() * 1e3;
        let name = format!("device and pipelines of {choice:?}").to_lowercase();
        rows.push(Row::single(name, "ms", Better::Lower, millis));
    }
    let bar = progress(scenes.len() as u64 * starts, "start");
    for (name, file) in &scenes {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        // The fewest: a start that found nothing was no second one.
        let mut fewest = usize::MAX;
        for _ in 0..starts {
            room.empty();
            first.push(start(file, common, &room)?.0);
            let (times, found) = start(file, common, &room)?;
            second.push(times);
            fewest = fewest.min(found);
            bar.inc(1);
        }
        rows.extend(rows_of(name, &first, &second));
        let kept = room.kept() as f64 / f64::from(1 << 20);
        let row =
            |what, unit, better, value| Row::single(format!("{name}.{what}"), unit, better, value);
        rows.push(row("second.found", "models", Better::Higher, fewest as f64));
        rows.push(row("kept", "MiB", Better::Lower, kept));
    }
    bar.finish_and_clear();
    Ok(Report {
        rows,
        remarks: vec![
            "file to ready to trace; `load` is reading to entities, `rest` the first frame without its rays".into(),
        ],
        ..Report::new("start", &devices)
    })
}

/// Milliseconds of a start until its entities are there, and from then on.
type Times = [f64; 2];

fn rows_of(name: &str, first: &[Times], second: &[Times]) -> Vec<Row> {
    let all = |times: &[Times]| -> Vec<f64> { times.iter().map(|t| t[0] + t[1]).collect() };
    let ratio = median(&all(first)) / median(&all(second));
    let mut rows = Vec::new();
    for (which, times) in [("first", first), ("second", second)] {
        rows.push(millis_row(format!("{name}.{which}"), &all(times)));
        for (part, what) in ["load", "rest"].iter().enumerate() {
            let times: Vec<f64> = times.iter().map(|t| t[part]).collect();
            rows.push(millis_row(format!("{name}.{which}.{what}"), &times));
        }
    }
    let row = Row::single(format!("{name}.ratio"), "times", Better::Higher, ratio);
    rows.push(if name == SCENES[0].0 {
        row.with_target(TARGET)
    } else {
        row
    });
    rows
}

/// Loads a scene and makes all ready for its first picture; with how many of its models the cache had.
fn start(file: &Path, common: &Common, room: &Room) -> Result<(Times, usize), Failure> {
    let mut tracer = device::open_choice(BackendChoice::Cpu, common)?;
    let begun = Instant::now();
    let mut cache = Cache::in_folder(room.cache());
    // Short runs are about that it works.
    cache.least = Duration::ZERO;
    let loader = Loader {
        cache: Some(cache),
        ..Loader::default()
    };
    let progress = loader.progress.clone();
    let (mut engine, _) = stage::load(file, common, (UVec2::ONE, 1.0), loader)?;
    let load = begun.elapsed();
    engine.frame();
    let world = &engine.world;
    let scene = world.resource::<FrameScene>();
    tracer.refit(scene)?;
    tracer.upload(scene, world.resource::<TraceSettings>())?;
    let rest = begun.elapsed() - load;
    let times = [load, rest].map(|time| time.as_secs_f64() * 1e3);
    Ok((times, progress.now().found))
}

/// A folder for what is made here; it goes when this does.
struct Room(PathBuf);

impl Room {
    fn new() -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("orrery_start_{}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|error| unwritable(&folder, &error))?;
        Ok(Self(folder))
    }

    fn cache(&self) -> PathBuf {
        self.0.join("cache")
    }

    /// Forgets what starts left.
    fn empty(&self) {
        // It is not there before the first.
        let _ = fs::remove_dir_all(self.cache());
    }

    /// Bytes that a start left.
    fn kept(&self) -> u64 {
        let files = fs::read_dir(self.cache()).into_iter().flatten().flatten();
        let sizes = files.filter_map(|file| Some(file.metadata().ok()?.len()));
        sizes.sum()
    }

    /// An OBJ file of a height field.
    fn hills(&self, triangles: usize) -> Result<PathBuf, Failure> {
        let mesh = hills(triangles).map_err(Failure::Input)?;
        let mut text = String::new();
        for v in &mesh.vertices {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {:.6} {:.6} {:.6}", v.x, v.y, v.z);
        }
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|corner| corner + 1)) {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        let file = self.0.join("hills.obj");
        fs::write(&file, text).map_err(|error| unwritable(&file, &error))?;
        Ok(file)
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        // What stays behind is in the system's folder for such things.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("{}: cannot be written: {error}", path.display()))
}
