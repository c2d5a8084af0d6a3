//! What is done to the vertices of a mesh, as plain data that each tracer evaluates.
//!
//! [`Deformation`] is derived from the components that people write and travels with the mesh's row; the
//! f32 tracers evaluate it relative to [`super::MeshData::origin`], the reference in f64. A vertex goes
//! through the steps in order; normals of smooth meshes follow from the deformed triangles.

mod exact;
mod poses;
mod procedural;
mod skin;

pub use exact::deformed_vertices;
pub use poses::{KeyFrames, Morph};
pub use procedural::{Twist, Wave};
pub use skin::Skin;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Steps that a mesh's vertices go through, in order, in the mesh's own space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformation {
    /// First to last.
    pub steps: Vec<DeformStep>,
}

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub enum DeformStep {
    /// The vertex becomes `(1 - share) * keys[from] + share * keys[to]`.
    Keys {
        /// Whole poses of the mesh.
        keys: Arc<VertexSets>,
        /// Pose at share 0.
        from: u32,
        /// Pose at share 1.
        to: u32,
        /// Between the two.
        share: f64,
    },
    /// Adds `weights[i] * targets[i]`.
    Morph {
        /// Offsets of every vertex, a set a target.
        targets: Arc<VertexSets>,
        /// One a target.
        weights: Vec<f64>,
    },
    /// Becomes the weighted sum of `joints[j] * p` over the vertex's joints (linear blend skinning).
    Skin {
        /// Which joints hold which vertex.
        binding: Arc<SkinBinding>,
        /// Mesh space from bind-pose mesh space, one a joint.
        joints: Vec<DAffine3>,
    },
    /// Adds `amplitude * sin(wave . p - phase)`.
    Wave {
        /// Radians per unit along each axis.
        wave: DVec3,
        /// Displacement at a crest.
        amplitude: DVec3,
        /// Radians.
        phase: f64,
    },
    /// Turns about the line through `origin` along `axis` by `rate * ((p - origin) . axis) + offset`.
    Twist {
        /// A point of the axis.
        origin: DVec3,
        /// Unit length.
        axis: DVec3,
        /// Radians per unit along the axis.
        rate: f64,
        /// Radians everywhere.
        offset: f64,
    },
}

/// Sets of one vector a vertex. Compared by identity: two sets of equal numbers are different sets.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct VertexSets {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Poses relative to the mesh's origin, or offsets; set by set.
    #[serde(with = "crate::pod::array")]
    pub values: Vec<Vec3>,
}

impl VertexSets {
    /// The vectors of one set.
    pub fn set(&self, index: u32) -> &[Vec3] {
        let start = index as usize * self.vertices;
        &self.values[start..start + self.vertices]
    }

    /// The vectors of these vertices, in each set.
    pub fn gathered(&self, vertices: &[u32]) -> Self {
        let sets = (0..self.count()).map(|set| self.set(set));
        Self {
            vertices: vertices.len(),
            values: sets
                .flat_map(|set| vertices.iter().map(|&vertex| set[vertex as usize]))
                .collect(),
        }
    }

    /// How many sets there are.
    pub fn count(&self) -> u32 {
        (self.values.len() / self.vertices.max(1)) as u32
    }
}

impl PartialEq for VertexSets {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

/// Joints and weights of every vertex. Compared by identity.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SkinBinding {
    /// Joints of each vertex; unused places have weight 0.
    #[serde(with = "crate::pod::array")]
    pub joints: Vec<[u32; 4]>,
    /// Sum to 1.
    #[serde(with = "crate::pod::array")]
    pub weights: Vec<[f32; 4]>,
    highest_joint: u32,
}

impl SkinBinding {
    /// A binding of as many vertices as there are joints and weights; weights are made to sum to 1.
    ///
    /// # Errors
    /// A sentence that names the first vertex whose weights are negative, not finite or all 0, or says that
    /// the counts differ.
    pub fn new(joints: Vec<[u32; 4]>, mut weights: Vec<[f32; 4]>) -> Result<Self, String> {
        if joints.len() != weights.len() {
            return Err(format!(
                "joints of {} vertices, weights of {}",
                joints.len(),
                weights.len()
            ));
        }
        for (vertex, row) in weights.iter_mut().enumerate() {
            let sum: f64 = row.iter().map(|&weight| f64::from(weight)).sum();
            let valid = row.iter().all(|&weight| weight >= 0.0) && sum > 0.0 && sum.is_finite();
            if !valid {
                return Err(format!("the weights of vertex {vertex} are {row:?}"));
            }
            *row = row.map(|weight| (f64::from(weight) / sum) as f32);
        }
        let highest_joint = joints.iter().flatten().copied().max().unwrap_or(0);
        Ok(Self {
            joints,
            weights,
            highest_joint,
        })
    }

    /// The binding of these vertices.
    pub fn gathered(&self, vertices: &[u32]) -> Self {
        let vertex = |&vertex: &u32| vertex as usize;
        let rows = || vertices.iter().map(vertex);
        Self {
            joints: rows().map(|vertex| self.joints[vertex]).collect(),
            weights: rows().map(|vertex| self.weights[vertex]).collect(),
            highest_joint: self.highest_joint,
        }
    }

    /// The highest number of a joint that a vertex names.
    pub fn highest_joint(&self) -> u32 {
        self.highest_joint
    }
}

impl PartialEq for SkinBinding {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}
