//! Scenes that come along, through the whole frame: loaded, moved, traced by every backend.

use std::path::{Path, PathBuf};

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::time::Clock;
use orrery_engine::trace::{ActiveTracer, Backend, Picture, TraceFault};
use orrery_tests::metrics::compare_pictures;
use orrery_tests::tracers;

fn scene_file(name: &str) -> PathBuf {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    scenes.join(name).with_extension("ron")
}

fn engine(scene: &str, backend: Backend, size: UVec2) -> Engine {
    let mut engine = Engine::new();
    let loaded = orrery_engine::scene::load(&mut engine.world, &scene_file(scene));
    loaded.unwrap_or_else(|problems| panic!("{problems}"));
    engine.world.resource_mut::<TraceSettings>().size = size;
    let tracer = tracers::open(backend).expect("a device; tests need one");
    engine.world.resource_mut::<ActiveTracer>().0 = Some(tracer);
    engine
}

fn picture(engine: &mut Engine, frame: u64) -> Picture {
    *engine.world.resource_mut::<Clock>() = Clock::Frame(frame);
    engine.frame();
    let fault = engine.world.resource_mut::<TraceFault>().0.take();
    assert_eq!(fault, None);
    let tracer = &mut engine.world.resource_mut::<ActiveTracer>().0;
    tracer
        .as_mut()
        .expect("a tracer")
        .picture()
        .expect("a picture")
}

/// Holds two backends to each other: pixels off by more than 1/255, per million over all frames.
fn hold(scene: &str, [a, b]: [Backend; 2], size: UVec2, limit_ppm: f64) {
    let (mut one, mut other) = (engine(scene, a, size), engine(scene, b, size));
    let frames = [0, 30, 90];
    let mut ppm = 0.0;
    for frame in frames {
        let (test, reference) = (picture(&mut one, frame), picture(&mut other, frame));
        let metrics = compare_pictures(&test, &reference);
        assert_eq!(metrics.non_finite, 0, "{scene}, frame {frame}, {a}");
        ppm += metrics.mismatch_ppm / frames.len() as f64;
        let lit = test
            .pixels
            .iter()
            .filter(|p| p.max_element() > 0.01)
            .count();
        assert!(
            lit > test.pixels.len() / 20,
            "{scene}, frame {frame}, {a}: black"
        );
    }
    assert!(
        ppm <= limit_ppm,
        "{scene}: {a} and {b} differ in {ppm} pixels a million"
    );
}

const SMALL: UVec2 = UVec2::new(320, 240);
const REPORT_SCENES: [&str; 5] = [
    "two_spheres",
    "two_triangles",
    "spheres_36",
    "polygons_35",
    "mirrors_21",
];

#[test]
fn the_cpu_shows_the_reports_scenes_as_the_reference_does() {
    for scene in REPORT_SCENES {
        hold(scene, [Backend::Cpu, Backend::Reference], SMALL / 2, 500.0);
    }
}

#[test]
fn the_gpu_shows_the_reports_scenes_as_the_cpu_does() {
    for scene in REPORT_SCENES {
        hold(scene, [Backend::Gpu, Backend::Cpu], SMALL, 500.0);
    }
}

#[test]
fn the_demo_is_the_same_on_all_backends() {
    hold("demo", [Backend::Gpu, Backend::Cpu], SMALL, 500.0);
    hold("demo", [Backend::Cpu, Backend::Reference], SMALL / 2, 500.0);
}

#[test]
fn a_frame_number_is_a_picture_however_one_gets_there() {
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut walked = engine("demo", backend, SMALL / 2);
        for frame in [3, 17, 40] {
            picture(&mut walked, frame);
        }
        let walked = picture(&mut walked, 30);
        let straight = picture(&mut engine("demo", backend, SMALL / 2), 30);
        assert!(
            walked == straight,
            "{backend}: frame 30 depends on the frames before"
        );
    }
}

#[test]
fn things_move() {
    let mut engine = engine("demo", Backend::Cpu, SMALL / 2);
    let (first, later) = (picture(&mut engine, 0), picture(&mut engine, 30));
    let metrics = compare_pictures(&later, &first);
    assert!(metrics.mismatch_ppm > 10_000.0, "{metrics:?}");
}
