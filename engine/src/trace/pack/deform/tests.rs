//! f32 against the formulas in f64, over random meshes and deformations.

use std::sync::Arc;

use glam::{DAffine3, DQuat};

use super::*;
use crate::testing::Random;
use crate::world::{VertexSets, deformed_vertices};

const VERTICES: usize = 60;

/// A soup of triangles within 1 of `center`, with normals.
fn mesh(random: &mut Random, center: DVec3) -> MeshData {
    let vertices = (0..VERTICES).map(|_| center + random.cube()).collect();
    let triangles = (0..100).map(|_| [0; 3].map(|_| random.below(VERTICES) as u32));
    let normals = vec![Vec3::Y; VERTICES];
    MeshData::new("soup", vertices, normals, triangles.collect()).unwrap()
}

fn sets(random: &mut Random, count: usize) -> Arc<VertexSets> {
    let values = (0..VERTICES * count).map(|_| random.cube().as_vec3());
    Arc::new(VertexSets {
        vertices: VERTICES,
        values: values.collect(),
    })
}

fn step(random: &mut Random, center: DVec3) -> DeformStep {
    match random.below(5) {
        0 => DeformStep::Keys {
            keys: sets(random, 3),
            from: random.below(3) as u32,
            to: random.below(3) as u32,
            share: random.range(-1.0, 1.0).abs(),
        },
        1 => DeformStep::Morph {
            targets: sets(random, 3),
            weights: vec![random.range(-1.0, 1.0), 0.0, random.range(-1.0, 1.0)],
        },
        2 => {
            let joint = |random: &mut Random| {
                let there = DAffine3::from_translation(center);
                let turn = DQuat::from_scaled_axis(random.cube());
                let turn = DAffine3::from_rotation_translation(turn, random.cube());
                there * turn * there.inverse()
            };
            let joints = (0..5).map(|_| joint(random)).collect();
            let names: Vec<[u32; 4]> = (0..VERTICES)
                .map(|_| [0; 4].map(|_| random.below(5) as u32))
                .collect();
            let weights = (0..VERTICES)
                .map(|_| [0; 4].map(|_| random.below(9) as f32 + 0.1))
                .collect();
            DeformStep::Skin {
                binding: Arc::new(SkinBinding::new(names, weights).unwrap()),
                joints,
            }
        }
        3 => DeformStep::Wave {
            wave: random.cube() * 9.0,
            amplitude: random.cube(),
            phase: random.range(-1.0, 1.0) * 1e3,
        },
        _ => DeformStep::Twist {
            origin: center + random.cube() * 3.0,
            axis: random.cube().try_normalize().unwrap_or(DVec3::Y),
            rate: random.range(-1.0, 1.0) * 4.0,
            offset: random.range(-1.0, 1.0) * 1e3,
        },
    }
}

#[test]
fn f32_deforms_as_the_formulas_do() {
    let mut random = Random::new(1);
    for trial in 0..400 {
        // Exact in f64, so that what the shift costs is all there is to see.
        let center = DVec3::new(1.0, -2.0, 3.0) * [0.0, 1e4, 1e6][trial % 3];
        let mesh = mesh(&mut random, center);
        let steps = (0..1 + random.below(3)).map(|_| step(&mut random, center));
        let deformation = Deformation {
            steps: steps.collect(),
        };
        let mut found = Vec::new();
        deform_positions(&mesh, &deformation, &mut found);
        let exact = deformed_vertices(&mesh, Some(&deformation));
        // Every step may magnify the error before it, a wave by its steepness.
        let limit = 4e-6 * 30_f64.powi(deformation.steps.len() as i32 - 1).min(100.0);
        for (vertex, (found, exact)) in found.iter().zip(exact).enumerate() {
            let error = (found.as_dvec3() + mesh.origin - exact).length();
            let rounding = 4.0 * f64::EPSILON * center.length() * 1e3;
            assert!(
                error <= limit + rounding,
                "trial {trial}, vertex {vertex}: {error:e} off after {deformation:?}"
            );
        }
    }
}

#[test]
fn normals_are_those_of_the_deformed_triangles() {
    let mut random = Random::new(77);
    for trial in 0..50 {
        let mesh = mesh(&mut random, DVec3::ZERO);
        let deformation = Deformation {
            steps: vec![step(&mut random, DVec3::ZERO)],
        };
        let (mut positions, mut found) = (Vec::new(), Vec::new());
        deform_positions(&mesh, &deformation, &mut positions);
        vertex_normals(&mesh, &Adjacency::of(&mesh), &positions, &mut found);
        // From the very positions, in f64.
        let vertices: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        for (vertex, found) in found.iter().enumerate() {
            let around = mesh.triangles.iter().flat_map(|t| {
                let [a, b, c] = t.map(|i| vertices[i as usize]);
                let times = t.iter().filter(|&&i| i as usize == vertex).count();
                std::iter::repeat_n((b - a).cross(c - a), times)
            });
            let sum: DVec3 = around.sum();
            let exact = sum.try_normalize().unwrap_or(DVec3::Y);
            let error = (found.as_dvec3() - exact).length();
            assert!(
                error <= 1e-5 / sum.length().min(1.0),
                "trial {trial}, vertex {vertex}: {found} != {exact}"
            );
        }
    }
}

#[test]
fn a_large_mesh_deforms_as_its_parts() {
    let count = PARALLEL * 2 + 17;
    let place = |i: usize| DVec3::new((i % 257) as f64, (i / 257) as f64, 0.5) / 64.0;
    let vertices: Vec<DVec3> = (0..count).map(place).collect();
    let mesh = MeshData::new("large", vertices, Vec::new(), Vec::new()).unwrap();
    let deformation = Deformation {
        steps: vec![DeformStep::Wave {
            wave: DVec3::new(3.0, 4.0, 0.0),
            amplitude: DVec3::Z,
            phase: 0.5,
        }],
    };
    let mut whole = Vec::new();
    deform_positions(&mesh, &deformation, &mut whole);
    for i in [0, 1, PARALLEL - 1, PARALLEL, count - 1] {
        let mut one = [mesh.positions[i]];
        shifted(&deformation.steps[0], mesh.origin).apply(i, &mut one);
        assert_eq!(whole[i], one[0], "vertex {i}");
    }
}
