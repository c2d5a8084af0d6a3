//! A mesh as rows: its vertices, its triangles in the order of its tree's leaves, and the tree.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::arena::Arena;
use super::deform::{Adjacency, deform_positions, vertex_normals};
use super::lanes::Lanes;
use super::reach::Reach;
use crate::bvh::{Bounds, Extent, Node4, Tree};
use crate::frame::wire::{LOOK_UNPLACED, NONE, ROOT_OF_SPHERES, TriangleRow, VertexRow};
use crate::geom::Aabb;
use crate::world::{Deformation, MeshData, MeshRow, Structure};

/// A refitted tree that costs more than so many times what it did when new is replaced.
const MOST_WEAR: f32 = 1.6;

/// Costs that may still come from a device after a tree was replaced, and the new one's first.
const REPORTS_UNDER_WAY: u32 = 5;

/// What a device's copy of a mesh lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stale {
    /// Nothing.
    #[default]
    Nothing,
    /// Vertices and boxes, and the positions that its triangles copy.
    Deformed,
    /// Everything.
    All,
}

/// Where a device keeps a mesh, in rows of the three long buffers.
#[derive(Clone, Debug, Default)]
pub struct Place {
    /// Nodes of the tree, root first.
    pub nodes: Range<u32>,
    /// Triangles.
    pub triangles: Range<u32>,
    /// Positions, then normals of smooth meshes, then looks.
    pub vertices: Range<u32>,
}

/// The three long buffers that all meshes share, nodes with the tree over instances.
#[derive(Clone, Debug, Default)]
pub struct Arenas {
    /// Nodes.
    pub nodes: Arena,
    /// Triangles.
    pub triangles: Arena,
    /// Vertices.
    pub vertices: Arena,
}

impl Arenas {
    fn take(&mut self, mesh: &PackedMesh) -> Place {
        Place {
            nodes: self.nodes.take(mesh.tree.nodes.len() as u32),
            triangles: self.triangles.take(mesh.triangles.len() as u32),
            vertices: self.vertices.take(mesh.vertices.len() as u32),
        }
    }

    /// Frees a mesh's place.
    pub fn free(&mut self, place: Place) {
        self.nodes.free(place.nodes);
        self.triangles.free(place.triangles);
        self.vertices.free(place.vertices);
    }
}

/// See the module.
#[derive(Default)]
pub struct PackedMesh {
    /// What it was packed from.
    pub source: MeshRow,
    tree: Tree,
    /// The tree and its triangles once more, for tracers on the processor: see [`PackedMesh::bring_lanes`].
    pub lanes: Lanes,
    /// [`Tree::stack_need`] of it.
    pub stack_need: u32,
    /// In the order of the tree's leaves.
    pub triangles: Vec<TriangleRow>,
    /// Positions, then normals of smooth meshes, then texture coordinates with alpha, then colours.
    pub vertices: Vec<VertexRow>,
    /// Around all vertices that a triangle uses.
    pub bounds: Aabb,
    /// Where a device keeps it.
    pub place: Place,
    /// What a device lacks of it.
    pub stale: Stale,
    /// What a ray is expected to visit in the tree, as it is and when it was new; see [`Tree::cost`].
    cost: f32,
    fresh_cost: f32,
    /// Costs still to come from a device that are of the tree before, but for the last.
    stale_reports: u32,
    /// Deformed vertices, before they are rows.
    scratch: Vec<Vec3>,
    /// Of smooth meshes that were ever deformed.
    adjacency: Option<Adjacency>,
    /// How far a deformation takes it.
    reach: Reach,
    /// Deformations are a device's work where it can do it.
    on_device: bool,
}

impl PackedMesh {
    /// Builds the tree, of the deformed mesh, unless one at rest is there; the place is to be taken. Deformations from
    /// then on are left to a device if `on_device`.
    pub fn build(source: &MeshRow, on_device: bool) -> Self {
        let data: &MeshData = &source.data;
        let mut mesh = Self {
            source: source.clone(),
            ..Self::default()
        };
        mesh.fill_vertices();
        let corner = |i: u32| Vec3::from(mesh.vertices[i as usize].vector);
        let boxes: Vec<Aabb> = data
            .triangles
            .iter()
            .map(|t| Aabb::of(t.map(corner)))
            .collect();
        mesh.tree = match (source.structure, &data.tree) {
            (Structure::Boxes4, Some(built)) if source.deformation.is_none() => {
                built.as_ref().clone()
            }
            (Structure::Boxes4, _) => Tree::build(&boxes),
            (Structure::Boxes2, _) => Tree::build_binary(&boxes),
            (Structure::Spheres { leaf }, _) => Tree::build_spheres(&boxes, leaf),
            (Structure::None, _) => Tree::unculled(boxes.len() as u32),
        };
        let triangle = |&prim: &u32| TriangleRow {
            corners: data.triangles[prim as usize],
            prim,
        };
        mesh.triangles = mesh.tree.prims.iter().map(triangle).collect();
        mesh.bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        mesh.fresh_cost = mesh.tree.cost();
        mesh.stack_need = mesh.tree.stack_need();
        mesh.stale = Stale::All;
        mesh.on_device = on_device;
        mesh.reach_out();
        mesh
    }

    /// Whether a row of the frame is what this was packed from, but for how it is deformed.
    pub fn is_of(&self, row: &MeshRow) -> bool {
        Arc::ptr_eq(&self.source.data, &row.data) && self.source.structure == row.structure
    }

    /// Deforms the vertices as a row of the frame says and refits the tree; whether that was another way.
    /// Where it is left to a device, vertices and boxes here stay as they were, and only a box around all
    /// that may come of it is found.
    pub fn deform(&mut self, row: &MeshRow) -> bool {
        if self.source.deformation == row.deformation {
            return false;
        }
        self.source.deformation.clone_from(&row.deformation);
        self.stale = self.stale.max(Stale::Deformed);
        if self.reach_out() {
            return true;
        }
        self.fill_vertices();
        self.refit();
        true
    }

    /// Whether a device computes vertices and boxes as they are now: not at rest, and of trees of boxes.
    pub fn is_left_to_device(&self) -> bool {
        let has_boxes = matches!(self.source.structure, Structure::Boxes2 | Structure::Boxes4);
        self.on_device && has_boxes && self.source.deformation.is_some()
    }

    /// Bounds the deformed mesh without its vertices if they are left to a device; whether they are.
    fn reach_out(&mut self) -> bool {
        if !self.is_left_to_device() {
            return false;
        }
        let Some(deformation) = &self.source.deformation else {
            return false;
        };
        self.bounds = self.reach.bounds(&self.source.data, deformation);
        true
    }

    /// Fits every box to the vertices.
    fn refit(&mut self) {
        let (vertices, triangles) = (&self.vertices, &self.triangles);
        let corner = |i: u32| Vec3A::from_array(vertices[i as usize].vector);
        let triangle_box =
            |triangle: &TriangleRow| Extent::of_triangle(triangle.corners.map(corner));
        self.cost = self.tree.refit(|place| triangle_box(&triangles[place]));
        self.bounds = match self.tree.bounds {
            Bounds::Boxes => self.tree.around(),
            Bounds::Spheres | Bounds::Unbounded => {
                let boxes = triangles.iter().map(triangle_box);
                boxes.fold(Extent::EMPTY, Extent::union).into()
            }
        };
    }

    /// Whether the deformed tree has become so bad that a new one should be built off the frame.
    pub fn is_worn(&self) -> bool {
        self.source.structure == Structure::Boxes4 && self.cost > MOST_WEAR * self.fresh_cost
    }

    /// What a new tree would save each ray that meets the mesh.
    pub fn benefit(&self) -> f64 {
        f64::from(self.cost - self.fresh_cost)
    }

    /// Finds the boxes of the triangles as they are deformed now, by their number, on whatever thread.
    pub fn boxes_elsewhere(&self) -> impl FnOnce() -> Vec<Aabb> + Send + 'static {
        let row = self.source.clone();
        move || {
            let mut positions = Vec::new();
            let rest = Deformation::default();
            let deformation = row.deformation.as_deref().unwrap_or(&rest);
            deform_positions(&row.data, deformation, &mut positions);
            let corner = |i: u32| positions[i as usize];
            let triangles = row.data.triangles.iter();
            triangles.map(|t| Aabb::of(t.map(corner))).collect()
        }
    }

    /// What a device found the tree's cost to be.
    pub fn note_cost(&mut self, cost: f32) {
        if self.is_left_to_device() {
            self.cost = cost;
            if self.stale_reports > 0 {
                self.stale_reports -= 1;
                self.fresh_cost = cost;
            }
        }
    }

    /// Takes over a tree that was built for earlier boxes of the same triangles; its place is to be taken.
    pub fn adopt(&mut self, tree: Tree) {
        self.stack_need = tree.stack_need();
        self.tree = tree;
        let data = &self.source.data;
        let triangle = |&prim: &u32| TriangleRow {
            corners: data.triangles[prim as usize],
            prim,
        };
        self.triangles = self.tree.prims.iter().map(triangle).collect();
        if self.is_left_to_device() {
            self.stale_reports = REPORTS_UNDER_WAY;
            self.cost = self.fresh_cost;
        } else {
            self.fresh_cost = self.tree.cost();
            self.refit();
        }
    }

    /// Positions and normals, deformed or at rest.
    fn fill_vertices(&mut self) {
        let data = &self.source.data;
        let row = |v: &Vec3| VertexRow {
            vector: v.to_array(),
            further: 0,
        };
        let Some(deformation) = &self.source.deformation else {
            let vectors = data.positions.iter().chain(&data.normals);
            self.vertices.clear();
            self.vertices.extend(vectors.map(row));
            add_looks(data, &mut self.vertices);
            return;
        };
        deform_positions(data, deformation, &mut self.scratch);
        self.vertices.clear();
        self.vertices.extend(self.scratch.iter().map(row));
        if !data.normals.is_empty() {
            let adjacency = self.adjacency.get_or_insert_with(|| Adjacency::of(data));
            let mut normals = Vec::new();
            vertex_normals(data, adjacency, &self.scratch, &mut normals);
            self.vertices.extend(normals.iter().map(row));
        }
        add_looks(data, &mut self.vertices);
    }

    /// Takes the place of `old` in the arenas.
    pub fn settle_in(&mut self, arenas: &mut Arenas, old: Place) {
        arenas.free(old);
        self.place = arenas.take(self);
        self.stale = Stale::All;
    }

    /// Brings [`PackedMesh::lanes`] up to the mesh: the copy of a tracer on the processor. Trees of other kinds have none.
    pub fn bring_lanes(&mut self) {
        let stale = std::mem::take(&mut self.stale);
        let (nodes, triangles, vertices) = (&self.tree.nodes, &self.triangles, &self.vertices);
        if self.source.structure != Structure::Boxes4 {
            self.lanes = Lanes::default();
        } else if stale == Stale::All {
            self.lanes = Lanes::build(nodes, triangles, vertices);
        } else if stale == Stale::Deformed {
            self.lanes.refresh(nodes, triangles, vertices);
        }
    }

    /// The tree as rays meet it: what is left to a device is computed here again.
    pub fn tree_as_traced(&self) -> Cow<'_, Tree> {
        if !self.is_left_to_device() {
            return Cow::Borrowed(&self.tree);
        }
        let boxes = self.boxes_elsewhere()();
        let mut tree = self.tree.clone();
        tree.refit(|place| boxes[self.tree.prims[place] as usize].into());
        Cow::Owned(tree)
    }

    /// Levels of the tree's nodes; see [`Tree::levels`].
    pub fn levels(&self) -> &[u32] {
        &self.tree.levels
    }

    /// Nodes of the tree, root first; none: nothing to hit.
    #[inline]
    pub fn nodes(&self) -> &[Node4] {
        &self.tree.nodes
    }

    /// [`PackedMesh::nodes`], for tests that spoil them.
    #[cfg(test)]
    pub fn nodes_mut(&mut self) -> &mut [Node4] {
        &mut self.tree.nodes
    }

    /// What marks the root of a tree of spheres.
    pub fn root_flag(&self) -> u32 {
        match self.tree.bounds {
            Bounds::Spheres => ROOT_OF_SPHERES,
            Bounds::Boxes | Bounds::Unbounded => 0,
        }
    }

    /// First row of the normals; [`NONE`]: flat.
    pub fn first_normal(&self) -> u32 {
        if self.source.data.normals.is_empty() {
            NONE
        } else {
            self.place.vertices.start + self.source.data.positions.len() as u32
        }
    }

    /// First of the rows of looks, behind positions and normals.
    pub fn looks_start(&self) -> usize {
        self.source.data.positions.len() + self.source.data.normals.len()
    }

    /// First row of its looks; [`NONE`]: it has none.
    pub fn first_look(&self) -> u32 {
        if has_looks(&self.source.data) {
            self.place.vertices.start + self.looks_start() as u32
        } else {
            NONE
        }
    }

    /// Positions of a triangle's corners.
    #[inline]
    pub fn corners(&self, triangle: &TriangleRow) -> [Vec3; 3] {
        let [a, b, c] = triangle.corners;
        let at = |i: u32| Vec3::from(self.vertices[i as usize].vector);
        [at(a), at(b), at(c)]
    }

    /// Normals at a triangle's corners; none: it is flat.
    #[inline]
    pub fn corner_normals(&self, triangle: &TriangleRow) -> Option<[Vec3; 3]> {
        let data = &self.source.data;
        let end = data.positions.len() + data.normals.len();
        let normals = self.vertices.get(data.positions.len()..end)?;
        let at = |i: u32| normals.get(i as usize).map(|row| Vec3::from(row.vector));
        let [a, b, c] = triangle.corners;
        Some([at(a)?, at(b)?, at(c)?])
    }
}

fn has_looks(data: &MeshData) -> bool {
    !data.uvs.is_empty() || !data.colors.is_empty()
}

/// Texture coordinates with alpha, and behind them the colours if there are any.
fn add_looks(data: &MeshData, rows: &mut Vec<VertexRow>) {
    if !has_looks(data) {
        return;
    }
    let count = data.positions.len();
    let unplaced = if data.uvs.is_empty() {
        LOOK_UNPLACED
    } else {
        0
    };
    let to_color = if data.colors.is_empty() { 0 } else { count };
    rows.extend((0..count).map(|i| {
        let uv = data.uvs.get(i).copied().unwrap_or_default();
        let alpha = data.colors.get(i).map_or(1.0, |color| color.w);
        VertexRow {
            vector: [uv.x, uv.y, alpha],
            further: to_color as u32 | unplaced,
        }
    }));
    rows.extend(data.colors.iter().map(|color| VertexRow {
        vector: color.truncate().to_array(),
        further: 0,
    }));
}
