//! What a frame costs in which nothing changed, one of many things moved, or the camera did.
//!
//! Whole frames by the wall clock, from the world to the submitted picture of one pixel, without waiting for
//! a device; counts are the tracer's own.

use std::time::Instant;

use glam::{DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::wire::InstanceRow;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::time::Clock;
use orrery_engine::trace::{ActiveTracer, Counters, TraceFault};
use orrery_engine::world::Transform;
use tracing::subscriber::{NoSubscriber, with_default};

use super::Sizes;
use crate::args::{BackendChoice, Common};
use crate::bench::crowd::{Crowd, Kind, Plan};
use crate::bench::report::{Better, Row};
use crate::bench::timing::zero_row;
use crate::failure::Failure;
use crate::{device, stage};

/// Frames before the clock counts: trees built, pipelines compiled, systems settled.
const WARM_UP: usize = 5;
/// Samples of frames that take microseconds.
const QUICK_SAMPLES: usize = 200;
/// Microseconds of a frame in which nothing changed.
const REST_TARGET: f64 = 10.0;
/// Bytes that a moved thing may upload, whatever the number of things: rows, and nodes from leaf to root.
const ONE_MOVED_BYTES: f64 = 4096.0;
/// Bytes that a moved camera may upload beyond the rows of instances: the uniform and the lights.
const CAMERA_BYTES: f64 = 1024.0;
/// Size of the pictures compared.
const PROOF_SIZE: UVec2 = UVec2::new(64, 48);

/// Frames that were timed.
struct Frames {
    micros: Vec<f64>,
    /// Of each picture, once it had come back.
    counters: Vec<Counters>,
    /// Of each: the pass that packs rows on the host, in milliseconds.
    pack_millis: Vec<f64>,
}

impl Frames {
    fn each(&self, count: impl Fn(&Counters) -> u64) -> Vec<f64> {
        self.counters.iter().map(|c| count(c) as f64).collect()
    }

    fn most(&self, count: impl Fn(&Counters) -> u64) -> u64 {
        self.counters.iter().map(count).max().unwrap_or(0)
    }
}

/// Every crowd with one backend.
pub fn rows(
    backend: &str,
    choice: BackendChoice,
    sizes: &Sizes,
    samples: usize,
    common: &Common,
) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for &count in sizes.crowds {
        let plan = Plan {
            count,
            kind: Kind::Spheres,
            moving: false,
            profiled: true,
        };
        let mut crowd = Crowd::new(plan);
        stage::cast(&mut crowd.engine, device::open_choice(choice, common)?);
        rows.push(bare_at_rest(backend, plan, choice, common)?);
        rows.extend(at_rest(backend, count, &mut crowd)?);
        rows.extend(one_moves(backend, count, &mut crowd, samples)?);
        if Some(&count) == sizes.crowds.last() {
            rows.extend(camera_moves(backend, count, &mut crowd, samples)?);
        }
        let wrong = wrong_pixels(&mut crowd.engine, choice, common)?;
        let name = format!("{backend}.{count}.wrong");
        rows.push(zero_row(name, "pixels", wrong));
    }
    Ok(rows)
}

/// Nothing changes, and the profiler takes the time of every system, which costs more than they do.
fn at_rest(backend: &str, count: usize, crowd: &mut Crowd) -> Result<[Row; 4], Failure> {
    // Its pictures have come back before the clock counts.
    run(&mut crowd.engine, WARM_UP, |_, _| (), true)?;
    run(&mut crowd.engine, WARM_UP, |_, _| (), false)?;
    let frames = run(&mut crowd.engine, QUICK_SAMPLES, |_, _| (), false)?;
    let name = |what| format!("{backend}.rest.{count}.{what}");
    Ok([
        Row::sampled(name("profiled"), "us", Better::Lower, &frames.micros),
        zero_row(name("uploaded"), "bytes", frames.most(|c| c.bytes_uploaded)),
        zero_row(name("trees"), "trees", frames.most(|c| c.trees_updated)),
        zero_row(name("rays"), "rays", frames.most(Counters::rays)),
    ])
}

/// Nothing changes; nobody looks at single systems.
fn bare_at_rest(
    backend: &str,
    plan: Plan,
    choice: BackendChoice,
    common: &Common,
) -> Result<Row, Failure> {
    let plan = Plan {
        profiled: false,
        ..plan
    };
    // Spans are made together with their systems, in the first frame: none are, under this subscriber.
    let frames = with_default(NoSubscriber::new(), || {
        let mut engine = Crowd::new(plan).engine;
        stage::cast(&mut engine, device::open_choice(choice, common)?);
        run(&mut engine, WARM_UP, |_, _| (), true)?;
        run(&mut engine, WARM_UP, |_, _| (), false)?;
        run(&mut engine, QUICK_SAMPLES, |_, _| (), false)
    })?;
    let name = format!("{backend}.rest.{}.frame", plan.count);
    Ok(Row::sampled(name, "us", Better::Lower, &frames.micros).with_target(REST_TARGET))
}

/// One thing moves, every frame.
fn one_moves(
    backend: &str,
    count: usize,
    crowd: &mut Crowd,
    samples: usize,
) -> Result<Vec<Row>, Failure> {
    let thing = crowd.things[count / 3];
    let step = |engine: &mut Engine, frame: usize| {
        if let Some(mut pose) = engine.world.get_mut::<Transform>(thing) {
            pose.translation.x += if frame.is_multiple_of(2) { 0.25 } else { -0.25 };
        }
    };
    run(&mut crowd.engine, WARM_UP, step, true)?;
    let frames = run(&mut crowd.engine, samples, step, true)?;
    let name = |what| format!("{backend}.one_of.{count}.{what}");
    let sampled =
        |what, unit, values: &[f64]| Row::sampled(name(what), unit, Better::Lower, values);
    let bytes = frames.each(|c| c.bytes_uploaded);
    let nodes = frames.each(|c| c.tree_nodes);
    Ok(vec![
        sampled("frame", "us", &frames.micros),
        sampled("uploaded", "bytes", &bytes).with_target(ONE_MOVED_BYTES),
        sampled("nodes", "nodes", &nodes),
    ])
}

/// The camera moves, every frame.
fn camera_moves(
    backend: &str,
    count: usize,
    crowd: &mut Crowd,
    samples: usize,
) -> Result<Vec<Row>, Failure> {
    let camera = crowd.camera;
    let step = |engine: &mut Engine, _| {
        if let Some(mut pose) = engine.world.get_mut::<Transform>(camera) {
            pose.translation += DVec3::new(0.01, 0.0, 0.01);
        }
    };
    run(&mut crowd.engine, WARM_UP, step, true)?;
    let frames = run(&mut crowd.engine, samples, step, true)?;
    let name = |what| format!("{backend}.camera.{count}.{what}");
    let rows = (count * size_of::<InstanceRow>()) as u64;
    let beyond = frames.most(|c| c.bytes_uploaded.saturating_sub(rows));
    Ok(vec![
        Row::sampled(name("frame"), "us", Better::Lower, &frames.micros),
        Row::sampled(name("pass"), "ms", Better::Lower, &frames.pack_millis),
        zero_row(name("trees"), "trees", frames.most(|c| c.trees_updated)),
        zero_row(name("nodes"), "nodes", frames.most(|c| c.tree_nodes)),
        Row::single(name("beyond_rows"), "bytes", Better::Lower, beyond as f64)
            .with_target(CAMERA_BYTES),
    ])
}

/// Times frames; `waits`: for each picture, outside of the time, so that counts are those of that very frame.
fn run(
    engine: &mut Engine,
    count: usize,
    mut step: impl FnMut(&mut Engine, usize),
    waits: bool,
) -> Result<Frames, Failure> {
    let mut frames = Frames {
        micros: Vec::with_capacity(count),
        counters: Vec::with_capacity(count),
        pack_millis: Vec::with_capacity(count),
    };
    for i in 0..count {
        step(engine, i);
        *engine.world.resource_mut::<Clock>() = Clock::Frame(i as u64);
        let start = Instant::now();
        engine.frame();
        frames.micros.push(start.elapsed().as_secs_f64() * 1e6);
        if let Some(fault) = engine.world.resource_mut::<TraceFault>().0.take() {
            return Err(fault.into());
        }
        if let Some(tracer) = &mut engine.world.resource_mut::<ActiveTracer>().0 {
            if waits {
                tracer.picture()?;
            }
            frames.counters.push(tracer.counters());
            let passes = tracer.pass_times();
            let pack = passes.iter().find(|pass| pass.name.starts_with("rows"));
            frames.pack_millis.extend(pack.map(|pass| pass.millis));
        }
    }
    Ok(frames)
}

/// Pixels in which the tracer that followed all changes differs from one that sees the frame for the first time.
fn wrong_pixels(
    engine: &mut Engine,
    choice: BackendChoice,
    common: &Common,
) -> Result<u64, Failure> {
    engine.world.resource_mut::<TraceSettings>().size = PROOF_SIZE;
    let kept = stage::picture(engine, 0)?;
    let settings = *engine.world.resource::<TraceSettings>();
    let scene = engine.world.resource::<FrameScene>();
    let mut tracer = device::open_choice(choice, common)?;
    tracer.refit(scene)?;
    tracer.upload(scene, &settings)?;
    tracer.render()?;
    let fresh = tracer.picture()?;
    let pairs = kept.pixels.iter().zip(&fresh.pixels);
    Ok(pairs.filter(|(a, b)| a != b).count() as u64)
}
