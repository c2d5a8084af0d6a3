//! Samples, and rays left out: what they cost a picture in accuracy is what the settings say.

use glam::UVec2;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::profile::PictureError;
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

fn relative_mse(picture: &Picture, reference: &Picture) -> f64 {
    PictureError::of(picture, reference).relative_mse
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

/// Traces random scenes whole in each of these ways and then with rays left out, of which no pixel may show more
/// than the cut-off.
fn leave_out(ways: &[TraceSettings]) {
    let mut dropped = 0;
    for seed in 0..6 {
        let mut scene = random_scene(seed, 30);
        // Compiling a kernel a scene takes a while on a device.
        let count = if seed < 2 { 2 } else { 1 };
        for mut tracer in tracers().into_iter().take(count) {
            // Mesa's llvmpipe ends what an invocation loops after 65,535 turns in all, without a word; with 9 generations there
            // are pixels here that take more.
            scene.max_generations = if tracer.device().contains("llvmpipe") {
                8
            } else {
                10
            };
            for whole in ways {
                let contrast = whole.adaptive;
                let story = format!("seed {seed} on {}, {contrast:?}", tracer.backend());
                let uncut = picture(tracer.as_mut(), &scene, whole).unwrap();
                assert_eq!(tracer.counters().dropped_rays, 0, "{story}");
                let edges = tracer.counters().edge_pixels;
                for power in 1..=6 {
                    let cutoff = 0.1_f32.powi(power);
                    let some = TraceSettings { cutoff, ..*whole };
                    let cut = picture(tracer.as_mut(), &scene, &some).unwrap();
                    let counters = tracer.counters();
                    assert_eq!(counters.edge_pixels, edges, "{story}: other edges");
                    let error = largest_difference(&cut, &uncut);
                    // Sums round otherwise where a term is missing.
                    let rounding = 2e-6;
                    assert!(error <= cutoff + rounding, "{story}: {error} for {cutoff}");
                    let left_out = counters.dropped_rays;
                    assert!(power > 1 || left_out > 0, "{story}: none");
                    dropped += left_out;
                }
            }
        }
    }
    assert!(dropped > 1000, "{dropped} rays in all");
}

#[test]
fn what_is_left_out_of_a_pixel_stays_below_the_cutoff() {
    leave_out(&[TraceSettings {
        samples: 2,
        ..settings(40, 30)
    }]);
}

/// Where first samples decide which pixels take more, what is left out must not.
#[test]
fn what_is_left_out_of_an_adaptive_pictures_pixel_stays_below_the_cutoff() {
    leave_out(&[0.02, 0.1].map(|contrast| TraceSettings {
        samples: 4,
        adaptive: Some(contrast),
        ..settings(40, 30)
    }));
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

/// A tracer's picture after so many frames of the same.
fn after_frames(
    tracer: &mut dyn Tracer,
    scene: &FrameScene,
    settings: &TraceSettings,
    frames: u32,
) -> Picture {
    let mut last = None;
    for _ in 0..frames {
        last = Some(picture(tracer, scene, settings).expect("a picture"));
    }
    last.expect("a frame")
}

#[test]
fn while_nothing_changes_a_picture_refines_to_that_of_all_samples() {
    let scene = random_scene(3, 20);
    let fixed = TraceSettings {
        samples: 256,
        ..settings(32, 24)
    };
    let reference = picture(&mut ReferenceTracer::new(), &scene, &fixed).unwrap();
    let refining = TraceSettings {
        refine_to: 256,
        ..settings(32, 24)
    };
    for mut tracer in tracers() {
        let backend = tracer.backend();
        let (mut before, mut shown) = (f64::INFINITY, 0);
        for samples in [1, 4, 16, 64, 256] {
            let now = after_frames(tracer.as_mut(), &scene, &refining, samples - shown);
            shown = samples;
            assert_eq!(tracer.samples(), samples);
            let error = relative_mse(&now, &reference);
            assert!(
                error < before,
                "{samples} on {backend}: {error} after {before}"
            );
            before = error;
        }
        assert!(before <= 1e-5, "{backend}: {before}");
        let refined = picture(tracer.as_mut(), &scene, &refining).unwrap();
        assert_eq!(tracer.counters().rays(), 0, "{backend} rests at the limit");
        let at_once = picture(tracer.as_mut(), &scene, &fixed).unwrap();
        let difference = largest_difference(&refined, &at_once);
        assert!(difference < 2e-5, "{backend}: {difference}");
        // Anything that changes starts over.
        let mut moved = scene.clone();
        moved.view.origin.x += 0.1;
        after_frames(tracer.as_mut(), &moved, &refining, 3);
        assert_eq!(tracer.samples(), 3, "{backend}");
    }
}

/// However many samples a frame adds: the same ones, one after the other.
#[test]
fn the_pace_of_refining_does_not_show_in_the_picture() {
    let scene = random_scene(3, 20);
    for mut tracer in tracers() {
        let mut refined = |refine_by: u32, frames: u32| {
            let refining = TraceSettings {
                refine_to: 16,
                refine_by,
                ..settings(32, 24)
            };
            let mut moved = scene.clone();
            moved.view.origin.x += 0.1;
            after_frames(tracer.as_mut(), &moved, &refining, 1);
            let picture = after_frames(tracer.as_mut(), &scene, &refining, frames);
            assert_eq!(tracer.samples(), 16, "{}", tracer.backend());
            picture
        };
        let slowly = refined(1, 16);
        assert!(slowly == refined(4, 5), "four a frame, and the last three");
        assert!(slowly == refined(100, 2), "all at once");
    }
}

/// What a window's size follows: of the samples that refine a picture, and of frames at rest, nothing is measured.
#[test]
fn only_pictures_from_the_start_are_timed_as_such() {
    let mut scene = random_scene(3, 20);
    let refining = TraceSettings {
        refine_to: 4,
        ..settings(32, 24)
    };
    for mut tracer in tracers() {
        for _ in 0..2 {
            scene.view.origin.x += 0.1;
            let timed = [(); 6].map(|()| {
                picture(tracer.as_mut(), &scene, &refining).expect("a picture");
                tracer
                    .timed_picture()
                    .is_some_and(|time| time.size == refining.size)
            });
            let expected = [true, false, false, false, false, false];
            assert_eq!(timed, expected, "{}", tracer.backend());
        }
    }
}

#[test]
fn adaptive_pictures_take_all_samples_on_edges_and_one_elsewhere() {
    let scene = random_scene(3, 20);
    let one = settings(64, 48);
    let all = TraceSettings { samples: 8, ..one };
    let adaptive = TraceSettings {
        adaptive: Some(0.05),
        ..all
    };
    for mut tracer in tracers() {
        let backend = tracer.backend();
        let [one, all, some] = [one, all, adaptive]
            .map(|settings| picture(tracer.as_mut(), &scene, &settings).unwrap());
        let counters = tracer.counters();
        let pixels = one.pixels.len() as u64;
        assert!(counters.edge_pixels > 0 && counters.edge_pixels < pixels * 3 / 4);
        assert_eq!(counters.primary_rays, pixels + 7 * counters.edge_pixels);
        let mut refined = 0;
        for ((one, all), some) in one.pixels.iter().zip(&all.pixels).zip(&some.pixels) {
            let is = |other: &glam::Vec3| (*some - *other).abs().max_element() < 1e-5;
            assert!(is(one) || is(all), "{backend}: {some} of {one} and {all}");
            refined += u64::from(!is(one));
        }
        assert!(refined > 0 && refined <= counters.edge_pixels, "{backend}");
        // The list has no stated order, and none shows.
        let mut again = crate::gpu::tracer();
        if backend == again.backend() {
            let same = picture(&mut again, &scene, &adaptive).unwrap();
            assert!(same == some, "the order of the list shows");
        }
    }
}

#[test]
fn adaptive_pictures_refine_to_that_of_all_samples() {
    let scene = random_scene(5, 20);
    let fixed = TraceSettings {
        samples: 16,
        ..settings(40, 30)
    };
    let adaptive = TraceSettings {
        samples: 8,
        adaptive: Some(0.1),
        refine_to: 16,
        ..fixed
    };
    for mut tracer in tracers() {
        let whole = picture(tracer.as_mut(), &scene, &fixed).unwrap();
        let refined = after_frames(tracer.as_mut(), &scene, &adaptive, 16);
        let difference = largest_difference(&refined, &whole);
        assert!(difference < 1e-5, "{}: {difference}", tracer.backend());
        after_frames(tracer.as_mut(), &scene, &adaptive, 1);
        assert_eq!(tracer.counters().rays(), 0);
    }
}
