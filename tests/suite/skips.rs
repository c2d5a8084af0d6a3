//! What is left out, one by one: the picture is the same without it, and counts say what it saved.

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::{Picture, Tracer};
use orrery_tests::random_scene::random_scene;
use orrery_tests::tracers::picture;

/// What two kernels of one source may round apart.
const ROUNDINGS: f32 = 1.5e-5;

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs
        .map(|(a, b)| (a - b).abs().max_element())
        .fold(0.0, f32::max)
}

#[test]
fn a_device_that_counts_no_rays_traces_the_same() {
    let counting = settings(80, 60);
    let not_counting = TraceSettings {
        count_rays: false,
        ..counting
    };
    let mut tracer = crate::gpu::tracer();
    for seed in 0..3 {
        let scene = random_scene(seed, 40);
        let counted = picture(&mut tracer, &scene, &counting).expect("a picture");
        let counters = tracer.counters();
        assert_eq!(counters.primary_rays, 80 * 60);
        assert!(counters.rays() > 2 * 80 * 60, "{counters:?}");
        // Nobody is made to wait for a picture because somebody reads counts, or no longer does.
        picture(&mut tracer, &scene, &not_counting).expect("a picture");
        assert_eq!(tracer.counters().rays(), 0, "the picture is there");
        let mut other = crate::gpu::tracer();
        let uncounted = picture(&mut other, &scene, &not_counting).expect("a picture");
        assert_eq!(other.counters().rays(), 0);
        let off = largest_difference(&counted, &uncounted);
        assert!(off <= ROUNDINGS, "seed {seed}: {off}");
    }
}
