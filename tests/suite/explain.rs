//! A pixel's ray tree against the picture it explains, and as the program prints it.

use glam::{DVec3, UVec2};
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::Tracer;
use orrery_engine::trace::reference::{Fate, RayKind, ReferenceTracer};
use orrery_tests::random_scene::random_scene;

use crate::cli::expect;

/// Glass, mirrors, media, lights: many pixels of many scenes.
fn tracers() -> impl Iterator<Item = (u64, ReferenceTracer, TraceSettings)> {
    (0..24).map(|seed| {
        let scene: FrameScene = random_scene(seed, 12);
        let settings = TraceSettings {
            size: UVec2::new(24, 18),
            samples: 1 + (seed % 3) as u32,
            ..TraceSettings::default()
        };
        let mut tracer = ReferenceTracer::new();
        tracer.refit(&scene).expect("the reference builds");
        tracer.upload(&scene, &settings).expect("and takes it in");
        tracer.render().expect("and traces");
        (seed, tracer, settings)
    })
}

#[test]
fn what_rays_add_is_the_pixel_of_the_picture() {
    let mut rays = 0;
    for (seed, mut tracer, settings) in tracers() {
        let picture = tracer.picture().expect("it was traced");
        for at in 0..settings.size.element_product() {
            let pixel = UVec2::new(at % settings.size.x, at / settings.size.x);
            let explained = tracer.explain(pixel).expect("it is in the picture");
            let seen = picture.pixels[at as usize];
            assert_eq!(
                explained.color.as_vec3(),
                seen,
                "scene {seed}, pixel {pixel}"
            );
            let sum: DVec3 = explained.rays.iter().map(|ray| ray.added).sum();
            let off = (sum - explained.color).abs() / explained.color.abs().max(DVec3::ONE);
            assert!(
                off.max_element() < 1e-12,
                "scene {seed}, pixel {pixel}: {off}"
            );
            rays += explained.rays.len();
        }
    }
    assert!(rays > 20_000, "{rays} rays say little");
}

#[test]
fn every_ray_has_its_parent_and_the_counts_agree() {
    for (seed, tracer, settings) in tracers() {
        for at in (0..settings.size.element_product()).step_by(7) {
            let pixel = UVec2::new(at % settings.size.x, at / settings.size.x);
            let explained = tracer.explain(pixel).expect("it is in the picture");
            let count = |is: fn(&RayKind) -> bool| {
                explained.rays.iter().filter(|ray| is(&ray.kind)).count() as u64
            };
            let counters = &explained.counters;
            assert_eq!(
                count(|k| matches!(k, RayKind::Camera(_))),
                counters.primary_rays
            );
            assert_eq!(
                count(|k| matches!(k, RayKind::Shadow(_))),
                counters.shadow_rays
            );
            assert_eq!(count(|k| *k == RayKind::Mirrored), counters.reflected_rays);
            for (i, ray) in explained.rays.iter().enumerate() {
                let Some(parent) = ray.parent else {
                    assert!(matches!(ray.kind, RayKind::Camera(_)), "scene {seed}");
                    continue;
                };
                assert!(parent < i);
                let above = &explained.rays[parent];
                assert_eq!(above.depth + 1, ray.depth, "scene {seed}, pixel {pixel}");
                assert!(matches!(above.fate, Fate::Met { .. }), "it left a surface");
            }
            assert!(explained.rays.iter().any(|ray| ray.shapes > 0) || explained.rays.len() == 1);
        }
    }
}

#[test]
fn the_program_prints_a_tree_and_refuses_what_is_no_pixel() {
    let pixel = |at| ["render", "two_spheres", "--size", "64x48", "--explain", at];
    expect(
        &pixel("32,24"),
        0,
        &[
            "pixel 32,24 of 64x48",
            "camera, sample 0 -> `",
            "to light 0",
            "weight",
        ],
    );
    expect(&pixel("64,24"), 2, &["0,0 to 63,47"]);
    expect(&pixel("middle"), 2, &["640,360"]);
}
