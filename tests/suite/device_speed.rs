//! How long the device takes over trees, by its own clock. No test: nothing is asserted about time. Run it by
//! `cargo test --release --workspace --test suite device_speed -- --ignored --nocapture`.

#![allow(clippy::print_stdout, reason = "figures are all it is for")]

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use orrery_engine::bvh::{Node4, Tree};
use orrery_engine::frame::wire::{BoxRow, TriangleRow, VertexRow};
use orrery_engine::geom::Aabb;
use orrery_engine::trace::PassTime;
use orrery_engine::trace::gpu::trees::{DeformedMesh, MeshPlace, Rig, RigRows, most_nodes};
use orrery_engine::world::{DeformStep, Deformation, MeshData};
use orrery_tests::random_scene::Random;

use crate::device_trees::gpu;

/// Runs of which the median counts.
const RUNS: usize = 21;

/// Prints the median of the whole and of each kernel, a kernel's dispatches added up.
fn report(what: &str, mut run: impl FnMut() -> Vec<PassTime>) {
    let mut totals = Vec::new();
    let mut kernels: BTreeMap<&str, (usize, Vec<f64>)> = BTreeMap::new();
    run();
    for _ in 0..RUNS {
        let passes = run();
        totals.push(passes.iter().map(|pass| pass.millis).sum::<f64>());
        let mut sums: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
        for pass in &passes {
            let (count, millis) = sums.entry(pass.name).or_default();
            *count += 1;
            *millis += pass.millis;
        }
        for (name, (count, millis)) in sums {
            let kernel = kernels.entry(name).or_default();
            kernel.0 = count;
            kernel.1.push(millis);
        }
    }
    println!("{what}: {:.4} ms", median(&mut totals));
    for (name, (count, mut millis)) in kernels {
        println!("    {name:<14} x {count:>2}  {:.4} ms", median(&mut millis));
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// A square of `side` x `side` x 2 triangles with hills.
fn hills(side: u32) -> MeshData {
    let height = |x: f64, z: f64| 0.03 * (x * 21.0).sin() * (z * 17.0).cos();
    let across = side + 1;
    let vertices = (0..across * across).map(|i| {
        let at = |n: u32| f64::from(n) / f64::from(side);
        let (x, z) = (at(i % across), at(i / across));
        DVec3::new(x, height(x, z), z)
    });
    let vertices: Vec<DVec3> = vertices.collect();
    let triangles = (0..side * side).flat_map(|i| {
        let a = i / side * across + i % side;
        [[a, a + across, a + 1], [a + 1, a + across, a + across + 1]]
    });
    let normals = vec![Vec3::Y; vertices.len()];
    MeshData::new("hills", vertices, normals, triangles.collect()).expect("a mesh")
}

#[test]
#[ignore = "measures"]
fn refit_by_triangles() {
    for side in [223_u32, 707, 1095] {
        let mesh = Arc::new(hills(side));
        let corner = |i: u32| mesh.positions[i as usize];
        let boxes = mesh.triangles.iter().map(|t| Aabb::of(t.map(corner)));
        let tree = Tree::build(&boxes.collect::<Vec<_>>());
        let triangles = tree.prims.iter().map(|&prim| {
            let [a, b, c] = mesh.triangles[prim as usize];
            TriangleRow {
                corners: [a, b, c],
                prim,
            }
        });
        let rows = RigRows {
            nodes: tree.nodes.clone(),
            triangles: triangles.collect(),
            vertices: vec![VertexRow::default(); mesh.positions.len() * 2],
            boxes: Vec::new(),
        };
        let mut rig = Rig::new(gpu(), &rows).expect("a rig");
        let place = MeshPlace {
            key: 0,
            root: 0,
            levels: &tree.levels,
            first_triangle: 0,
            first_vertex: 0,
        };
        let wave = Deformation {
            steps: vec![DeformStep::Wave {
                wave: DVec3::new(9.0, 0.0, 4.0),
                amplitude: DVec3::Y * 0.1,
                phase: 0.7,
            }],
        };
        let deformed = DeformedMesh {
            first_vertex: 0,
            first_normal: mesh.positions.len() as u32,
            data: &mesh,
            deformation: &wave,
        };
        let (count, depth) = (mesh.triangles.len(), tree.levels.len() - 1);
        report(
            &format!("deform and refit, {count} triangles, {depth} levels"),
            || rig.refit(&[deformed], &[place]).expect("refits"),
        );
    }
}

#[test]
#[ignore = "measures"]
fn instance_trees_by_count() {
    let mut random = Random::new(1);
    for count in [1000_u32, 10_000, 100_000] {
        let boxes = (0..count).map(|_| {
            let centre = (random.cube() * 100.0).as_vec3();
            let half = Vec3::splat(random.range(0.1, 1.0) as f32);
            BoxRow {
                min: (centre - half).to_array(),
                max: (centre + half).to_array(),
                ..BoxRow::default()
            }
        });
        let rows = RigRows {
            nodes: vec![Node4::EMPTY; most_nodes(count) as usize],
            boxes: boxes.collect(),
            ..RigRows::default()
        };
        let mut rig = Rig::new(gpu(), &rows).expect("a rig");
        report(&format!("instance tree, {count} boxes"), || {
            rig.build(0).expect("builds")
        });
        let built = rig.built().expect("levels");
        println!("    nodes by level {:?}", built.level_nodes);
    }
}
