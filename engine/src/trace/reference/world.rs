//! The scene as the reference sees it: each instance's maps in f64 relative to the eye, and the nearest hit.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::deform;
use super::explain::Recorder;
use super::look::{Chart, Cutout, Look, look_at};
use super::shape::{self, LocalHit, LocalRay};
use super::torus::{self, on_torus, torus_normal};
use super::tree::{MeshTree, enters};
use crate::frame::{FrameScene, Shape};
use crate::trace::Ray;
use crate::world::{Cone, Deformation, MeshData, MeshRow, deformed_vertices};

/// Orders hits: t, then instance, then primitive.
pub type Key = (f64, u32, u32);

/// A hit in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldHit {
    /// Its place in the order of hits.
    pub key: Key,
    /// Weights of a triangle's second and third corner.
    pub uv: DVec2,
}

/// A ray relative to the eye.
#[derive(Clone, Copy)]
pub struct WorldRay {
    /// Start.
    pub origin: DVec3,
    /// Direction of any length.
    pub dir: DVec3,
    /// Of its cone where it starts.
    pub width: f64,
    /// Instance and primitive it starts on.
    pub start: Option<(u32, u32)>,
}

impl From<&Ray> for WorldRay {
    fn from(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.as_dvec3(),
            dir: ray.dir.as_dvec3(),
            width: 0.0,
            start: None,
        }
    }
}

struct Placed {
    id: u32,
    /// About a point near its middle, like the maps below.
    shape: Shape,
    material: u32,
    render_from_local: DAffine3,
    local_from_render: DAffine3,
    /// Inverse transpose: carries normals.
    normal_map: DMat3,
    cutout: Option<Cutout>,
}

/// A mesh as it is deformed.
struct Shown {
    /// What it was made from.
    source: Arc<MeshData>,
    deformation: Option<Arc<Deformation>>,
    /// Triangles and deformed vertices.
    mesh: MeshData,
    /// One a vertex for smooth shading; empty: flat.
    normals: Vec<DVec3>,
    tree: MeshTree,
}

impl Shown {
    fn new(row: &MeshRow) -> Self {
        let deformation = row.deformation.clone();
        let mut vertices = deformed_vertices(&row.data, deformation.as_deref());
        let origin = row.data.origin;
        vertices.iter_mut().for_each(|vertex| *vertex -= origin);
        let normals = deform::normals(&row.data, deformation.is_some(), &vertices);
        let mesh = MeshData {
            vertices,
            triangles: row.data.triangles.clone(),
            ..MeshData::default()
        };
        Self {
            source: Arc::clone(&row.data),
            deformation,
            tree: MeshTree::build(&mesh),
            mesh,
            normals,
        }
    }

    fn is_of(&self, row: &MeshRow) -> bool {
        Arc::ptr_eq(&self.source, &row.data) && self.deformation == row.deformation
    }
}

/// All instances, placed relative to the eye, with the meshes' trees.
#[derive(Default)]
pub struct World {
    meshes: Vec<Shown>,
    placed: Vec<Placed>,
}

impl World {
    /// Deforms meshes that are new or changed and builds their trees; returns how many.
    pub fn refit(&mut self, scene: &FrameScene) -> u64 {
        let mut built = 0;
        self.meshes.truncate(scene.meshes.len());
        for (i, row) in scene.meshes.iter().enumerate() {
            if self.meshes.get(i).is_some_and(|shown| shown.is_of(row)) {
                continue;
            }
            built += 1;
            let shown = Shown::new(row);
            if i < self.meshes.len() {
                self.meshes[i] = shown;
            } else {
                self.meshes.push(shown);
            }
        }
        built
    }

    /// Places the instances relative to the eye.
    pub fn place(&mut self, scene: &FrameScene) {
        self.placed.clear();
        for (id, instance) in scene.instances.iter().enumerate() {
            if instance.shape == Shape::Vacant {
                continue;
            }
            let (shape, middle) = self.about_middle(instance.shape);
            let mut render_from_local = instance.world_from_local;
            // In this order: only the first difference is of large numbers, and it is exact or nearly so.
            render_from_local.translation = (render_from_local.translation - scene.view.origin)
                + render_from_local.matrix3 * middle;
            let local_from_render = render_from_local.inverse();
            self.placed.push(Placed {
                id: id as u32,
                shape,
                material: instance.material,
                render_from_local,
                local_from_render,
                normal_map: local_from_render.matrix3.transpose(),
                cutout: Cutout::of(scene, &scene.materials[instance.material as usize]),
            });
        }
    }

    /// A shape about a point near its middle, and that point: a scene far from the origin loses no digits.
    fn about_middle(&self, shape: Shape) -> (Shape, DVec3) {
        match shape {
            Shape::Mesh(mesh) => (shape, self.meshes[mesh as usize].source.origin),
            Shape::Plane { normal, distance } => {
                let distance_zero = Shape::Plane {
                    normal,
                    distance: 0.0,
                };
                (distance_zero, normal * (distance / normal.length_squared()))
            }
            Shape::Cuboid { min, max } => {
                let middle = (min + max) * 0.5;
                let centred = Shape::Cuboid {
                    min: min - middle,
                    max: max - middle,
                };
                (centred, middle)
            }
            Shape::Disc {
                center,
                normal,
                radius,
            } => {
                let centred = Shape::Disc {
                    center: DVec3::ZERO,
                    normal,
                    radius,
                };
                (centred, center)
            }
            Shape::Cone(Cone {
                a,
                radius_a,
                b,
                radius_b,
                open,
            }) => {
                let middle = (a + b) * 0.5;
                let centred = Shape::Cone(Cone {
                    a: a - middle,
                    radius_a,
                    b: b - middle,
                    radius_b,
                    open,
                });
                (centred, middle)
            }
            Shape::Sphere { .. } | Shape::Torus { .. } | Shape::Vacant => (shape, DVec3::ZERO),
        }
    }

    /// The first hit in the order of keys with `after < key < before`.
    pub fn nearest(&self, ray: &WorldRay, after: Key, before: Key) -> Option<WorldHit> {
        self.nearest_told(ray, after, before, &mut ())
    }

    /// [`World::nearest`], with every test told to a recorder.
    pub fn nearest_told(
        &self,
        ray: &WorldRay,
        after: Key,
        before: Key,
        recorder: &mut impl Recorder,
    ) -> Option<WorldHit> {
        let mut best: Option<WorldHit> = None;
        for placed in &self.placed {
            let local = LocalRay {
                origin: placed.local_from_render.transform_point3(ray.origin),
                dir: placed.local_from_render.transform_vector3(ray.dir),
                start: ray
                    .start
                    .and_then(|(id, prim)| (id == placed.id).then_some(prim)),
            };
            let mut offer = |hit: LocalHit| {
                let key = (hit.t, placed.id, hit.prim);
                let limit = best.map_or(before, |b| b.key);
                if key > after && key < limit {
                    best = Some(WorldHit { key, uv: hit.uv });
                }
                best.map_or(before.0, |b| b.key.0)
            };
            if !matches!(placed.shape, Shape::Mesh(_)) {
                recorder.test_shape();
            }
            match placed.shape {
                Shape::Vacant => {}
                Shape::Mesh(mesh) => {
                    let shown = &self.meshes[mesh as usize];
                    let cutout = placed.cutout.as_ref();
                    let is_hole =
                        |hit: &LocalHit| cutout.is_some_and(|c| c.is_hole(&shown.source, hit));
                    let tree = &shown.tree;
                    tree.hits(&shown.mesh, &local, recorder, is_hole, offer);
                }
                Shape::Sphere { radius } => {
                    let bounds = DVec3::splat(radius);
                    if enters(&local, -bounds, bounds, f64::INFINITY) {
                        for hit in shape::sphere(&local, radius) {
                            offer(hit);
                        }
                    }
                }
                Shape::Plane { normal, distance } => {
                    for hit in shape::plane(&local, normal, distance) {
                        offer(hit);
                    }
                }
                Shape::Cuboid { min, max } => {
                    for hit in shape::cuboid(&local, min, max) {
                        offer(hit);
                    }
                }
                Shape::Disc {
                    center,
                    normal,
                    radius,
                } => {
                    for hit in shape::disc(&local, center, normal, radius) {
                        offer(hit);
                    }
                }
                Shape::Cone(cone) => {
                    for hit in shape::cone(&local, &cone) {
                        offer(hit);
                    }
                }
                Shape::Torus { major, minor } => {
                    for hit in torus::torus(&local, major, minor) {
                        offer(hit);
                    }
                }
            }
        }
        best
    }

    /// Face normal and shading normal of a hit, unit, not yet turned to the viewer; and the material row.
    pub fn normals(&self, hit: &WorldHit, point: DVec3) -> (DVec3, DVec3, u32) {
        let (_, id, prim) = hit.key;
        let index = self.placed.binary_search_by_key(&id, |p| p.id);
        let placed = &self.placed[index.expect("a hit names a placed instance")];
        let local = match placed.shape {
            Shape::Mesh(mesh) => {
                let Shown { mesh, normals, .. } = &self.meshes[mesh as usize];
                let corners = mesh.triangles[prim as usize].map(|i| i as usize);
                let [a, b, c] = corners.map(|i| mesh.vertices[i]);
                let face = (b - a).cross(c - a);
                if normals.is_empty() {
                    (face, face)
                } else {
                    let [na, nb, nc] = corners.map(|i| normals[i]);
                    let w = 1.0 - hit.uv.x - hit.uv.y;
                    (face, na * w + nb * hit.uv.x + nc * hit.uv.y)
                }
            }
            Shape::Plane { normal, .. } | Shape::Disc { normal, .. } => (normal, normal),
            Shape::Cone(cone) => {
                let out = shape::cone_normal(
                    &cone,
                    prim,
                    placed.local_from_render.transform_point3(point),
                );
                (out, out)
            }
            Shape::Torus { major, .. } => {
                let local = placed.local_from_render.transform_point3(point);
                let out = torus_normal(local, major);
                (out, out)
            }
            Shape::Cuboid { .. } => (shape::cuboid_normal(prim), shape::cuboid_normal(prim)),
            Shape::Sphere { .. } | Shape::Vacant => {
                let out = placed.local_from_render.transform_point3(point);
                (out, out)
            }
        };
        let world = |n: DVec3| (placed.normal_map * n).normalize_or(DVec3::Y);
        (world(local.0), world(local.1), placed.material)
    }

    /// From a hit to the curved surface that a mesh's triangles stand for, if they do: the point moved onto the plane of each
    /// vertex that it is below, and the means of those. `outward` is negative where the mesh is seen from within.
    pub fn lift(&self, hit: &WorldHit, outward: f64) -> Option<DVec3> {
        let (_, id, prim) = hit.key;
        let index = self.placed.binary_search_by_key(&id, |p| p.id).ok()?;
        let placed = &self.placed[index];
        let Shape::Mesh(mesh) = placed.shape else {
            return None;
        };
        let shown = &self.meshes[mesh as usize];
        if !shown.source.curved || shown.normals.is_empty() {
            return None;
        }
        let corners = shown.mesh.triangles[prim as usize].map(|i| i as usize);
        let weights = [1.0 - hit.uv.x - hit.uv.y, hit.uv.x, hit.uv.y];
        let vertex = |i: usize| shown.mesh.vertices[i];
        let at: DVec3 = (0..3).map(|i| vertex(corners[i]) * weights[i]).sum();
        let over = |i: usize| {
            let normal = shown.normals[corners[i]] * outward.signum();
            normal * (-(at - vertex(corners[i])).dot(normal)).max(0.0) * weights[i]
        };
        let local: DVec3 = (0..3).map(over).sum();
        Some(placed.render_from_local.transform_vector3(local))
    }

    /// The looks of a hit on a mesh that has some, and how its triangle lies on a texture.
    pub fn look(&self, hit: &WorldHit) -> Option<(Look, Chart)> {
        let (_, id, prim) = hit.key;
        let index = self.placed.binary_search_by_key(&id, |p| p.id).ok()?;
        let placed = &self.placed[index];
        let Shape::Mesh(mesh) = placed.shape else {
            return None;
        };
        let Shown { mesh, source, .. } = &self.meshes[mesh as usize];
        let look = look_at(source, prim, hit.uv)?;
        let corners = mesh.triangles[prim as usize].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| mesh.vertices[i]);
        let uv = |i: usize| source.uvs.get(i).map_or(DVec2::ZERO, |uv| uv.as_dvec2());
        let [ua, ub, uc] = corners.map(uv);
        let edge = |edge| placed.render_from_local.transform_vector3(edge);
        let chart = Chart {
            edges: [edge(b - a), edge(c - a)],
            spans: [ub - ua, uc - ua],
        };
        Some((look, chart))
    }

    /// The hit's point moved onto its primitive, relative to the eye: spheres drift most without this.
    pub fn on_surface(&self, hit: &WorldHit, point: DVec3) -> DVec3 {
        let (_, id, _) = hit.key;
        let Ok(index) = self.placed.binary_search_by_key(&id, |p| p.id) else {
            return point;
        };
        let placed = &self.placed[index];
        let local = placed.local_from_render.transform_point3(point);
        let moved = match placed.shape {
            Shape::Sphere { radius } => local.normalize_or(DVec3::Y) * radius,
            Shape::Torus { major, minor } => on_torus(local, major, minor),
            _ => return point,
        };
        placed.render_from_local.transform_point3(moved)
    }
}
