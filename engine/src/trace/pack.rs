//! FrameScene to the rows that both f32 tracers read.
//!
//! Here f64 becomes f32: positions relative to the eye are subtracted in f64 first, so a scene far from
//! the origin packs to the same bits as the same scene near it (ACCURACY row 14).

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use crate::bvh::{Node4, Tree};
use crate::frame::wire::{
    GENERATIONS_CAPACITY, INSTANCE_TRANSMITS, InstanceRow, KIND_CUBOID, KIND_ELLIPSOID, KIND_MESH,
    KIND_PLANE, KIND_SPHERE, LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LightRow,
    MATERIAL_FRESNEL, MATERIAL_MIRROR, MATERIAL_TRANSMITS, MaterialRow, NONE, NormalRow,
    PROJECTION_ORTHOGRAPHIC, PROJECTION_PERSPECTIVE, TriangleRow, ViewRow,
};
use crate::frame::{
    FrameScene, Instance, Light, LightKind, Shape, TraceSettings, View, ViewProjection,
};
use crate::geom::{Aabb, AffineRows};
use crate::world::{Material, MeshData, Reflection};

/// The rows of a frame.
#[derive(Default)]
pub struct PackedScene {
    /// The uniform.
    pub view: ViewRow,
    /// Trees of all meshes, then, from `instance_nodes_start`, the tree over instances.
    pub nodes: Vec<Node4>,
    /// Where the instance tree begins.
    pub instance_nodes_start: u32,
    /// Triangles of all meshes, each mesh's in the order of its leaves.
    pub triangles: Vec<TriangleRow>,
    /// Vertex normals of smooth meshes, three a triangle.
    pub normals: Vec<NormalRow>,
    /// Planes, then everything else, in order of id.
    pub instances: Vec<InstanceRow>,
    /// Materials.
    pub materials: Vec<MaterialRow>,
    /// Lights.
    pub lights: Vec<LightRow>,
    /// Some instance lets light through, so shadows are not all or nothing.
    pub transparent: bool,
    /// Another number whenever `triangles`, `normals` or the meshes' part of `nodes` changed.
    pub mesh_version: u64,
    /// Trees built by the last [`PackedScene::refit`] and [`PackedScene::pack`].
    pub trees_updated: u64,
    meshes: Vec<PackedMesh>,
}

/// A mesh's tree and where its rows are.
struct PackedMesh {
    source: Arc<MeshData>,
    tree: Tree,
    bounds: Aabb,
    root: u32,
    first_triangle: u32,
}

impl PackedScene {
    /// Builds the trees of meshes that are new or changed and lays all meshes out again if any was.
    pub fn refit(&mut self, scene: &FrameScene) {
        self.trees_updated = 0;
        let fresh: Vec<(usize, &Arc<MeshData>)> = scene
            .meshes
            .iter()
            .enumerate()
            .filter(|(i, mesh)| {
                self.meshes
                    .get(*i)
                    .is_none_or(|packed| !Arc::ptr_eq(&packed.source, mesh))
            })
            .collect();
        if fresh.is_empty() && self.meshes.len() == scene.meshes.len() {
            return;
        }
        let built: Vec<(usize, PackedMesh)> = fresh
            .into_par_iter()
            .map(|(i, mesh)| (i, PackedMesh::build(Arc::clone(mesh))))
            .collect();
        self.trees_updated = built.len() as u64;
        self.meshes.truncate(scene.meshes.len());
        for (i, mesh) in built {
            if i < self.meshes.len() {
                self.meshes[i] = mesh;
            } else {
                self.meshes.push(mesh);
            }
        }
        self.lay_out_meshes();
    }

    fn lay_out_meshes(&mut self) {
        self.nodes.clear();
        self.triangles.clear();
        self.normals.clear();
        self.mesh_version += 1;
        for mesh in &mut self.meshes {
            mesh.root = self.nodes.len() as u32;
            mesh.first_triangle = self.triangles.len() as u32;
            self.nodes.extend_from_slice(&mesh.tree.nodes);
            for &prim in &mesh.tree.prims {
                let corners = mesh.source.triangles[prim as usize];
                let [a, b, c] = corners.map(|i| mesh.source.positions[i as usize].to_array());
                let mut normals = NONE;
                if !mesh.source.normals.is_empty() {
                    normals = self.normals.len() as u32;
                    self.normals.extend(corners.map(|i| NormalRow {
                        normal: mesh.source.normals[i as usize].to_array(),
                        spare: 0,
                    }));
                }
                self.triangles.push(TriangleRow {
                    a,
                    prim,
                    b,
                    normals,
                    c,
                    spare: 0,
                });
            }
        }
        self.instance_nodes_start = self.nodes.len() as u32;
    }

    /// Packs everything that depends on the eye, and builds the tree over instances.
    pub fn pack(&mut self, scene: &FrameScene, settings: &TraceSettings) {
        self.materials.clear();
        self.materials
            .extend(scene.materials.iter().map(material_row));
        let eye = scene.view.origin;
        self.lights.clear();
        self.lights
            .extend(scene.lights.iter().map(|light| light_row(light, eye)));
        self.instances.clear();
        let mut boxes = Vec::with_capacity(scene.instances.len());
        for planes in [true, false] {
            for (id, instance) in scene.instances.iter().enumerate() {
                if matches!(instance.shape, Shape::Plane { .. }) != planes {
                    continue;
                }
                if let Some((row, bounds)) = self.instance_row(id as u32, instance, scene) {
                    self.instances.push(row);
                    if !planes {
                        boxes.push(bounds);
                    }
                }
            }
        }
        self.transparent = self
            .instances
            .iter()
            .any(|row| row.flags & INSTANCE_TRANSMITS != 0);
        let plane_count = (self.instances.len() - boxes.len()) as u32;
        let mut tree = Tree::build_fast(&boxes);
        resolve_leaves(&mut tree, plane_count);
        self.trees_updated += 1;
        self.nodes.truncate(self.instance_nodes_start as usize);
        self.nodes.extend_from_slice(&tree.nodes);
        let root = if tree.nodes.is_empty() {
            NONE
        } else {
            self.instance_nodes_start
        };
        self.view = view_row(&scene.view, settings);
        self.view.background = scene.background.to_array();
        self.view.max_generations = scene.max_generations.min(GENERATIONS_CAPACITY);
        self.view.plane_count = plane_count;
        self.view.light_count = self.lights.len() as u32;
        self.view.root = root;
    }

    /// The row of an instance and its box in render space; none if it draws nothing.
    fn instance_row(
        &self,
        id: u32,
        instance: &Instance,
        scene: &FrameScene,
    ) -> Option<(InstanceRow, Aabb)> {
        let mut render_from_local = instance.world_from_local;
        render_from_local.translation -= scene.view.origin;
        let transmits = scene.materials[instance.material as usize].transmission();
        let mut row = InstanceRow {
            id,
            material: instance.material,
            flags: if transmits.max_element() > 0.0 {
                INSTANCE_TRANSMITS
            } else {
                0
            },
            ..Default::default()
        };
        let mut affine = |kind, render_from_unit: DAffine3, local: Aabb| {
            let unit_from_render = render_from_unit.inverse();
            row.kind = kind;
            row.world_from_local = AffineRows::new(render_from_unit);
            row.local_from_world = AffineRows::new(unit_from_render);
            let condition = frobenius(&render_from_unit) * frobenius(&unit_from_render);
            render_box(&render_from_unit, &local, condition)
        };
        let unit_box = Aabb {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        let bounds = match instance.shape {
            Shape::Vacant => return None,
            Shape::Mesh(mesh) => {
                let mesh = &self.meshes[mesh as usize];
                if mesh.tree.nodes.is_empty() {
                    return None;
                }
                let recentre = DAffine3::from_translation(mesh.source.origin);
                let bounds = affine(KIND_MESH, render_from_local * recentre, mesh.bounds);
                row.root = mesh.root;
                row.first_triangle = mesh.first_triangle;
                bounds
            }
            Shape::Sphere { radius } => match uniform_scale(&render_from_local) {
                Some(scale) => {
                    row.kind = KIND_SPHERE;
                    let c = render_from_local.translation.as_vec3();
                    let r = (radius * scale) as f32;
                    row.local_from_world.0[0] = [c.x, c.y, c.z, r];
                    padded(c - r, c + r, 4.0)
                }
                None => {
                    let unit = DAffine3::from_scale(DVec3::splat(radius));
                    affine(KIND_ELLIPSOID, render_from_local * unit, unit_box)
                }
            },
            Shape::Cuboid { min, max } => {
                let unit = DAffine3::from_scale_rotation_translation(
                    (max - min) * 0.5,
                    glam::DQuat::IDENTITY,
                    (max + min) * 0.5,
                );
                affine(KIND_CUBOID, render_from_local * unit, unit_box)
            }
            Shape::Plane { normal, distance } => {
                row.kind = KIND_PLANE;
                row.local_from_world.0[0] = render_plane(&render_from_local, normal, distance);
                Aabb::EMPTY
            }
        };
        Some((row, bounds))
    }
}

impl PackedMesh {
    fn build(source: Arc<MeshData>) -> Self {
        let corner = |i: u32| source.positions[i as usize];
        let boxes: Vec<Aabb> = source
            .triangles
            .iter()
            .map(|t| Aabb::of(t.map(corner)))
            .collect();
        Self {
            tree: Tree::build(&boxes),
            bounds: boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)),
            root: 0,
            first_triangle: 0,
            source,
        }
    }
}

/// Puts instance rows straight into the leaves, which hold one each: saves a look-up a leaf.
fn resolve_leaves(tree: &mut Tree, plane_count: u32) {
    use crate::bvh::Child;
    for slot in tree.nodes.iter_mut().flat_map(|n| &mut n.children) {
        if let Child::Leaf { first, count } = Child::decode(*slot) {
            let row = tree.prims[first as usize] + plane_count;
            *slot = Child::Leaf { first: row, count }.encode();
        }
    }
}

/// The scale of a map that is nothing but scale, rotation and translation, to f64 accuracy.
fn uniform_scale(map: &DAffine3) -> Option<f64> {
    let m = map.matrix3;
    let scale = m.x_axis.length();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * scale;
    let uniform = close(m.y_axis.length(), scale)
        && close(m.z_axis.length(), scale)
        && close(m.x_axis.dot(m.y_axis) / scale, 0.0)
        && close(m.y_axis.dot(m.z_axis) / scale, 0.0)
        && close(m.z_axis.dot(m.x_axis) / scale, 0.0);
    uniform.then_some(scale)
}

fn frobenius(map: &DAffine3) -> f64 {
    let m = map.matrix3;
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

/// The render-space box of a local box, widened by what the intersector's f32 transform may err by:
/// a few roundings of |M^-1| (|M| |p|), hence the condition number.
fn render_box(render_from_local: &DAffine3, local: &Aabb, condition: f64) -> Aabb {
    let (min, max) = (local.min.as_dvec3(), local.max.as_dvec3());
    let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let m = render_from_local.matrix3;
    let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    let center = render_from_local.transform_point3(center);
    padded(
        (center - reach).as_vec3(),
        (center + reach).as_vec3(),
        2.0 * condition as f32,
    )
}

/// A box widened by `ulps` of its largest coordinate.
fn padded(min: Vec3, max: Vec3, ulps: f32) -> Aabb {
    let pad = min.abs().max(max.abs()).max_element() * f32::EPSILON * ulps;
    Aabb {
        min: min - pad,
        max: max + pad,
    }
}

/// Unit normal and distance of a transformed plane relative to the eye.
fn render_plane(render_from_local: &DAffine3, normal: DVec3, distance: f64) -> [f32; 4] {
    let point = render_from_local.transform_point3(normal * (distance / normal.length_squared()));
    let n = (render_from_local.matrix3.inverse().transpose() * normal).normalize();
    [n.x as f32, n.y as f32, n.z as f32, n.dot(point) as f32]
}

fn view_row(view: &View, settings: &TraceSettings) -> ViewRow {
    // Divided here in f64: a device's division may be 2.5 ulp off, which moves edges by a pixel now and then.
    let half_pixels = settings.size.as_dvec2() * 2.0;
    ViewRow {
        forward: view.forward.as_vec3().to_array(),
        width: settings.size.x,
        right_step: (view.right / half_pixels.x).as_vec3().to_array(),
        height: settings.size.y,
        up_step: (view.up / half_pixels.y).as_vec3().to_array(),
        samples_per_axis: settings.samples_per_axis.max(1),
        projection: match view.projection {
            ViewProjection::Perspective => PROJECTION_PERSPECTIVE,
            ViewProjection::Orthographic => PROJECTION_ORTHOGRAPHIC,
        },
        ..Default::default()
    }
}

fn material_row(material: &Material) -> MaterialRow {
    let mut flags = 0;
    let mut reflection = Vec3::ZERO;
    match material.reflection {
        Reflection::None => {}
        Reflection::Constant(weight) => {
            reflection = weight;
            if weight.max_element() > 0.0 {
                flags |= MATERIAL_MIRROR;
            }
        }
        Reflection::Fresnel => flags |= MATERIAL_FRESNEL,
    }
    if material.transmission().max_element() > 0.0 {
        flags |= MATERIAL_TRANSMITS;
    }
    MaterialRow {
        color: material.color.to_array(),
        diffuse: material.diffuse,
        reflection: reflection.to_array(),
        emission: material.emission,
        phong_strength: material.phong.map_or(0.0, |lobe| lobe.strength),
        phong_exponent: material.phong.map_or(1.0, |lobe| lobe.exponent),
        specular_strength: material.specular.map_or(0.0, |lobe| lobe.strength),
        specular_exponent: material.specular.map_or(1.0, |lobe| lobe.exponent),
        transmit: material.transmit,
        filtered: material.filter,
        ior: material.ior as f32,
        flags,
    }
}

fn light_row(light: &Light, eye: DVec3) -> LightRow {
    let mut row = LightRow {
        color: light.color.to_array(),
        fade_distance: light.fade.map_or(0.0, |fade| fade.distance as f32),
        fade_power: light.fade.map_or(0.0, |fade| fade.power as f32),
        ..Default::default()
    };
    match light.kind {
        LightKind::Point { position } => {
            row.kind = LIGHT_POINT;
            row.position = (position - eye).as_vec3().to_array();
        }
        LightKind::Directional { to_light } => {
            row.kind = LIGHT_DIRECTIONAL;
            row.position = to_light.as_vec3().to_array();
        }
        LightKind::Spot {
            position,
            axis,
            cos_inner,
            cos_outer,
        } => {
            row.kind = LIGHT_SPOT;
            row.position = (position - eye).as_vec3().to_array();
            row.axis = axis.as_vec3().to_array();
            row.cos_inner = cos_inner as f32;
            row.cos_outer = cos_outer as f32;
        }
    }
    row
}
