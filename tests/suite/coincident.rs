//! Surfaces that coincide: of things in one place under one transform, the one of the lower instance is met.

use glam::{DAffine3, DVec3, UVec2};
use orrery_engine::frame::{FrameScene, Instance, Shape, TraceSettings};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Hit, Query, Ray, Tracer};
use orrery_engine::world::{MeshData, MeshRow};
use orrery_tests::random_scene::{Random, random_scene};

/// What a tracer meets in a scene.
fn hits(tracer: &mut dyn Tracer, scene: &FrameScene, rays: &[Ray]) -> Vec<Hit> {
    let settings = TraceSettings {
        size: UVec2::ONE,
        ..Default::default()
    };
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings).expect("uploads");
    tracer.intersect(rays, Query::Closest).expect("answers")
}

fn rays(seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let mut ray = || {
        let eye = DVec3::new(0.0, 1.0, 9.0);
        let origin = random.cube() * 5.0;
        Ray {
            origin: (origin - eye).as_vec3(),
            dir: (random.cube() * 3.0 - origin).as_vec3(),
            t_min: 0.0,
            t_max: f32::MAX,
        }
    };
    (0..5000).map(|_| ray()).collect()
}

/// Every instance again, behind all; meshes are meshes of their own and twice as large, at half the size.
fn doubled(scene: &FrameScene) -> FrameScene {
    let mut doubled = scene.clone();
    let meshes = scene.meshes.len() as u32;
    for row in scene.meshes.iter() {
        doubled.meshes.push(MeshRow::from(enlarged(&row.data)));
    }
    for instance in scene.instances.iter() {
        let again = match instance.shape {
            Shape::Mesh(mesh) => Instance {
                shape: Shape::Mesh(meshes + mesh),
                world_from_local: instance.world_from_local
                    * DAffine3::from_scale(DVec3::splat(0.5)),
                ..*instance
            },
            _ => *instance,
        };
        doubled.instances.push(again);
    }
    doubled
}

fn enlarged(mesh: &MeshData) -> MeshData {
    let vertices = mesh.vertices.iter().map(|&vertex| vertex * 2.0).collect();
    let triangles = mesh.triangles.clone();
    MeshData::new("twice as large", vertices, mesh.normals.clone(), triangles).expect("a mesh")
}

#[test]
fn of_things_in_one_place_the_lower_instance_is_met_wherever_they_move() {
    let tracers: [Box<dyn Tracer>; 3] = [
        Box::new(CpuTracer::new()),
        Box::new(crate::gpu::tracer()),
        Box::new(ReferenceTracer::new()),
    ];
    for mut tracer in tracers {
        let backend = tracer.backend();
        for seed in 0..12 {
            // Poses anew: trees and roundings too.
            let scene = random_scene(seed, 30);
            let rays = rays(seed);
            let once = hits(tracer.as_mut(), &scene, &rays);
            let twice = hits(tracer.as_mut(), &doubled(&scene), &rays);
            let met = once.iter().filter(|hit| hit.t.is_finite()).count();
            assert!(met > rays.len() / 4, "seed {seed} on {backend}: {met} hits");
            for ((ray, one), two) in rays.iter().zip(&once).zip(&twice) {
                assert_eq!(one, two, "seed {seed} on {backend}: {ray:?}");
            }
        }
    }
}
