//! Files to plain data. The only readers of foreign formats, each with its crate to itself.
//!
//! An importer returns meshes and materials, or a sentence that says what is wrong with the file; it never
//! panics and never touches the world.

mod mtl;
mod obj;
mod poses;
mod smooth;

pub use mtl::material_of;
pub use obj::import_obj;
pub use poses::import_pose;
pub use smooth::{smooth, smooth_part};

use crate::world::{Material, MeshData};

/// What a model file holds.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// One a group and material, in the file's order; none is empty.
    pub parts: Vec<Part>,
    /// The materials of the file, by name.
    pub materials: Vec<(String, Material)>,
    /// What is odd but did not stop the import: a material file that is missing, a face left out.
    pub warnings: Vec<String>,
}

/// One mesh of a [`Model`].
#[derive(Clone, Debug)]
pub struct Part {
    /// Its triangles.
    pub mesh: MeshData,
    /// Row of [`Model::materials`].
    pub material: Option<usize>,
    /// The faces as the file has them.
    pub outline: Outline,
    /// Which vertex of the outline each vertex of the mesh is.
    pub sources: Vec<u32>,
}

/// Faces without places: what all poses of a mesh have in common.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outline {
    /// Vertices of the group, numbered by first use.
    pub vertices: usize,
    /// Corners of each face.
    pub arities: Vec<u32>,
    /// Vertices at the corners, face by face.
    pub corners: Vec<u32>,
}

impl Model {
    /// Triangles of all parts.
    pub fn triangles(&self) -> usize {
        self.parts
            .iter()
            .map(|part| part.mesh.triangles.len())
            .sum()
    }
}
