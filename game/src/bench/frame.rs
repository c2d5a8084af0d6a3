//! The benchmark `frame`: whole frames of a moving scene, one after the other.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::profile::PictureError;
use orrery_engine::trace::gpu::{AdapterChoice, Gpu};
use orrery_engine::trace::{ActiveTracer, Counters, Picture};

use super::dump;
use super::report::{Better, Report, Row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::failure::Failure;
use crate::output::progress;
use crate::{device, stage};

/// Size unless asked otherwise: the 2008 report's goal.
pub const SIZE: UVec2 = UVec2::new(1024, 768);
/// Frame numbers a second of scene time.
pub const FRAMES_PER_SEC: f64 = 30.0;
/// Frames run before the clock counts: trees built, pipelines compiled, caches warm.
const WARM_UP: u64 = 3;
/// What the reference picture may take; it gets smaller until it fits.
const REFERENCE_BUDGET: Duration = Duration::from_secs(20);
/// Pixels off by more than 1/255 that a scene with glass may have, per million.
const MISMATCH_TARGET: f64 = 500.0;

/// What the frames of one backend took.
#[derive(Default)]
struct Samples {
    millis: Vec<f64>,
    counters: Vec<Counters>,
    /// Name and milliseconds, a list a frame.
    passes: Vec<Vec<(&'static str, f64)>>,
}

/// Measures every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let mut engine = stage::set(&request.scene, common, SIZE, FRAMES_PER_SEC)?;
    let size = settings(&engine).size;
    let last = request.frame + request.repeat - 1;
    let mut remarks = vec![format!(
        "{}, frames {} to {last}, {}x{}, one at a time, each picture read back",
        request.scene.display(),
        request.frame,
        size.x,
        size.y
    )];
    let reference = reference_picture(&request.scene, request.frame, common)?;
    remarks.push(format!(
        "errors against the f64 reference: frame {} at {}x{}",
        request.frame, reference.size.x, reference.size.y
    ));
    let mut rows = Vec::new();
    let mut devices = Vec::new();
    for choice in backends(common) {
        let tracer = device::open_choice(choice, common)?;
        let name = tracer.backend().to_string();
        devices.push(tracer.device());
        stage::cast(&mut engine, tracer);
        let mut samples = sample(&mut engine, request, &name)?;
        // A device that counts rays is slower by that: the same frames again, for their counts.
        engine.world.resource_mut::<TraceSettings>().count_rays = true;
        samples.counters = sample(&mut engine, request, &name)?.counters;
        engine.world.resource_mut::<TraceSettings>().count_rays = false;
        rows.extend(time_rows(&name, &samples));
        rows.extend(error_rows(&name, &mut engine, request.frame, &reference)?);
    }
    if let Some(folder) = &request.dump {
        dump::run(folder, request, common)?;
    }
    Ok(Report {
        rows,
        remarks,
        ..Report::new("frame", &devices)
    })
}

/// The backends to measure: `auto` means the GPU where there is a real one, and the processor beside it.
pub fn backends(common: &Common) -> Vec<BackendChoice> {
    match common.backend {
        BackendChoice::Auto => {
            let gpu = common.adapter.is_some()
                || Gpu::open(Gpu::instance(), &AdapterChoice::Hardware, None).is_ok();
            let gpu = gpu.then_some(BackendChoice::Gpu);
            gpu.into_iter().chain([BackendChoice::Cpu]).collect()
        }
        chosen => vec![chosen],
    }
}

fn sample(engine: &mut Engine, request: &BenchRequest, name: &str) -> Result<Samples, Failure> {
    for frame in 0..WARM_UP {
        stage::picture(engine, request.frame + frame)?;
    }
    let mut samples = Samples::default();
    let bar = progress(request.repeat, name);
    for frame in request.frame..request.frame + request.repeat {
        let start = Instant::now();
        stage::picture(engine, frame)?;
        samples.millis.push(start.elapsed().as_secs_f64() * 1e3);
        // Asked of the tracer, not of the profile: by now this very picture has come back.
        if let Some(tracer) = &engine.world.resource::<ActiveTracer>().0 {
            samples.counters.push(tracer.counters());
            let passes = tracer.pass_times();
            let passes = passes.iter().map(|pass| (pass.name, pass.millis));
            samples.passes.push(passes.collect());
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(samples)
}

fn time_rows(backend: &str, samples: &Samples) -> Vec<Row> {
    let row = |what: &str, unit, better, values: &[f64]| {
        Row::sampled(format!("{backend}.{what}"), unit, better, values)
    };
    let mut rows = vec![row("frame", "ms", Better::Lower, &samples.millis)];
    for &(pass, _) in samples.passes.first().map_or(&[][..], Vec::as_slice) {
        let of_pass = samples.passes.iter().flatten().filter(|p| p.0 == pass);
        let millis: Vec<f64> = of_pass.map(|p| p.1).collect();
        rows.push(row(&format!("pass.{pass}"), "ms", Better::Lower, &millis));
    }
    let kinds: [(&str, fn(&Counters) -> u64); 5] = [
        ("rays", Counters::rays),
        ("primary", |c| c.primary_rays),
        ("reflected", |c| c.reflected_rays),
        ("refracted", |c| c.refracted_rays),
        ("shadow", |c| c.shadow_rays),
    ];
    for (kind, count) in kinds {
        let counters = samples.counters.iter().zip(&samples.millis);
        let rates: Vec<f64> = counters
            .map(|(counters, millis)| count(counters) as f64 / millis / 1e3)
            .collect();
        rows.push(row(kind, "Mrays/s", Better::Higher, &rates));
    }
    let of_counters =
        |value: fn(&Counters) -> f64| -> Vec<f64> { samples.counters.iter().map(value).collect() };
    let uploads = of_counters(|c| c.bytes_uploaded as f64 / 1024.0);
    let trees = of_counters(|c| c.trees_updated as f64);
    rows.push(row("uploaded", "KiB", Better::Lower, &uploads));
    rows.push(row("trees_updated", "trees", Better::Lower, &trees));
    rows
}

/// The reference's picture of a frame, as large as fits its budget.
pub fn reference_picture(scene: &Path, frame: u64, common: &Common) -> Result<Picture, Failure> {
    let mut engine = stage::set(scene, common, SIZE, FRAMES_PER_SEC)?;
    let full = settings(&engine).size;
    let tracer = device::open_choice(BackendChoice::Reference, common)?;
    stage::cast(&mut engine, tracer);
    resize(&mut engine, full / 16);
    let start = Instant::now();
    stage::picture(&mut engine, frame)?;
    let small = start.elapsed().as_secs_f64();
    let fits = |d: &u32| small * f64::from(256 / (d * d)) <= REFERENCE_BUDGET.as_secs_f64();
    let divisor = [1, 2, 4, 8].into_iter().find(fits).unwrap_or(16);
    resize(&mut engine, full / divisor);
    stage::picture(&mut engine, frame)
}

/// How far an engine's picture of a frame is from the reference's, at the reference's size.
pub fn error_rows(
    backend: &str,
    engine: &mut Engine,
    frame: u64,
    reference: &Picture,
) -> Result<[Row; 2], Failure> {
    let size = settings(engine).size;
    resize(engine, reference.size);
    let picture = stage::picture(engine, frame)?;
    resize(engine, size);
    let error = PictureError::of(&picture, reference);
    let row =
        |what, unit, value| Row::single(format!("{backend}.{what}"), unit, Better::Lower, value);
    Ok([
        row("mismatch", "ppm", error.mismatch_ppm).with_target(MISMATCH_TARGET),
        row("p99.9_error", "linear", error.p999),
    ])
}

fn settings(engine: &Engine) -> TraceSettings {
    *engine.world.resource::<TraceSettings>()
}

fn resize(engine: &mut Engine, size: UVec2) {
    engine.world.resource_mut::<TraceSettings>().size = size.max(UVec2::ONE);
}
