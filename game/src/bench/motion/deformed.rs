//! A mesh of which every vertex moves: its refit, its deformation and refit, and rays in it.
//!
//! Rows are laid out as the tracers read them, so the refit is that of the very layout rays are traced in.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, UVec2, Vec3A};
use orrery_engine::bvh::{Extent, Tree};
use orrery_engine::frame::wire::{TriangleRow, VertexRow};
use orrery_engine::frame::{FrameScene, Instance, Shape, TraceSettings};
use orrery_engine::geom::Aabb;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::{PackedScene, Query, Ray, Tracer};
use orrery_engine::world::{Material, MeshData, MeshRow};

use super::Sizes;
use crate::bench::crowd::Random;
use crate::bench::hills::{hills, lift, wave};
use crate::bench::report::{Better, Row};
use crate::bench::timing::{median, millis, millis_row, pools, zero_row};
use crate::bench::walk::ray;
use crate::failure::Failure;

/// Runs before the clock counts.
const WARM_UP: usize = 2;
/// How fast rays may be against those in a tree built anew, at least.
const RAYS_TARGET: f64 = 0.9;

/// Everything about a mesh of that many triangles.
pub fn rows(triangles: usize, sizes: &Sizes, samples: usize) -> Result<Vec<Row>, Failure> {
    let mesh = Arc::new(hills(triangles).map_err(Failure::Input)?);
    let mut rows = Vec::new();
    for pool in pools()? {
        let name = |what: &str| format!("mesh.{triangles}.{}t.{what}", pool.current_num_threads());
        let mut bare = BareMesh::of(&mesh);
        let times = pool.install(|| millis(WARM_UP, samples, |i| bare.refit(i % 2)));
        rows.push(millis_row(name("refit"), &times));
        rows.push(zero_row(name("invalid"), "trees", bare.is_invalid()));
        let times = pool.install(|| deform_and_refit(&mesh, samples));
        rows.push(millis_row(name("deform_refit"), &times));
    }
    rows.extend(ray_rows(&mesh, triangles, sizes, samples)?);
    Ok(rows)
}

/// A mesh's rows in two poses, and its tree.
struct BareMesh {
    tree: Tree,
    triangles: Vec<TriangleRow>,
    poses: [Vec<VertexRow>; 2],
    /// Which pose the tree fits.
    pose: usize,
}

impl BareMesh {
    fn of(mesh: &MeshData) -> Self {
        let corner = |i: u32| mesh.positions[i as usize];
        let boxes = mesh.triangles.iter().map(|t| Aabb::of(t.map(corner)));
        let tree = Tree::build(&boxes.collect::<Vec<_>>());
        let triangle = |&prim: &u32| TriangleRow {
            corners: mesh.triangles[prim as usize],
            prim,
        };
        let pose = |share: f64| {
            let moved = mesh.vertices.iter().map(|&p| VertexRow {
                vector: (p + lift(p, share) - mesh.origin).as_vec3().to_array(),
                further: 0,
            });
            moved.collect()
        };
        Self {
            triangles: tree.prims.iter().map(triangle).collect(),
            tree,
            poses: [pose(0.2), pose(0.6)],
            pose: 0,
        }
    }

    fn refit(&mut self, pose: usize) {
        self.pose = pose;
        let (vertices, triangles) = (&self.poses[pose], &self.triangles);
        let corner = |i: u32| Vec3A::from_array(vertices[i as usize].vector);
        self.tree
            .refit(|place| Extent::of_triangle(triangles[place].corners.map(corner)));
    }

    fn is_invalid(&self) -> u64 {
        let corner = |i: u32| self.poses[self.pose][i as usize].vector.into();
        let mut boxes = vec![Aabb::EMPTY; self.triangles.len()];
        for row in &self.triangles {
            boxes[row.prim as usize] = Aabb::of(row.corners.map(corner));
        }
        u64::from(self.tree.validate(&boxes).is_err())
    }
}

/// A frame that shows the mesh after a share of the wave's period.
fn frame(mesh: &Arc<MeshData>, share: Option<f64>) -> FrameScene {
    let mut scene = FrameScene::default();
    scene.materials.push(Material::default());
    scene.meshes.push(row(mesh, share));
    scene.instances.push(Instance {
        tag: 0,
        shape: Shape::Mesh(0),
        world_from_local: glam::DAffine3::IDENTITY,
        material: 0,
    });
    scene
}

fn row(mesh: &Arc<MeshData>, share: Option<f64>) -> MeshRow {
    MeshRow {
        data: Arc::clone(mesh),
        deformation: share.map(|share| Arc::new(wave(share))),
        ..MeshRow::default()
    }
}

/// A frame with the mesh as it is deformed in it, its vertices at rest there: for those who cannot deform.
pub fn still(triangles: usize) -> Result<FrameScene, Failure> {
    let mesh = hills(triangles).map_err(Failure::Input)?;
    let vertices = mesh.vertices.iter().map(|&p| p + lift(p, 0.2)).collect();
    let mesh = MeshData::new(mesh.name, vertices, Vec::new(), mesh.triangles);
    Ok(frame(&Arc::new(mesh.map_err(Failure::Input)?), None))
}

/// What the tracers' packer takes over it: the wave's vertices, then the refit.
fn deform_and_refit(mesh: &Arc<MeshData>, samples: usize) -> Vec<f64> {
    let mut scene = frame(mesh, None);
    let mut packed = PackedScene::default();
    packed.refit(&scene);
    millis(WARM_UP, samples, |i| {
        scene
            .meshes
            .replace(0, row(mesh, Some(0.01 * (i + 1) as f64)));
        packed.refit(&scene);
    })
}

/// A tracer that has come to a frame.
fn tracer_at(scenes: &[&FrameScene]) -> Result<CpuTracer, Failure> {
    let mut tracer = CpuTracer::new();
    for scene in scenes {
        tracer.refit(scene)?;
        tracer.upload(
            scene,
            &TraceSettings {
                size: UVec2::ONE,
                ..TraceSettings::default()
            },
        )?;
    }
    Ok(tracer)
}

/// Rays a second at rest, deformed in the refitted tree, and deformed in a tree built anew, on all threads.
fn ray_rows(
    mesh: &Arc<MeshData>,
    triangles: usize,
    sizes: &Sizes,
    samples: usize,
) -> Result<Vec<Row>, Failure> {
    let rays = rays_through(sizes.rays);
    let rest = frame(mesh, None);
    let deformed = frame(mesh, Some(0.3));
    let mut moving = frame(mesh, None);
    let mut refitted = tracer_at(&[&moving])?;
    moving.meshes.replace(0, row(mesh, Some(0.3)));
    refitted.refit(&moving)?;
    refitted.upload(&moving, &TraceSettings::default())?;
    let mut tracers = [tracer_at(&[&rest])?, refitted, tracer_at(&[&deformed])?];
    let mut rates = [(); 3].map(|()| Vec::with_capacity(samples));
    let mut wrong = 0;
    for _ in 0..samples {
        let mut answers = Vec::with_capacity(3);
        for (tracer, rates) in tracers.iter_mut().zip(&mut rates) {
            let start = Instant::now();
            answers.push(tracer.intersect(&rays, Query::Closest)?);
            rates.push(rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6);
        }
        let pairs = answers[1].iter().zip(&answers[2]);
        wrong += pairs.filter(|(a, b)| a != b).count() as u64;
    }
    let name = |what: &str| format!("mesh.{triangles}.rays.{what}");
    let words = ["at_rest", "refitted", "rebuilt"];
    let mut rows: Vec<Row> = words
        .iter()
        .zip(&rates)
        .map(|(what, rates)| Row::sampled(name(what), "Mrays/s", Better::Higher, rates))
        .collect();
    let [_, refitted, rebuilt] = rates.map(|rates| median(&rates));
    rows.push(
        Row::single(name("ratio"), "1", Better::Higher, refitted / rebuilt)
            .with_target(RAYS_TARGET),
    );
    rows.push(zero_row(name("wrong"), "rays", wrong));
    Ok(rows)
}

/// Rays from above the field into it, anywhere.
fn rays_through(count: usize) -> Vec<Ray> {
    let mut random = Random(3);
    let ray_of = |_| {
        let from = DVec3::new(random.between(0.0, 1.0), 0.5, random.between(0.0, 1.0));
        let to = DVec3::new(random.between(0.0, 1.0), 0.0, random.between(0.0, 1.0));
        ray(from.as_vec3(), (to - from).as_vec3())
    };
    (0..count).map(ray_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bare_mesh_is_refitted_to_its_pose() {
        let mesh = hills(200).unwrap();
        let mut bare = BareMesh::of(&mesh);
        bare.refit(0);
        assert_eq!(bare.is_invalid(), 0);
        bare.pose = 1;
        assert_eq!(bare.is_invalid(), 1, "another pose does not fit");
    }
}
