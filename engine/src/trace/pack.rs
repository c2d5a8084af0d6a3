//! FrameScene to the rows that both f32 tracers read.
//!
//! Here f64 becomes f32: positions relative to the eye are subtracted in f64 first, so a scene far from
//! the origin packs to the same bits as the same scene near it.

mod deform;
mod instance;
mod rows;

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use self::deform::{Adjacency, deform_positions, vertex_normals};
use self::instance::instance_row;
use self::rows::{light_row, material_row, view_row};
use crate::bvh::{Child, Node4, Tree};
use crate::frame::wire::{
    GENERATIONS_CAPACITY, InstanceRow, LightRow, MATERIAL_TRANSMITS, MaterialRow, NONE, NormalRow,
    TriangleRow, ViewRow,
};
use crate::frame::{FrameScene, Shape, TraceSettings};
use crate::geom::Aabb;
use crate::world::{Deformation, MeshData, MeshRow};

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
    /// Boxes and number of planes that the instance tree was built for.
    instance_tree_of: (Vec<Aabb>, u32),
}

/// A mesh's tree and where its rows are.
struct PackedMesh {
    source: Arc<MeshData>,
    deformation: Option<Arc<Deformation>>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tree: Tree,
    bounds: Aabb,
    root: u32,
    first_triangle: u32,
}

impl PackedScene {
    /// Builds the trees of meshes that are new or changed and lays all meshes out again if any was.
    pub fn refit(&mut self, scene: &FrameScene) {
        self.trees_updated = 0;
        let fresh: Vec<(usize, &MeshRow)> = scene
            .meshes
            .iter()
            .enumerate()
            .filter(|(i, row)| {
                self.meshes.get(*i).is_none_or(|packed| {
                    !Arc::ptr_eq(&packed.source, &row.data) || packed.deformation != row.deformation
                })
            })
            .collect();
        if fresh.is_empty() && self.meshes.len() == scene.meshes.len() {
            return;
        }
        let built: Vec<(usize, PackedMesh)> = fresh
            .into_par_iter()
            .map(|(i, row)| (i, PackedMesh::build(row)))
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
                let [a, b, c] = corners.map(|i| mesh.positions[i as usize].to_array());
                let mut normals = NONE;
                if !mesh.normals.is_empty() {
                    normals = self.normals.len() as u32;
                    self.normals.extend(corners.map(|i| NormalRow {
                        normal: mesh.normals[i as usize].to_array(),
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
                let mesh = |mesh: u32| &self.meshes[mesh as usize];
                if let Some((mut row, bounds)) = instance_row(instance, scene.view.origin, mesh) {
                    row.id = id as u32;
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
            .any(|row| self.materials[row.material as usize].flags & MATERIAL_TRANSMITS != 0);
        let plane_count = (self.instances.len() - boxes.len()) as u32;
        let root = self.build_instance_tree(boxes, plane_count);
        self.view = view_row(&scene.view, settings);
        self.view.background = scene.background.to_array();
        self.view.max_generations = scene.max_generations.min(GENERATIONS_CAPACITY);
        self.view.plane_count = plane_count;
        self.view.light_count = self.lights.len() as u32;
        self.view.root = root;
    }

    /// Builds the tree over instances behind the meshes' nodes, unless every box is where it was; its root.
    fn build_instance_tree(&mut self, boxes: Vec<Aabb>, plane_count: u32) -> u32 {
        let start = self.instance_nodes_start as usize;
        let key = (boxes, plane_count);
        // New meshes have taken the old tree's nodes away.
        let is_there = self.nodes.len() > start || key.0.is_empty();
        if !is_there || key != self.instance_tree_of {
            let mut tree = Tree::build_fast(&key.0);
            resolve_leaves(&mut tree, plane_count);
            self.nodes.truncate(start);
            self.nodes.extend_from_slice(&tree.nodes);
            self.trees_updated += 1;
            self.instance_tree_of = key;
        }
        if self.nodes.len() > start {
            self.instance_nodes_start
        } else {
            NONE
        }
    }
}

impl PackedMesh {
    fn build(row: &MeshRow) -> Self {
        let source = Arc::clone(&row.data);
        let (mut positions, mut normals) = (source.positions.clone(), source.normals.clone());
        if let Some(deformation) = &row.deformation {
            deform_positions(&source, deformation, &mut positions);
            if !normals.is_empty() {
                vertex_normals(&source, &Adjacency::of(&source), &positions, &mut normals);
            }
        }
        let corner = |i: u32| positions[i as usize];
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
            deformation: row.deformation.clone(),
            positions,
            normals,
            source,
        }
    }
}

/// Puts instance rows straight into the leaves, which hold one each: saves a look-up a leaf.
fn resolve_leaves(tree: &mut Tree, plane_count: u32) {
    for slot in tree.nodes.iter_mut().flat_map(|n| &mut n.children) {
        if let Child::Leaf { first, count } = Child::decode(*slot) {
            let row = tree.prims[first as usize] + plane_count;
            *slot = Child::Leaf { first: row, count }.encode();
        }
    }
}
