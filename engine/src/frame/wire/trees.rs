//! Rows of the passes that deform meshes and keep trees on the device.

use bytemuck::{Pod, Zeroable};

/// [`StepRow::kind`]: between two poses.
pub const STEP_KEYS: u32 = 0;
/// [`StepRow::kind`]: weighted offsets.
pub const STEP_MORPH: u32 = 1;
/// [`StepRow::kind`]: joints.
pub const STEP_SKIN: u32 = 2;
/// [`StepRow::kind`]: a sine.
pub const STEP_WAVE: u32 = 3;
/// [`StepRow::kind`]: a turn that grows along an axis.
pub const STEP_TWIST: u32 = 4;

/// The uniform of one dispatch that works on trees.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StageRow {
    /// Meshes: first job. Instance trees: the root's place among the nodes.
    pub first: u32,
    /// Meshes: jobs. Instance trees: boxes.
    pub count: u32,
    /// Instance trees: levels above this one. Sorting: digits before this one.
    pub level: u32,
    /// Instance trees: most levels that the tree may have.
    pub levels: u32,
}

/// What one mesh has done in a dispatch for many.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct JobRow {
    /// The mesh's first workgroup; the next job's is one past its last.
    pub first_group: u32,
    /// Vertices, or nodes of the level, or numbers to add up.
    pub count: u32,
    /// First step of the deformation; first pair of corners among the data; first node of the level, from the root.
    pub first: u32,
    /// Root of the mesh's tree among the nodes.
    pub root: u32,
    /// The mesh's first triangle.
    pub first_triangle: u32,
    /// The mesh's first vertex.
    pub first_vertex: u32,
    /// Where the costs of the workgroups' nodes go.
    pub partial: u32,
    /// Positions at rest, or the ends of vertices' corners, among the data.
    pub rest: u32,
    /// Steps of the deformation.
    pub step_count: u32,
    /// The mesh's first normal, among the vertices.
    pub first_normal: u32,
    /// Room for more.
    pub spare: [u32; 2],
}

/// A step of a deformation; see [`crate::world::DeformStep`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StepRow {
    /// `STEP_*`.
    pub kind: u32,
    /// Among the data. Keys: the pose at share 0. Skin: four joints a vertex.
    pub from_set: u32,
    /// Among the data. Keys: the pose at share 1. Skin: four weights a vertex.
    pub to_set: u32,
    /// First row of the step's parameters.
    pub params: u32,
    /// Morph: targets with a weight.
    pub count: u32,
    /// Room for more.
    pub spare: [u32; 3],
}

/// A box; vacant when a `min` exceeds its `max`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BoxRow {
    /// Least corner.
    pub min: [f32; 3],
    /// Room for one more number.
    pub spare: u32,
    /// Greatest corner.
    pub max: [f32; 3],
    /// Room for one more number.
    pub spare_too: u32,
}

/// What the passes that build an instance tree tell each other. On the device the counts are atomics.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BuildRow {
    /// Greatest of the boxes' negated centres, in the order of the f32.
    pub least: [u32; 3],
    /// Boxes that are not vacant.
    pub live: u32,
    /// Greatest of the boxes' centres, in the order of the f32.
    pub greatest: [u32; 3],
    /// Room for one more number.
    pub spare: u32,
    /// Nodes of each level.
    pub level_nodes: [u32; 16],
    /// The first node of each level, from the root.
    pub level_starts: [u32; 16],
}
