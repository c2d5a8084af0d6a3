//! Triangle meshes, recentred for f32 tracers, and the store that owns them.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::{DVec3, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::{Deformation, Structure, Table};
use crate::bvh::Tree;
use crate::geom::Aabb;

/// Largest coordinate that has a place in a picture: its square still fits f32 (Embree draws the line there
/// too). What lies beyond is reported and left out.
pub const FARTHEST: f64 = 1e18;

/// Largest texture coordinate: f32 counts a map's texels no further, and the squares of spans between two still fit it.
const FARTHEST_UV: f32 = 1_048_576.0;

/// Row of [`Meshes`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[reflect(Clone, PartialEq)]
pub struct MeshId(pub u32);

/// One indexed triangle mesh in its own space. Immutable: a change makes a new one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MeshData {
    /// What people call it (file and group).
    pub name: String,
    /// Where the mesh came from, as the scene file wrote it; empty for polygons.
    pub path: String,
    /// Subtracted in f64 before rounding to f32: near the centre of the bounds, on a coarse grid.
    pub origin: DVec3,
    /// Length of the diagonal of the bounds.
    pub extent: f64,
    /// Vertices as given.
    #[serde(with = "crate::pod::array")]
    pub vertices: Vec<DVec3>,
    /// Vertices minus `origin`, rounded: what f32 tracers read.
    #[serde(with = "crate::pod::array")]
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex for smooth shading; empty: flat.
    #[serde(with = "crate::pod::array")]
    pub normals: Vec<Vec3>,
    /// Its triangles stand for a curved surface that the normals tell of: shadows are cast from there, not from the flat
    /// triangles, which would shade themselves where light comes grazing. Means nothing without normals.
    pub curved: bool,
    /// Texture coordinates, one a vertex, finite; empty: none.
    #[serde(with = "crate::pod::array")]
    pub uvs: Vec<Vec2>,
    /// Linear red, green and blue, and alpha, one a vertex, all from 0 to 1; empty: white.
    #[serde(with = "crate::pod::array")]
    pub colors: Vec<Vec4>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    #[serde(with = "crate::pod::array")]
    pub triangles: Vec<[u32; 3]>,
    /// Over the boxes of the triangles; none: whoever traces it builds one.
    #[serde(with = "crate::pod::maybe_shared")]
    pub tree: Option<Arc<Tree>>,
}

impl MeshData {
    /// A mesh from f64 vertices; `normals` is empty (flat) or one a vertex.
    ///
    /// # Errors
    /// A sentence that names the first index out of range, non-finite vertex, or a wrong count of normals.
    pub fn new(
        name: impl Into<String>,
        vertices: Vec<DVec3>,
        normals: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, String> {
        let within = |v: &DVec3| v.is_finite() && v.abs().max_element() <= FARTHEST;
        if let Some(i) = vertices.iter().position(|v| !within(v)) {
            let vertex = vertices[i];
            return Err(format!(
                "vertex {i} is not finite or farther out than {FARTHEST:e}: {vertex}"
            ));
        }
        if !normals.is_empty() && normals.len() != vertices.len() {
            return Err(format!(
                "{} normals for {} vertices",
                normals.len(),
                vertices.len()
            ));
        }
        let count = vertices.len();
        for (i, triangle) in triangles.iter().enumerate() {
            if let Some(corner) = triangle.iter().find(|&&c| c as usize >= count) {
                return Err(format!(
                    "triangle {i} names vertex {corner}, but there are {count}"
                ));
            }
        }
        let (min, max) = vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &v| {
                (min.min(v), max.max(v))
            });
        let (origin, extent) = if vertices.is_empty() {
            (DVec3::ZERO, 0.0)
        } else {
            let extent = (max - min).length();
            (on_grid((min + max) * 0.5, extent), extent)
        };
        let positions = vertices.iter().map(|&v| (v - origin).as_vec3()).collect();
        Ok(Self {
            name: name.into(),
            path: String::new(),
            origin,
            extent,
            vertices,
            positions,
            normals,
            curved: false,
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles,
            tree: None,
        })
    }

    /// The box of each triangle at rest, as f32 tracers see it.
    pub fn boxes(&self) -> Vec<Aabb> {
        let corner = |i: u32| self.positions[i as usize];
        let triangles = self.triangles.iter();
        triangles.map(|t| Aabb::of(t.map(corner))).collect()
    }

    /// The mesh with texture coordinates and colours of its vertices; each is empty or one a vertex. Colours are brought
    /// to 0 to 1, so that no surface gives off more light than its material says.
    ///
    /// # Errors
    /// A sentence that names the first number that is not finite or too large, or a wrong count.
    pub fn with_looks(mut self, uvs: Vec<Vec2>, colors: Vec<Vec4>) -> Result<Self, String> {
        let count = self.vertices.len();
        for (what, found) in [
            ("texture coordinates", uvs.len()),
            ("colours", colors.len()),
        ] {
            if found != 0 && found != count {
                return Err(format!("{found} {what} for {count} vertices"));
            }
        }
        if let Some(i) = uvs
            .iter()
            .position(|uv| !(uv.abs().max_element() <= FARTHEST_UV))
        {
            return Err(format!(
                "texture coordinate {i} is not finite or beyond {FARTHEST_UV:e}: {}",
                uvs[i]
            ));
        }
        if let Some(i) = colors.iter().position(|color| !color.is_finite()) {
            return Err(format!("colour {i} is not finite: {}", colors[i]));
        }
        self.uvs = uvs;
        self.colors = colors;
        for color in &mut self.colors {
            *color = color.clamp(Vec4::ZERO, Vec4::ONE);
        }
        Ok(self)
    }
}

/// The point of a grid of a 64th of the extent, a power of two, that is nearest: few digits, so that subtracting it
/// leaves vertices that are f32 exact, and moves along with a mesh that is moved by whole steps of the grid.
fn on_grid(center: DVec3, extent: f64) -> DVec3 {
    let step = (extent.log2().floor() - 6.0).exp2();
    if step.is_normal() {
        (center / step + 0.5).floor() * step
    } else {
        center
    }
}

/// A mesh as tracers see it.
#[derive(Clone, Debug, Default)]
pub struct MeshRow {
    /// Triangles, and vertices at rest.
    pub data: Arc<MeshData>,
    /// What is done to the vertices.
    pub deformation: Option<Arc<Deformation>>,
    /// What it is traced with.
    pub structure: Structure,
}

impl From<MeshData> for MeshRow {
    fn from(data: MeshData) -> Self {
        Self {
            data: Arc::new(data),
            ..Self::default()
        }
    }
}

/// All meshes of the world. Rows are stable; a replaced row holds a new `Arc`.
#[derive(Resource, Default, Debug)]
pub struct Meshes {
    rows: Table<MeshRow>,
    vacant: Vec<MeshId>,
}

impl Meshes {
    /// Adds a mesh, in the row of a removed one if there is one.
    pub fn add(&mut self, mesh: impl Into<MeshRow>) -> MeshId {
        match self.vacant.pop() {
            Some(id) => {
                self.replace(id, mesh);
                id
            }
            None => MeshId(self.rows.push(mesh.into())),
        }
    }

    /// Puts another mesh into a row.
    pub fn replace(&mut self, id: MeshId, mesh: impl Into<MeshRow>) {
        self.rows.replace(id.0, mesh.into());
    }

    /// Frees a mesh that no entity shows any more; its row is empty until another mesh takes it.
    pub fn remove(&mut self, id: MeshId) {
        self.replace(id, MeshData::default());
        self.vacant.push(id);
    }

    /// The mesh of a row, at rest.
    pub fn get(&self, id: MeshId) -> Option<&Arc<MeshData>> {
        self.rows.get(id.0 as usize).map(|row| &row.data)
    }

    /// All rows in order of id, and what changed.
    pub fn rows(&self) -> &Table<MeshRow> {
        &self.rows
    }
}
