//! Samples, and rays left out: what they cost a picture in accuracy is what the settings say.

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Picture, Tracer};
use orrery_tests::random_scene::random_scene;
use orrery_tests::tracers::picture;

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

/// mean((I - R)^2 / (R^2 + 0.01)).
fn relative_mse(picture: &Picture, reference: &Picture) -> f64 {
    let pairs = picture.pixels.iter().zip(&reference.pixels);
    let sum: f64 = pairs
        .map(|(p, r)| {
            let (p, r) = (p.as_dvec3(), r.as_dvec3());
            ((p - r) * (p - r) / (r * r + 0.01)).element_sum()
        })
        .sum();
    sum / (3.0 * picture.pixels.len() as f64)
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs
        .map(|(a, b)| (a - b).abs().max_element())
        .fold(0.0, f32::max)
}

/// Both f32 tracers.
fn tracers() -> [Box<dyn Tracer>; 2] {
    [Box::new(CpuTracer::new()), Box::new(crate::gpu::tracer())]
}

#[test]
fn what_is_left_out_of_a_pixel_stays_below_the_cutoff() {
    let mut dropped = 0;
    for seed in 0..6 {
        let mut scene = random_scene(seed, 30);
        scene.max_generations = 10;
        for mut tracer in tracers() {
            let backend = tracer.backend();
            let mut all = settings(40, 30);
            all.samples = 2;
            let whole = picture(tracer.as_mut(), &scene, &all).unwrap();
            assert_eq!(tracer.counters().dropped_rays, 0);
            for power in 1..=6 {
                let cutoff = 0.1_f32.powi(power);
                let some = TraceSettings { cutoff, ..all };
                let cut = picture(tracer.as_mut(), &scene, &some).unwrap();
                let left_out = tracer.counters().dropped_rays;
                let error = largest_difference(&cut, &whole);
                // Sums round otherwise where a term is missing.
                let rounding = 2e-6;
                assert!(
                    error <= cutoff + rounding,
                    "seed {seed} on {backend}: {error} for {cutoff}"
                );
                dropped += left_out;
                if power == 1 {
                    assert!(left_out > 0, "seed {seed} on {backend}: none");
                }
            }
        }
    }
    assert!(dropped > 1000, "{dropped} rays in all");
}

#[test]
fn samples_are_the_same_in_all_tracers() {
    let scene = random_scene(3, 20);
    for samples in [1, 2, 7, 16] {
        let settings = TraceSettings {
            samples,
            ..settings(48, 36)
        };
        let reference = picture(&mut ReferenceTracer::new(), &scene, &settings).unwrap();
        for mut tracer in tracers() {
            let traced = picture(tracer.as_mut(), &scene, &settings).unwrap();
            let rays = tracer.counters().primary_rays;
            assert_eq!(rays, u64::from(samples) * 48 * 36);
            let error = relative_mse(&traced, &reference);
            assert!(error < 1e-4, "{samples} on {}: {error}", tracer.backend());
        }
    }
}

#[test]
fn more_samples_come_closer_to_the_picture_of_all() {
    let scene = random_scene(3, 20);
    let of = |samples| TraceSettings {
        samples,
        ..settings(48, 36)
    };
    let all = picture(&mut CpuTracer::new(), &scene, &of(256)).unwrap();
    let mut before = f64::INFINITY;
    for samples in [1, 4, 16, 64] {
        let some = picture(&mut CpuTracer::new(), &scene, &of(samples)).unwrap();
        let error = relative_mse(&some, &all);
        assert!(error < before / 2.0, "{samples}: {error} after {before}");
        before = error;
    }
}
