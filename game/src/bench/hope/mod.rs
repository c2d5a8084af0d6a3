//! The benchmark `hope`: what the report of 2008 hoped for, in full motion.
//!
//! The report (Allgyer 2008, "Real-time Ray Tracing using CUDA") closes with the wish for scenes of 100,000 triangles that
//! move. Here half of them move rigidly and half deform in every frame, between mirrors and glass, and a frame is all that
//! a frame takes: systems, trees, upload, rays. Frames follow each other as in a window, the picture stays on the device.

mod content;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::profile::Profile;
use orrery_engine::trace::gpu::Gpu;
use orrery_engine::trace::{Backend, Counters, PassTime, Tracer};
use tracing::subscriber::{NoSubscriber, with_default};

use super::flight::{Flight, open};
use super::frame::{FRAMES_PER_SEC, SIZE, backends, error_rows, reference_picture};
use super::report::{Better, Report, Row, short};
use super::timing::median;
use crate::args::{BenchRequest, Common};
use crate::failure::Failure;
use crate::output::progress;
use crate::stage;

/// The scene.
const SCENE: &str = "lagoon";
/// Frames measured unless `--frames` says otherwise, and of a short run.
const FRAMES: u64 = 1000;
const SMALL_FRAMES: u64 = 20;
/// Frames, at most, of the run that counts rays.
const COUNTED_FRAMES: u64 = 200;
/// Frames before the clock counts.
const WARM_UP: u64 = 30;
/// Frames a second on an NVIDIA H200.
const RATE_TARGET: f64 = 1000.0;
/// Rays a pixel, at least.
const RAYS_TARGET: f64 = 4.0;
/// Passes by the device's clock.
const DEVICE_PASSES: [&str; 3] = ["trees", "whitted", "antialias"];
/// Systems shown, the slowest first.
const SYSTEMS_SHOWN: usize = 8;

/// Plays the scene on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let scene = Path::new(SCENE);
    let common = &at_size(request, common);
    let frames = match (request.frames, request.small) {
        (Some(frames), _) => frames,
        (None, true) => SMALL_FRAMES,
        (None, false) => FRAMES,
    };
    let mut rows = content::rows(scene, request.frame, common)?;
    let reference = reference_picture(scene, request.frame, common)?;
    let (mut devices, mut limits) = (Vec::new(), Vec::new());
    for choice in backends(common) {
        let (tracer, gpu) = open(choice, common)?;
        let name = tracer.backend().to_string();
        let is_device = tracer.backend() == Backend::Gpu;
        devices.push(tracer.device());
        let timed = Frames {
            first: request.frame,
            count: frames,
            count_rays: false,
        };
        let played = play(tracer, gpu, &timed, common)?;
        rows.extend(played.rows(&name, is_device));
        // A device that counts rays is slower by that.
        let (tracer, gpu) = open(choice, common)?;
        let counted = Frames {
            count: frames.min(COUNTED_FRAMES),
            count_rays: true,
            ..timed
        };
        rows.extend(play(tracer, gpu, &counted, common)?.ray_rows(&name));
        limits.extend(is_device.then(|| played.limit(&name)));
        let (tracer, gpu) = open(choice, common)?;
        let frames = request.frame..request.frame + frames.min(WARM_UP);
        rows.extend(system_rows(&name, tracer, gpu, frames, common)?);
        let mut engine = stage::set(scene, common, SIZE, FRAMES_PER_SEC)?;
        stage::cast(&mut engine, open(choice, common)?.0);
        rows.extend(error_rows(&name, &mut engine, request.frame, &reference)?);
    }
    let size = stage::settings(common, SIZE).size;
    let remarks = vec![
            format!(
                "{SCENE}, {frames} frames from {} on, {}x{}, as in a window: two pictures under way, none read back",
                request.frame, size.x, size.y
            ),
            "frame: from one frame to the next; host: of that, what the processor is busy with; system: the slowest, with the profiler, whose own cost is in them".into(),
            format!(
                "error against the f64 reference: frame {} at {}x{}",
                request.frame, reference.size.x, reference.size.y
            ),
        ];
    Ok(Report {
        rows,
        remarks: [remarks, limits].concat(),
        ..Report::new("hope", &devices)
    })
}

/// A short run has small pictures.
fn at_size(request: &BenchRequest, common: &Common) -> Common {
    let small = request.small.then(|| SIZE / 8);
    Common {
        size: common.size.or(small),
        ..common.clone()
    }
}

/// What the frames took.
#[derive(Default)]
struct Played {
    /// From one frame to the next.
    millis: Vec<f64>,
    /// Of that, until the frame was submitted.
    host: Vec<f64>,
    /// Of the pictures that had come back.
    counters: Vec<Counters>,
    passes: Vec<Vec<PassTime>>,
    pixels: f64,
}

/// Which frames are played.
#[derive(Clone, Copy)]
struct Frames {
    first: u64,
    count: u64,
    count_rays: bool,
}

/// Frame after frame, without the profiler of systems.
fn play(
    tracer: Box<dyn Tracer>,
    gpu: Option<Arc<Gpu>>,
    frames: &Frames,
    common: &Common,
) -> Result<Played, Failure> {
    let &Frames { first, count, .. } = frames;
    // Spans are made together with their systems, in the first frame: none are, under this subscriber.
    with_default(NoSubscriber::new(), || {
        let mut engine = stage::set(Path::new(SCENE), common, SIZE, FRAMES_PER_SEC)?;
        stage::cast(&mut engine, tracer);
        let mut settings = engine.world.resource_mut::<TraceSettings>();
        settings.count_rays = frames.count_rays;
        let size = settings.size;
        let mut flight = Flight::new(gpu);
        for frame in first..first + WARM_UP.min(count) {
            stage::advance(&mut engine, frame)?;
            flight.submitted()?;
        }
        let mut played = Played {
            pixels: f64::from(size.x) * f64::from(size.y),
            ..Played::default()
        };
        let bar = progress(count, "hope");
        let mut start = Instant::now();
        for frame in first..first + count {
            stage::advance(&mut engine, frame)?;
            played.host.push(start.elapsed().as_secs_f64() * 1e3);
            let profile = engine.world.resource::<Profile>();
            played.counters.push(profile.counters);
            played.passes.push(profile.passes.clone());
            flight.submitted()?;
            let end = Instant::now();
            played.millis.push((end - start).as_secs_f64() * 1e3);
            start = end;
            if frame % 64 == 0 {
                bar.inc(64);
            }
        }
        bar.finish_and_clear();
        Ok(played)
    })
}

impl Played {
    /// Milliseconds of the device, a frame.
    fn device(&self) -> Vec<f64> {
        let of_device = |pass: &&PassTime| DEVICE_PASSES.contains(&pass.name);
        let frames = self.passes.iter();
        frames
            .map(|passes| passes.iter().filter(of_device).map(|p| p.millis).sum())
            .collect()
    }

    /// Which of the two that work side by side takes longer.
    fn limit(&self, backend: &str) -> String {
        let [frame, host, device] =
            [&self.millis, &self.host, &self.device()].map(|samples| median(samples));
        let who = if device >= host {
            "device"
        } else {
            "processor"
        };
        format!(
            "{backend}: the {who} limits: of {} ms from frame to frame the device works {}, the processor {}",
            short(frame),
            short(device),
            short(host)
        )
    }

    fn rows(&self, backend: &str, is_device: bool) -> Vec<Row> {
        let row = |what: &str, values: &[f64]| {
            Row::sampled(format!("{backend}.{what}"), "ms", Better::Lower, values)
        };
        let total: f64 = self.millis.iter().sum();
        let rate = self.millis.len() as f64 / total * 1e3;
        let rate = Row::single(format!("{backend}.rate"), "frames/s", Better::Higher, rate);
        let mut rows = vec![
            match is_device {
                true => rate.with_target(RATE_TARGET),
                false => rate,
            },
            row("frame", &self.millis),
            row("host", &self.host),
        ];
        if is_device {
            rows.push(row("device", &self.device()));
        }
        let mut passes: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for pass in self.passes.iter().flatten() {
            passes.entry(pass.name).or_default().push(pass.millis);
        }
        rows.extend(
            passes
                .iter()
                .map(|(pass, millis)| row(&format!("pass.{pass}"), millis)),
        );
        let uploads = self
            .counters
            .iter()
            .map(|c| c.bytes_uploaded as f64 / 1024.0);
        rows.push(Row::sampled(
            format!("{backend}.uploaded"),
            "KiB",
            Better::Lower,
            &uploads.collect::<Vec<_>>(),
        ));
        rows
    }

    /// Rays a pixel by kind.
    fn ray_rows(&self, backend: &str) -> impl Iterator<Item = Row> {
        let kinds: [(&str, fn(&Counters) -> u64); 5] = [
            ("rays", Counters::rays),
            ("primary", |c| c.primary_rays),
            ("reflected", |c| c.reflected_rays),
            ("refracted", |c| c.refracted_rays),
            ("shadow", |c| c.shadow_rays),
        ];
        kinds.into_iter().map(move |(kind, count)| {
            let name = format!("{backend}.{kind}");
            let each = self.counters.iter().map(|c| count(c) as f64 / self.pixels);
            let each: Vec<f64> = each.collect();
            let row = Row::sampled(name, "a pixel", Better::Higher, &each);
            match kind {
                "rays" => row.with_target(RAYS_TARGET),
                _ => row,
            }
        })
    }
}

/// What the slowest systems take, by the profiler.
fn system_rows(
    backend: &str,
    tracer: Box<dyn Tracer>,
    gpu: Option<Arc<Gpu>>,
    frames: Range<u64>,
    common: &Common,
) -> Result<Vec<Row>, Failure> {
    let mut engine: Engine = stage::set(Path::new(SCENE), common, SIZE, FRAMES_PER_SEC)?;
    stage::cast(&mut engine, tracer);
    let mut flight = Flight::new(gpu);
    let mut systems: BTreeMap<Arc<str>, Vec<f64>> = BTreeMap::new();
    // The first frame is the one that builds everything.
    for frame in frames.clone() {
        stage::advance(&mut engine, frame)?;
        flight.submitted()?;
        if frame > frames.start {
            for span in &engine.world.resource::<Profile>().spans {
                let samples = systems.entry(Arc::clone(&span.name)).or_default();
                samples.push(span.micros);
            }
        }
    }
    let mut rows: Vec<Row> = systems
        .iter()
        .map(|(name, micros)| {
            let name = format!("{backend}.system.{name}");
            Row::sampled(name, "us", Better::Lower, micros)
        })
        .collect();
    rows.sort_by(|a, b| b.value.total_cmp(&a.value));
    rows.truncate(SYSTEMS_SHOWN);
    Ok(rows)
}
