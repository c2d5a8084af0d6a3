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
fn a_survey_counts_what_explanations_list() {
    for (seed, tracer, settings) in tracers().take(8) {
        let survey = tracer.survey(1);
        assert_eq!(survey.size, settings.size);
        let (mut tests, mut sent) = (0, 0);
        for (at, cost) in survey.pixels.iter().enumerate() {
            let at = at as u32;
            let pixel = UVec2::new(at % settings.size.x, at / settings.size.x);
            let rays = tracer.explain(pixel).expect("it is in the picture").rays;
            assert_eq!(
                cost.rays as usize,
                rays.len(),
                "scene {seed}, pixel {pixel}"
            );
            assert_eq!(cost.boxes, rays.iter().map(|ray| ray.boxes).sum::<u32>());
            assert_eq!(cost.shapes, rays.iter().map(|ray| ray.shapes).sum::<u32>());
            let chains = rays
                .iter()
                .filter(|ray| !matches!(ray.kind, RayKind::Shadow(_)));
            let depth = chains.map(|ray| ray.depth + 1).max();
            assert_eq!(Some(cost.depth as usize), depth);
            tests += u64::from(cost.boxes + cost.shapes);
            sent += rays.iter().filter(|ray| ray.parent.is_some()).count() as u64;
        }
        assert_eq!(
            survey.tests(),
            tests,
            "scene {seed}: all work is somebody's"
        );
        assert_eq!(
            survey.things.iter().map(|thing| thing.sent).sum::<u64>(),
            sent
        );
    }
}

#[test]
fn heat_is_a_picture_and_says_its_scale() {
    let folder = crate::cli::folder("heat");
    let out = folder.join("heat.png").display().to_string();
    let arguments = [
        "render",
        "two_spheres",
        "--size",
        "32x24",
        "--heat",
        "rays",
        "--out",
        &out,
    ];
    expect(&arguments, 0, &["heat.png: rays a pixel", "at most"]);
    assert!(image::open(&out).is_ok());
    expect(&["render", "two_spheres", "--heat", "warm"], 2, &["boxes"]);
    let exr = ["render", "two_spheres", "--heat", "depth", "--out", "x.exr"];
    expect(&exr, 2, &[".png"]);
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
