//! Trees that wear out are replaced off the frame, and no answer shows when.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3, Vec3};

use super::*;
use crate::frame::{Instance, Shape};
use crate::trace::cpu::CpuTracer;
use crate::trace::{Hit, Query, Ray, Tracer};
use crate::world::{DeformStep, Deformation, MeshData, MeshRow, VertexSets};

/// A sheet of quads, and a pose in which its vertices are shuffled far and wide.
fn sheet_and_shuffled(side: u32) -> (MeshData, Arc<VertexSets>) {
    let at = |i: u32| {
        DVec3::new(
            f64::from(i % side),
            f64::from(i / side),
            f64::from(i % 5) * 0.1,
        )
    };
    let vertices: Vec<DVec3> = (0..side * side).map(at).collect();
    let quad = |i: u32| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]];
    let inner = (0..side * (side - 1)).filter(|i| i % side != side - 1);
    let triangles: Vec<[u32; 3]> = inner.flat_map(quad).collect();
    // Blocks of 8 x 8 vertices trade places, so that triangles of one node part.
    let block = |i: u32| {
        let (x, y) = (i % side, i / side);
        let (from_x, from_y) = (x / 8, y / 8);
        let many = side / 8;
        let to = (from_x * 37 + from_y * 61) % (many * many);
        Vec3::new(
            (to % many * 8 + x % 8) as f32 - side as f32 * 0.5,
            (to / many * 8 + y % 8) as f32 - side as f32 * 0.5,
            (i % 3) as f32,
        )
    };
    let values = (0..side * side).map(block).collect();
    let mesh = MeshData::new("sheet", vertices, Vec::new(), triangles).expect("a sheet is a mesh");
    let keys = VertexSets {
        vertices: (side * side) as usize,
        values,
    };
    (mesh, Arc::new(keys))
}

fn answers(tracer: &mut CpuTracer, scene: &FrameScene) -> Vec<Hit> {
    let rays: Vec<Ray> = (0..2_000)
        .map(|i| Ray {
            origin: Vec3::new((i % 50) as f32 * 1.3, (i / 50) as f32 * 1.6, 40.0),
            dir: Vec3::new((i % 7) as f32 * 0.02, (i % 11) as f32 * -0.02, -1.0),
            t_min: 0.0,
            t_max: f32::MAX,
        })
        .collect();
    tracer.refit(scene).expect("refits");
    let settings = TraceSettings::default();
    tracer.upload(scene, &settings).expect("uploads");
    tracer.intersect(&rays, Query::Closest).expect("answers")
}

#[test]
fn a_worn_tree_is_replaced_and_no_answer_shows_when() {
    let (mesh, keys) = sheet_and_shuffled(64);
    let mut scene = FrameScene {
        materials: vec![Default::default()].into(),
        meshes: vec![mesh.into()].into(),
        instances: vec![Instance {
            tag: 0,
            shape: Shape::Mesh(0),
            world_from_local: DAffine3::IDENTITY,
            material: 0,
        }]
        .into(),
        ..FrameScene::default()
    };
    let mut watched = PackedScene::default();
    let mut walked = CpuTracer::new();
    watched.refit(&scene);
    answers(&mut walked, &scene);
    let fresh = watched.meshes[0].nodes().to_vec();
    let (start, mut has_worn, mut is_replaced) = (Instant::now(), false, false);
    for frame in 0..10_000_u32 {
        let share = 1.0 - f64::from(frame % 2) * 1e-3;
        let step = DeformStep::Keys {
            keys: Arc::clone(&keys),
            from: 0,
            to: 0,
            share,
        };
        let row = MeshRow {
            deformation: Some(Arc::new(Deformation { steps: vec![step] })),
            ..scene.meshes[0].clone()
        };
        scene.meshes.replace(0, row);
        watched.refit(&scene);
        has_worn |= watched.meshes[0].is_worn();
        is_replaced = has_worn && !watched.meshes[0].is_worn();
        if frame < 4 || is_replaced {
            let found = answers(&mut walked, &scene);
            assert_eq!(
                found,
                answers(&mut CpuTracer::new(), &scene),
                "frame {frame}"
            );
            assert!(found.iter().any(|hit| hit.instance == 0));
        }
        if is_replaced || start.elapsed() > Duration::from_secs(60) {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(has_worn, "the pose does not wear the tree");
    assert!(is_replaced, "no tree came within a minute");
    assert_ne!(watched.meshes[0].nodes().len(), 0);
    let topology = |nodes: &[Node4]| nodes.iter().map(|n| n.children).collect::<Vec<_>>();
    assert_ne!(topology(watched.meshes[0].nodes()), topology(&fresh));
}
