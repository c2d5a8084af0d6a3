//! A scene in which everything deforms and moves: a tracer that follows it against one that sees each frame
//! first, and both against the reference.

use std::path::Path;

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::time::Clock;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_tests::metrics::compare_pictures;
use orrery_tests::tracers::picture;

/// Frames out of order, the last after nine hours.
const FRAMES: [u64; 5] = [0, 45, 46, 20, 1_000_000];

#[test]
fn the_wolf_runs_alike_however_its_frames_are_reached() {
    let size = UVec2::new(128, 72);
    let settings = TraceSettings {
        size,
        ..Default::default()
    };
    let mut engine = Engine::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/wolf.ron");
    orrery_engine::scene::load(&mut engine.world, &scene)
        .unwrap_or_else(|problems| panic!("{problems}"));
    engine.world.insert_resource(settings);
    let (mut following, mut exact) = (CpuTracer::new(), ReferenceTracer::new());
    let (mut wrong, mut seen) = (0.0, Vec::new());
    for frame in FRAMES {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let scene = engine.world.resource::<FrameScene>();
        let followed = picture(&mut following, scene, &settings).unwrap();
        let fresh = picture(&mut CpuTracer::new(), scene, &settings).unwrap();
        assert!(
            followed.pixels == fresh.pixels,
            "frame {frame} depends on the frames before"
        );
        let metrics = compare_pictures(&fresh, &picture(&mut exact, scene, &settings).unwrap());
        assert_eq!(metrics.non_finite, 0, "frame {frame}");
        wrong += metrics.mismatch_ppm / FRAMES.len() as f64;
        assert!(!seen.contains(&fresh.pixels), "frame {frame} shows another");
        seen.push(fresh.pixels);
    }
    assert!(
        wrong < 1000.0,
        "{wrong} ppm of the pixels are off by more than 1/255"
    );
}
