//! The node of every tree: four children's boxes in full precision, 112 bytes, seven 16-byte rows.
//!
//! The same bytes serve the CPU (four lanes a row) and the GPU. Full-precision 4-wide nodes beat
//! compressed 8-wide ones on coherent rays there, measured.

use bytemuck::{Pod, Zeroable};

/// [`Node4::children`]: no child; its box is inverted, so no ray enters it.
pub const CHILD_NONE: u32 = u32::MAX;
/// [`Node4::children`]: set on a leaf.
pub const CHILD_LEAF: u32 = 1 << 31;
/// A leaf's count minus one is in these three bits.
pub const LEAF_COUNT_SHIFT: u32 = 28;
/// A leaf's first primitive is in the bits below [`LEAF_COUNT_SHIFT`].
pub const LEAF_FIRST_MASK: u32 = (1 << LEAF_COUNT_SHIFT) - 1;

/// Four boxes and what is in them.
///
/// A child is [`CHILD_NONE`]; or a leaf: [`CHILD_LEAF`] | (count - 1) << [`LEAF_COUNT_SHIFT`] | first;
/// or the index of a node, counted from the root of its tree.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node4 {
    /// Least x of each child's box.
    pub min_x: [f32; 4],
    /// Least y.
    pub min_y: [f32; 4],
    /// Least z.
    pub min_z: [f32; 4],
    /// Greatest x.
    pub max_x: [f32; 4],
    /// Greatest y.
    pub max_y: [f32; 4],
    /// Greatest z.
    pub max_z: [f32; 4],
    /// What is in each box.
    pub children: [u32; 4],
}

impl Node4 {
    /// A node without children.
    pub const EMPTY: Self = Self {
        min_x: [f32::MAX; 4],
        min_y: [f32::MAX; 4],
        min_z: [f32::MAX; 4],
        max_x: [f32::MIN; 4],
        max_y: [f32::MIN; 4],
        max_z: [f32::MIN; 4],
        children: [CHILD_NONE; 4],
    };
}
