//! Looks of surfaces on random scenes: the tracers against each other, and scenes without looks against themselves.

use glam::{DVec3, UVec2, Vec3};
use orrery_engine::frame::{Features, FrameScene, TraceSettings};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Picture, Query, Ray, Tracer};
use orrery_tests::metrics::compare_pictures;
use orrery_tests::random_looks::{Looks, random_looks};
use orrery_tests::random_scene::{Random, random_scene};
use orrery_tests::tracers::picture;

use crate::gpu;

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

/// A picture of this size.
pub fn traced(tracer: &mut dyn Tracer, scene: &FrameScene, size: [u32; 2]) -> Picture {
    picture(tracer, scene, &settings(size[0], size[1])).expect("a picture")
}

/// Pixels off by more than 1/255, per million, over a few seeds.
fn apart(first: &mut dyn Tracer, second: &mut dyn Tracer, looks: Looks, seeds: u32) -> f64 {
    let count = f64::from(seeds);
    let mut ppm = 0.0;
    for seed in 0..seeds {
        let scene = random_looks(seed.into(), looks);
        let a = traced(first, &scene, [96, 72]);
        let b = traced(second, &scene, [96, 72]);
        let metrics = compare_pictures(&a, &b);
        assert_eq!(metrics.non_finite, 0, "seed {seed}, {looks:?}");
        ppm += metrics.mismatch_ppm / count;
    }
    ppm
}

#[test]
fn cpu_and_reference_see_the_same_looks() {
    for looks in Looks::ALL {
        let ppm = apart(&mut CpuTracer::new(), &mut ReferenceTracer::new(), looks, 3);
        assert!(ppm < 1000.0, "{looks:?}: {ppm} ppm of the pixels differ");
    }
}

#[test]
fn gpu_and_cpu_see_the_same_looks() {
    for looks in Looks::ALL {
        let ppm = apart(&mut gpu::tracer(), &mut CpuTracer::new(), looks, 1);
        assert!(ppm < 1000.0, "{looks:?}: {ppm} ppm of the pixels differ");
    }
}

#[test]
fn rays_pass_the_same_holes_in_all_tracers() {
    let scene = random_looks(5, Looks::HOLES);
    let mut random = Random::new(17);
    let rays: Vec<Ray> = (0..20_000)
        .map(|_| Ray {
            origin: (random.cube() * 4.0 - DVec3::new(0.0, 1.0, 9.0)).as_vec3(),
            dir: random.direction().as_vec3(),
            t_min: 0.0,
            t_max: f32::MAX,
        })
        .collect();
    let answers = |tracer: &mut dyn Tracer, query| {
        tracer.refit(&scene).expect("refits");
        tracer.upload(&scene, &settings(1, 1)).expect("uploads");
        tracer.intersect(&rays, query).expect("answers")
    };
    for query in [Query::Closest, Query::Any] {
        let cpu = answers(&mut CpuTracer::new(), query);
        let others: [&mut dyn Tracer; 2] = [&mut gpu::tracer(), &mut ReferenceTracer::new()];
        for tracer in others {
            let found = answers(tracer, query);
            let pairs = found.iter().zip(&cpu);
            let differ = pairs
                .filter(|(a, b)| (a.instance, a.prim) != (b.instance, b.prim))
                .count();
            assert!(differ <= 4, "{differ} of {} rays differ", rays.len());
        }
    }
}

#[test]
fn textures_that_nobody_shows_change_no_bit() {
    for seed in 0..2 {
        let plain = random_scene(seed, 30);
        let mut stocked = random_looks(seed, Looks::EVERY);
        stocked.instances = plain.instances.clone();
        stocked.meshes = plain.meshes.clone();
        stocked.background = plain.background;
        stocked
            .materials
            .edit(|material| material.absorption = Vec3::ZERO);
        stocked.features = Features::of(&stocked);
        assert_eq!(stocked.features, plain.features);
        for mut tracer in [
            Box::new(gpu::tracer()) as Box<dyn Tracer>,
            Box::new(CpuTracer::new()),
            Box::new(ReferenceTracer::new()),
        ] {
            let before = traced(&mut *tracer, &plain, [64, 48]);
            let after = traced(&mut *tracer, &stocked, [64, 48]);
            assert!(before.pixels == after.pixels, "{}", tracer.backend());
        }
    }
}
