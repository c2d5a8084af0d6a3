//! The benchmark `trace`: rays by kind and whole frames, on scenes from a few mirrors to ten thousand instances.
//!
//! Rays by kind are timed alone, where they lie (on a GPU by its own timestamps), and can be dumped for rivals. Whole
//! frames are the picture's kernel: the same rays, shading included.

pub mod kinds;
pub mod rates;
pub mod stage;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::{Backend, Tracer};

use super::dump;
use super::frame::backends;
use super::rays::RaySet;
use super::report::{Better, Report, Row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::device;
use crate::failure::Failure;
use crate::output::{note, progress};
use crate::stage::traced;

use kinds::WHOLE_FRAME;
use rates::{flips, in_rows, kind_rows};
use stage::Stage;

/// Folders of dumped scenes.
const DUMPED: [&str; 5] = ["hall_s", "hall_l", "terrain", "inst_1k", "inst_10k"];
/// Models beside them.
const MODELS: [&str; 4] = [
    "balls_s4.nff",
    "gears_s4.nff",
    "mount_s6.nff",
    "tetra_s6.nff",
];
/// Scenes that come along.
const SCENES: [&str; 4] = ["mirrors_21", "spheres_36", "polygons_35", "demo"];
const SIZES: [UVec2; 2] = [UVec2::new(1920, 1080), UVec2::new(1024, 768)];
/// Of a short run.
const SMALL_SIZE: UVec2 = UVec2::new(96, 54);
/// Clocks rise with work, and fall while the host works alone: this long before the first time is taken, and all times of a
/// scene in one go.
const WARM_UP: Duration = Duration::from_millis(2500);
const WARM_UP_RUNS: usize = 8;
/// The same before whole frames, where the host has just worked alone for a while.
const WARM_UP_FRAMES: Duration = Duration::from_millis(800);
/// The pass that makes pictures.
const KERNEL: &str = "whitted";
/// Frame of scenes in motion.
const FRAME: u64 = 30;

/// Traces every scene that is there on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let mut rows = Vec::new();
    let mut tracers: Vec<Box<dyn Tracer>> = Vec::new();
    for choice in backends(common) {
        tracers.push(device::open_choice(choice, common)?);
    }
    let devices: Vec<String> = tracers.iter().map(|tracer| tracer.device()).collect();
    let mut reference = device::open_choice(BackendChoice::Reference, common)?;
    let sizes = match (common.size, request.small) {
        (Some(size), _) => vec![size],
        (None, true) => vec![SMALL_SIZE],
        (None, false) => SIZES.to_vec(),
    };
    let scenes = scenes(request)?;
    let bar = progress((scenes.len() * tracers.len()) as u64, "trace");
    for path in scenes {
        bar.set_message(
            path.file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
        );
        let stage = match path.is_dir() {
            true => Stage::of_dump(&path)?,
            false => Stage::of_scene(&path, FRAME, sizes[0], common)?,
        };
        for tracer in &mut tracers {
            let run = Run {
                stage: &stage,
                request,
                common,
            };
            let sets = run.sets(sizes[0], tracer.as_mut())?;
            run.dump(sizes[0], &sets, tracer.as_ref())?;
            run.warm_up(&sets, tracer.as_mut())?;
            let name = run.name(tracer.as_ref());
            rows.extend(run.kinds(&name, &sets, tracer.as_mut())?);
            for &size in &sizes[1..] {
                let name = format!("{name}.{}x{}", size.x, size.y);
                let sets = run.sets(size, tracer.as_mut())?;
                rows.extend(run.kinds(&name, &sets, tracer.as_mut())?);
            }
            for &size in &sizes {
                rows.push(run.whole(size, tracer.as_mut())?);
            }
            rows.extend(flips(
                &stage,
                &run.name(tracer.as_ref()),
                &sets,
                reference.as_mut(),
                common,
            )?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(Report {
        rows,
        remarks: vec![format!(
            "rays by kind of {}x{} pixels where no other size is named, in tiles of 8 x 8; `rays`: primary, shadow, mirrored, shadow, together; `whole`: the picture's kernel",
            sizes[0].x, sizes[0].y
        )],
        ..Report::new("trace", &devices)
    })
}

/// What there is to trace.
fn scenes(request: &BenchRequest) -> Result<Vec<PathBuf>, Failure> {
    let stem = |path: &Path| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let all = DUMPED.iter().chain(&MODELS).chain(&SCENES);
    let names: Vec<String> = all.map(|name| stem(Path::new(name))).collect();
    if let Some(unknown) = request.suite.iter().find(|name| !names.contains(name)) {
        return Err(Failure::Usage(format!(
            "no scene `{unknown}` in `trace`; there is {}",
            names.join(", ")
        )));
    }
    let mut scenes = Vec::new();
    if let Some(folder) = &request.files {
        for name in DUMPED.iter().chain(&MODELS) {
            let path = folder.join(name);
            match path.exists() {
                true => scenes.push(path),
                false => note(format_args!(
                    "note: {} is not there; it is skipped",
                    path.display()
                )),
            }
        }
    }
    scenes.extend(SCENES.iter().map(PathBuf::from));
    if !request.suite.is_empty() {
        scenes.retain(|path| request.suite.contains(&stem(path)));
    }
    Ok(scenes)
}

/// A scene under measurement.
struct Run<'a> {
    stage: &'a Stage,
    request: &'a BenchRequest,
    common: &'a Common,
}

impl Run<'_> {
    /// The rays of every kind that there are.
    fn sets(&self, size: UVec2, tracer: &mut dyn Tracer) -> Result<Vec<RaySet>, Failure> {
        let settings = self.settings(size);
        let frame = &self.stage.work.frame;
        tracer.refit(frame)?;
        tracer.upload(frame, &settings)?;
        let mut sets = kinds::trace(self.stage, size, tracer)?;
        sets.retain(|set| !set.rays.is_empty());
        Ok(sets)
    }

    /// Writes the work of so many pixels, where that was asked for.
    fn dump(&self, size: UVec2, sets: &[RaySet], tracer: &dyn Tracer) -> Result<(), Failure> {
        let folder = match &self.request.dump {
            Some(folder) if tracer.backend() != Backend::Reference => folder,
            _ => return Ok(()),
        };
        let name = &self.stage.name;
        let sets = in_rows(size, sets);
        dump::write(&folder.join(name), name, size, &self.stage.work, &sets)
    }

    /// Works until clocks have risen.
    fn warm_up(&self, sets: &[RaySet], tracer: &mut dyn Tracer) -> Result<(), Failure> {
        let begun = Instant::now();
        while !self.request.small && begun.elapsed() < WARM_UP {
            for set in sets {
                tracer.time_rays(&set.rays, set.query, WARM_UP_RUNS)?;
            }
        }
        Ok(())
    }

    /// Times of every kind, and of a whole frame's together.
    fn kinds(
        &self,
        name: &str,
        sets: &[RaySet],
        tracer: &mut dyn Tracer,
    ) -> Result<Vec<Row>, Failure> {
        let mut rows = Vec::new();
        let mut whole = vec![0.0; self.samples()];
        let mut count = 0;
        for set in sets {
            let millis = tracer.time_rays(&set.rays, set.query, self.samples())?;
            if WHOLE_FRAME.contains(&set.kind) {
                whole
                    .iter_mut()
                    .zip(&millis)
                    .for_each(|(sum, millis)| *sum += millis);
                count += set.rays.len();
            }
            rows.extend(kind_rows(&format!("{name}.{}", set.kind), set, &millis));
        }
        rows.push(Row::sampled(
            format!("{name}.rays"),
            "ms",
            Better::Lower,
            &whole,
        ));
        let rates: Vec<f64> = whole
            .iter()
            .map(|millis| count as f64 / millis * 1e-3)
            .collect();
        rows.push(Row::sampled(
            format!("{name}.rays.rate"),
            "Mrays/s",
            Better::Higher,
            &rates,
        ));
        Ok(rows)
    }

    fn name(&self, tracer: &dyn Tracer) -> String {
        format!("{}.{}", self.stage.name, tracer.backend())
    }

    fn settings(&self, size: UVec2) -> TraceSettings {
        TraceSettings {
            size,
            ..crate::stage::settings(self.common, size)
        }
    }

    /// The picture's kernel, shading included. Two frames in turn, since an unchanged one is not traced again.
    fn whole(&self, size: UVec2, tracer: &mut dyn Tracer) -> Result<Row, Failure> {
        let settings = self.settings(size);
        let mut other = self.stage.frame.clone();
        other.background.horizon += glam::Vec3::splat(1e-6);
        let frames = [&other, &self.stage.frame];
        let mut millis = Vec::new();
        let begun = Instant::now();
        for turn in 0.. {
            let is_warm = self.request.small || begun.elapsed() >= WARM_UP_FRAMES;
            let start = Instant::now();
            traced(tracer, frames[turn % 2], &settings)?;
            let around = start.elapsed().as_secs_f64() * 1e3;
            let passes = tracer.pass_times();
            // A device without timestamps has the clock around it all.
            let pass = passes.iter().find(|pass| pass.name == KERNEL);
            if is_warm {
                millis.push(pass.map_or(around, |pass| pass.millis));
            }
            if millis.len() == self.samples() {
                break;
            }
        }
        let name = format!("{}.whole.{}x{}", self.name(tracer), size.x, size.y);
        Ok(Row::sampled(name, "ms", Better::Lower, &millis))
    }

    fn samples(&self) -> usize {
        if self.request.small { 4 } else { 40 }
    }
}
