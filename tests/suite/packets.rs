//! Rays that go together find what they find alone, by all instructions of this processor.

use glam::{DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::cpu::{CpuTracer, Instructions};
use orrery_engine::trace::{Hit, Picture, Query, Ray, Tracer};
use orrery_tests::random_scene::{Random, random_scene};

fn ready(instructions: Instructions, scene: &FrameScene, size: UVec2) -> CpuTracer {
    let mut tracer = CpuTracer::with(instructions);
    let settings = TraceSettings {
        size,
        ..Default::default()
    };
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings).expect("uploads");
    tracer
}

/// Bundles of 64: from a point or from points near it, narrow or wide, along axes or not, some with ends.
fn bundles(random: &mut Random, count: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    for bundle in 0..count {
        let eye = random.cube() * 4.0 - DVec3::new(0.0, 1.0, 9.0);
        let target = random.cube() * 4.0;
        let mut towards = target - eye;
        if bundle % 3 == 0 {
            // The middle of the bundle is along an axis: directions to both sides of it.
            towards = DVec3::new(1e-3, -1e-3, towards.z);
        }
        let spread = [1e-3, 0.02, 0.1, 0.4][bundle % 4];
        let apart = [0.0, 0.0, 0.05, 1.0][bundle / 4 % 4];
        let t_max = if bundle % 5 == 0 { 0.9 } else { f32::MAX };
        rays.extend((0..64).map(|_| Ray {
            origin: (eye + random.cube() * apart).as_vec3(),
            dir: (towards + random.cube() * spread * towards.length()).as_vec3(),
            t_min: 0.0,
            t_max,
        }));
    }
    rays
}

/// The same answers from rays that go one by one: each is asked for with others that go elsewhere.
fn one_by_one(tracer: &mut CpuTracer, rays: &[Ray], query: Query) -> Vec<Hit> {
    let elsewhere = |ray: &Ray| Ray {
        dir: Vec3::new(-ray.dir.y, -ray.dir.z, -ray.dir.x) - ray.dir,
        ..*ray
    };
    let pairs: Vec<Ray> = rays.iter().flat_map(|ray| [*ray, elsewhere(ray)]).collect();
    let hits = tracer.intersect(&pairs, query).expect("answers");
    hits.into_iter().step_by(2).collect()
}

#[test]
fn a_ray_that_is_no_number_takes_none_along() {
    let scene = random_scene(2, 80);
    let rays = bundles(&mut Random::new(5), 128);
    for instructions in Instructions::all() {
        let mut tracer = ready(instructions, &scene, UVec2::ONE);
        let right = tracer.intersect(&rays, Query::Closest).expect("answers");
        assert!(right.iter().any(|hit| *hit != Hit::MISS));
        for broken in [f32::NAN, f32::INFINITY] {
            let mut some = rays.clone();
            for (bundle, rays) in some.chunks_mut(64).enumerate() {
                // In every lane of some bundle, and in the last of many.
                rays[63 - bundle % 64].dir.z = broken;
            }
            let hits = tracer.intersect(&some, Query::Closest).expect("answers");
            for (ray, (hit, right)) in hits.iter().zip(&right).enumerate() {
                let is_broken = ray % 64 == 63 - ray / 64 % 64;
                assert!(
                    is_broken || hit == right,
                    "ray {ray}, {}",
                    instructions.name()
                );
            }
        }
    }
}

#[test]
fn packets_find_what_single_rays_find() {
    for seed in 0..12 {
        let scene = random_scene(seed, 80);
        let rays = bundles(&mut Random::new(seed + 7), 160);
        for instructions in Instructions::all() {
            let mut tracer = ready(instructions, &scene, UVec2::ONE);
            for query in [Query::Closest, Query::Any] {
                let alone = one_by_one(&mut tracer, &rays, query);
                let together = tracer.intersect(&rays, query).expect("answers");
                for (ray, (a, b)) in alone.iter().zip(&together).enumerate() {
                    let of = instructions.name();
                    assert_eq!(
                        a, b,
                        "ray {ray}, scene {seed}, {query:?}, {of}: {:?}",
                        rays[ray]
                    );
                }
            }
        }
    }
}

#[test]
fn pictures_are_the_same_by_all_instructions() {
    for seed in 20..26 {
        let scene = random_scene(seed, 80);
        let picture = |instructions| -> Picture {
            let mut tracer = ready(instructions, &scene, UVec2::new(75, 51));
            tracer.render().expect("renders");
            tracer.picture().expect("has a picture")
        };
        let pictures: Vec<Picture> = Instructions::all().into_iter().map(picture).collect();
        for other in &pictures[1..] {
            assert_eq!(pictures[0].pixels, other.pixels, "scene {seed}");
        }
    }
}
