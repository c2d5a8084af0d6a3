//! Rays that are left out: what a picture takes with them, without them, and how many they are.

use std::path::Path;

use orrery_engine::frame::{FrameScene, Skip, Skips, TraceSettings};
use orrery_engine::trace::Tracer;
use orrery_engine::trace::gpu::GpuTracer;

use super::{Kind, Run, Way, off_row};
use crate::args::Common;
use crate::assets;
use crate::bench::frame::FRAMES_PER_SEC;
use crate::bench::report::{Better, Row};
use crate::bench::timing::{median, millis_row};
use crate::failure::Failure;
use crate::stage::{advance, set, traced};

/// Those that leave out rays.
pub const OF_RAYS: [Skip; 5] = [
    Skip::Away,
    Skip::Black,
    Skip::FaintLights,
    Skip::FaintRays,
    Skip::Weightless,
];
/// Of what is too faint: half a step of 8 bits of linear light, of all of a pixel.
pub const CUTOFF: f32 = 0.5 / 255.0;
/// Frame of the demo.
const FRAME: u64 = 30;

/// The demo; of a short run, mirrors.
pub fn scene(run: &Run, common: &Common) -> Result<FrameScene, Failure> {
    if run.small {
        return Kind::Mirrors.scene(&run.settings, true);
    }
    let size = run.settings.size;
    let mut engine = set(Path::new(assets::DEMO), common, size, FRAMES_PER_SEC)?;
    advance(&mut engine, FRAME)?;
    Ok(engine.world.resource::<FrameScene>().clone())
}

/// Without those rays and with them.
pub fn rows(
    run: &Run,
    skip: Skip,
    scene: &FrameScene,
    tracer: &mut GpuTracer,
) -> Result<Vec<Row>, Failure> {
    let is_faint = [Skip::FaintLights, Skip::FaintRays].contains(&skip);
    let usual = Way {
        cutoff: if is_faint { CUTOFF } else { 0.0 },
        ..Way::of(scene.features)
    };
    let all = Way {
        skips: Skips::ALL.without(skip),
        ..usual
    };
    let [without, with] = run.measure(scene, [usual, all], tracer)?;
    let counting = TraceSettings {
        count_rays: true,
        ..usual.settings(&run.settings)
    };
    // A frame unlike the last, or it is not traced.
    let mut other = scene.clone();
    other.background.horizon += glam::Vec3::splat(2e-6);
    traced(tracer, &other, &counting)?;
    let counters = tracer.counters();
    let name = |what: &str| format!("left_out.{skip}.{what}");
    let saved = 1.0 - median(&without.millis) / median(&with.millis);
    let pixels = f64::from(run.settings.size.element_product());
    let rays = counters.saved(skip) as f64 / pixels;
    Ok(vec![
        millis_row(name("without"), &without.millis),
        millis_row(name("with"), &with.millis),
        Row::single(name("saved"), "share", Better::Higher, saved),
        Row::single(name("rays"), "a pixel", Better::Higher, rays),
        off_row(name("off"), &without, [&with]),
    ])
}
