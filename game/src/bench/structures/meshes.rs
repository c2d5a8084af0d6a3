//! Trees of a scene's meshes under a structure: builds, refits, and what camera rays visit in them.

use glam::{Affine3A, DAffine3, UVec2, Vec3, Vec3A};
use orrery_engine::bvh::{Bounds, Extent, Tree};
use orrery_engine::geom::{Aabb, Shear};
use orrery_engine::trace::Ray;
use orrery_engine::world::{MeshData, Structure};

use super::stages::Stage;
use crate::bench::rays::primary_rays;
use crate::bench::report::{Better, Row};
use crate::bench::timing::{millis, millis_row, zero_row};
use crate::bench::walk::Walker;

/// Runs before the clock counts.
const WARM_UP: usize = 2;
/// Camera rays across and down, whatever the size of pictures: counts a ray depend little on it.
const RAYS: UVec2 = UVec2::new(128, 96);

/// A mesh and its tree; vertices are about the mesh's origin.
struct Built<'a> {
    mesh: &'a MeshData,
    tree: Tree,
}

/// Of all meshes together, on the calling pool of threads.
pub fn rows(name: &str, stage: &Stage, structure: Structure, samples: usize) -> Vec<Row> {
    let boxes: Vec<Vec<Aabb>> = stage.meshes.iter().map(|mesh| boxes_of(mesh)).collect();
    let mut trees = Vec::new();
    let builds = millis(WARM_UP, samples, |_| {
        trees = boxes.iter().map(|boxes| build(structure, boxes)).collect();
    });
    let refits = millis(WARM_UP, samples, |_| {
        for (tree, mesh) in trees.iter_mut().zip(&stage.meshes) {
            refit(tree, mesh);
        }
    });
    let invalid = trees
        .iter()
        .zip(&boxes)
        .filter(|(t, b)| t.validate(b).is_err());
    let invalid = invalid.count() as u64;
    let meshes = stage.meshes.iter().map(|mesh| &**mesh);
    let built: Vec<Built> = meshes
        .zip(trees)
        .map(|(mesh, tree)| Built { mesh, tree })
        .collect();
    let visits = visits(stage, &built);
    let row = |what: &str| format!("{name}.{what}");
    vec![
        millis_row(row("build"), &builds),
        millis_row(row("refit"), &refits),
        zero_row(row("invalid"), "trees", invalid),
        Row::single(row("nodes"), "per ray", Better::Lower, visits.nodes),
        Row::single(row("triangles"), "per ray", Better::Lower, visits.triangles),
    ]
}

fn boxes_of(mesh: &MeshData) -> Vec<Aabb> {
    let corner = |i: u32| mesh.positions[i as usize];
    let boxes = mesh.triangles.iter().map(|t| Aabb::of(t.map(corner)));
    boxes.collect()
}

fn build(structure: Structure, boxes: &[Aabb]) -> Tree {
    match structure {
        Structure::Boxes4 => Tree::build(boxes),
        Structure::Boxes2 => Tree::build_binary(boxes),
        Structure::Spheres { leaf } => Tree::build_spheres(boxes, leaf),
        Structure::None => Tree::unculled(boxes.len() as u32),
    }
}

fn refit(tree: &mut Tree, mesh: &MeshData) {
    let prims = std::mem::take(&mut tree.prims);
    let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
    tree.refit(|place| Extent::of_triangle(mesh.triangles[prims[place] as usize].map(corner)));
    tree.prims = prims;
}

/// Means over camera rays.
struct Visits {
    nodes: f64,
    triangles: f64,
}

/// Looks for the nearest triangle of every camera ray, instances by a tree of their own, and counts in meshes.
fn visits(stage: &Stage, built: &[Built]) -> Visits {
    let eye = DAffine3::from_translation(-stage.view.origin);
    let placed: Vec<(usize, DAffine3)> = stage
        .instances
        .iter()
        .map(|&(mesh, map)| {
            let origin = DAffine3::from_translation(built[mesh].mesh.origin);
            (mesh, eye * map * origin)
        })
        .collect();
    let around = |&(mesh, map): &(usize, DAffine3)| {
        let positions = built[mesh].mesh.positions.iter();
        Aabb::of(positions.map(|p| map.transform_point3(p.as_dvec3()).as_vec3())).grown()
    };
    let instances = Tree::build_single(&placed.iter().map(around).collect::<Vec<_>>());
    let inverses: Vec<Affine3A> = placed
        .iter()
        .map(|(_, map)| map.inverse().as_affine3a())
        .collect();
    let (mut top, mut bottom, mut triangles) = (Walker::default(), Walker::default(), 0_u64);
    let rays = primary_rays(&stage.view, RAYS);
    for ray in &rays {
        top.walk(
            &instances.nodes,
            Bounds::Boxes,
            ray,
            ray.t_max,
            |first, count, mut reach| {
                for place in first..first + count {
                    let index = instances.prims[place as usize] as usize;
                    let (mesh, map) = (&built[placed[index].0], &inverses[index]);
                    let local = Ray {
                        origin: map.transform_point3(ray.origin),
                        dir: map.transform_vector3(ray.dir),
                        ..*ray
                    };
                    reach = nearest(mesh, &local, reach, &mut bottom, &mut triangles);
                }
                reach
            },
        );
    }
    let each = |count: u64| count as f64 / rays.len() as f64;
    Visits {
        nodes: each(bottom.nodes),
        triangles: each(triangles),
    }
}

/// How far a ray comes in a mesh, at most `reach`.
fn nearest(built: &Built, ray: &Ray, reach: f32, walker: &mut Walker, triangles: &mut u64) -> f32 {
    let shear = Shear::new(ray.dir);
    let corner = |i: u32| -> Vec3 { built.mesh.positions[i as usize] };
    let tree = &built.tree;
    let mut nearest = reach;
    walker.walk(&tree.nodes, tree.bounds, ray, reach, |first, count, _| {
        *triangles += u64::from(count);
        for &prim in &tree.prims[first as usize..(first + count) as usize] {
            let corners = built.mesh.triangles[prim as usize].map(corner);
            if let Some(hit) = shear.intersect(ray.origin, corners)
                && hit.t > 0.0
            {
                nearest = nearest.min(hit.t);
            }
        }
        nearest
    });
    nearest
}
