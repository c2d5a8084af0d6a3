//! Which acceleration structure a mesh is traced with.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;

/// The structure over a mesh's triangles. What is hit never depends on it, only how long that takes.
///
/// The default is what the engine traces fastest; the others are there to compare with and to look at. An
/// entity that carries this component has a tree of its own.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub enum Structure {
    /// A tree of boxes, four children a node.
    #[default]
    Boxes4,
    /// A tree of boxes, two children a node.
    Boxes2,
    /// The tree of the 2008 report: bounding spheres over the diagonal of the box, two children a node,
    /// triangles split evenly, at most `leaf` of them in a leaf.
    Spheres {
        /// 1 to 8.
        leaf: u32,
    },
    /// No tree: every ray meets every triangle.
    None,
}
