//! Trees on the device, by its own timestamps: a deformed mesh and its refit, and the tree over instances.
//!
//! Targets are what an H200's own driver takes for the same.

use std::collections::BTreeMap;
use std::sync::Arc;

use orrery_engine::bvh::{Child, Extent, Node4, Tree};
use orrery_engine::frame::wire::{BoxRow, NONE, TriangleRow, VertexRow};
use orrery_engine::geom::Aabb;
use orrery_engine::trace::gpu::trees::{DeformedMesh, MeshPlace, Rig, RigRows, most_nodes};
use orrery_engine::trace::gpu::{AdapterChoice, Gpu};
use orrery_engine::trace::{PassTime, TraceError};
use orrery_engine::world::MeshData;

use super::{Sizes, trees};
use crate::args::Common;
use crate::bench::hills::{hills, wave};
use crate::bench::report::Row;
use crate::bench::timing::{millis_row, zero_row};
use crate::failure::Failure;

/// Runs before samples count: pipelines compiled.
const WARM_UP: usize = 3;
/// Milliseconds of a deformation and refit of so many triangles.
const REFIT_TARGETS: [(usize, f64); 1] = [(2_400_000, 0.33)];
/// Milliseconds of a tree over so many instances.
const BUILD_TARGETS: [(usize, f64); 2] = [(10_000, 0.2), (100_000, 0.5)];

/// Everything on the device that `--adapter` names.
pub fn rows(sizes: &Sizes, samples: usize, common: &Common) -> Result<Vec<Row>, Failure> {
    let named = common.adapter.clone().map(AdapterChoice::Named);
    let choice = named.unwrap_or(AdapterChoice::Any);
    let gpu = Arc::new(Gpu::open(Gpu::instance(), &choice, None)?);
    let mut rows = mesh_rows(&gpu, sizes.device_mesh, samples)?;
    for &count in sizes.device_trees {
        rows.extend(tree_rows(&gpu, count, samples)?);
    }
    Ok(rows)
}

/// The whole and each kernel, a kernel's dispatches added up. None where the device has no clock.
fn time_rows(
    name: &str,
    samples: usize,
    mut run: impl FnMut() -> Result<Vec<PassTime>, TraceError>,
) -> Result<Vec<Row>, Failure> {
    let mut totals = Vec::new();
    let mut kernels: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for i in 0..WARM_UP + samples {
        let passes = run()?;
        if i < WARM_UP || passes.is_empty() {
            continue;
        }
        totals.push(passes.iter().map(|pass| pass.millis).sum());
        let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
        for pass in &passes {
            *sums.entry(pass.name).or_default() += pass.millis;
        }
        for (kernel, millis) in sums {
            kernels.entry(kernel).or_default().push(millis);
        }
    }
    if totals.is_empty() {
        return Ok(Vec::new());
    }
    let mut rows = vec![millis_row(format!("{name}.total"), &totals)];
    rows.extend(
        kernels
            .iter()
            .map(|(kernel, millis)| millis_row(format!("{name}.{kernel}"), millis)),
    );
    Ok(rows)
}

/// Holds the first row against the target there is for that count.
fn hold_total(times: &mut [Row], targets: &[(usize, f64)], count: usize) {
    let target = targets.iter().find(|(of, _)| *of == count);
    if let (Some(total), Some((_, target))) = (times.first_mut(), target) {
        *total = total.clone().with_target(*target);
    }
}

/// A wave through a mesh, and its refit: vertices never leave the device.
fn mesh_rows(gpu: &Arc<Gpu>, triangles: usize, samples: usize) -> Result<Vec<Row>, Failure> {
    let mesh = Arc::new(hills(triangles).map_err(Failure::Input)?);
    let corner = |i: u32| mesh.positions[i as usize];
    let boxes = mesh.triangles.iter().map(|t| Aabb::of(t.map(corner)));
    let tree = Tree::build(&boxes.collect::<Vec<_>>());
    let triangle = |&prim: &u32| TriangleRow {
        corners: mesh.triangles[prim as usize],
        prim,
    };
    let rows = RigRows {
        nodes: tree.nodes.clone(),
        triangles: tree.prims.iter().map(triangle).collect(),
        vertices: vec![VertexRow::default(); mesh.positions.len()],
        boxes: Vec::new(),
    };
    let mut rig = Rig::new(Arc::clone(gpu), &rows)?;
    let place = MeshPlace {
        key: 0,
        root: 0,
        levels: &tree.levels,
        first_triangle: 0,
        first_vertex: 0,
    };
    let mut frame = 0;
    let name = format!("gpu.mesh.{triangles}");
    let mut times = time_rows(&name, samples, || {
        frame += 1;
        let deformed = DeformedMesh {
            first_vertex: 0,
            first_normal: NONE,
            data: &mesh,
            deformation: &wave(0.01 * f64::from(frame)),
        };
        rig.refit(&[deformed], &[place])
    })?;
    hold_total(&mut times, &REFIT_TARGETS, triangles);
    let wrong = wrong_nodes(&rig, &mesh, tree, &rows.triangles)?;
    times.push(zero_row(format!("{name}.wrong"), "nodes", wrong));
    Ok(times)
}

/// Nodes that are not, bit for bit, those of the host's refit of the device's vertices; all, if those did not move.
fn wrong_nodes(
    rig: &Rig,
    mesh: &MeshData,
    mut tree: Tree,
    triangles: &[TriangleRow],
) -> Result<u64, Failure> {
    let vertices = rig.vertices()?;
    let moved = vertices.iter().zip(&mesh.positions);
    if !moved
        .clone()
        .any(|(row, rest)| row.vector != rest.to_array())
    {
        return Ok(tree.nodes.len() as u64);
    }
    let corner = |i: u32| vertices[i as usize].vector.into();
    tree.refit(|place| Extent::of_triangle(triangles[place].corners.map(corner)));
    let nodes = rig.nodes()?;
    let pairs = nodes.iter().zip(&tree.nodes);
    Ok(pairs.filter(|(a, b)| a != b).count() as u64)
}

/// The tree over a crowd's boxes.
fn tree_rows(gpu: &Arc<Gpu>, count: usize, samples: usize) -> Result<Vec<Row>, Failure> {
    let boxes = trees::still_boxes(count);
    let row = |bounds: &Aabb| BoxRow {
        min: bounds.min.to_array(),
        max: bounds.max.to_array(),
        ..BoxRow::default()
    };
    let rows = RigRows {
        nodes: vec![Node4::EMPTY; most_nodes(count as u32) as usize],
        boxes: boxes.iter().map(row).collect(),
        ..RigRows::default()
    };
    let mut rig = Rig::new(Arc::clone(gpu), &rows)?;
    let name = format!("gpu.tree.{count}");
    let mut times = time_rows(&name, samples, || rig.build(0))?;
    hold_total(&mut times, &BUILD_TARGETS, count);
    let wrong = wrong_rows(&rig.nodes()?, &boxes);
    times.push(zero_row(format!("{name}.wrong"), "rows", wrong));
    Ok(times)
}

/// Rows that are not in exactly one leaf, or not within every box above them.
fn wrong_rows(nodes: &[Node4], boxes: &[Aabb]) -> u64 {
    let mut found = vec![0_u32; boxes.len()];
    let everywhere = Aabb {
        min: glam::Vec3::MIN,
        max: glam::Vec3::MAX,
    };
    let mut open = vec![(0_u32, everywhere)];
    while let Some((node, around)) = open.pop() {
        let Some(node) = nodes.get(node as usize) else {
            return boxes.len() as u64;
        };
        for (slot, &child) in node.children.iter().enumerate() {
            let bounds = node.child_box(slot);
            let bounds = Aabb {
                min: bounds.min.max(around.min),
                max: bounds.max.min(around.max),
            };
            match Child::decode(child) {
                Child::None => {}
                // A tree has fewer nodes than rows, or it goes round in circles.
                Child::Node(_) if open.len() > boxes.len() => return boxes.len() as u64,
                Child::Node(child) => open.push((child, bounds)),
                Child::Leaf { first, .. } => {
                    let Some(content) = boxes.get(first as usize) else {
                        return boxes.len() as u64;
                    };
                    found[first as usize] += if bounds.contains(content) { 1 } else { 2 };
                }
            }
        }
    }
    found.iter().filter(|&&times| times != 1).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_with_a_box_too_small_is_wrong() {
        let boxes = trees::still_boxes(100);
        let mut tree = Tree::build_single(&boxes);
        for child in tree.nodes.iter_mut().flat_map(|node| &mut node.children) {
            if let Child::Leaf { first, count } = Child::decode(*child) {
                let first = tree.prims[first as usize];
                *child = Child::Leaf { first, count }.encode();
            }
        }
        assert_eq!(wrong_rows(&tree.nodes, &boxes), 0);
        let mut larger = boxes.clone();
        larger[7].max += 1.0;
        assert_eq!(wrong_rows(&tree.nodes, &larger), 1);
        assert_eq!(wrong_rows(&[Node4::EMPTY], &boxes), 100);
    }
}
