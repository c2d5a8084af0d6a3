//! Bounding-volume hierarchies: one tree per mesh in its own space, one over the instances.
//!
//! This continues the report's part on bounding-volume hierarchies (Allgyer 2008, "Real-time Ray Tracing
//! using CUDA"), which kept one binary tree of spheres per mesh, over objects that stood still, and tested
//! meshes one after the other. Here a tree is 4-wide with boxes ([`Node4`]), and it follows what moves:
//!
//! - [`Tree`] is a mesh's: built once from the top down by the surface area heuristic, refitted when vertices
//!   move ([`Tree::refit`]), built anew off the frame when that has made it bad ([`Rebuilder`]).
//! - [`InstanceTree`] is a frame's: paths, refits and new trees, whichever is cheapest by measured cost.
//! - [`Bounds`] names the structures to compare with, the report's own among them.
//!
//! Boxes are grown outward around the very values that intersectors read, so that together with the slab
//! rule of [`crate::geom::SlabRay`], or that of `shaders/shared/slab.wgsl`, no hit is ever culled. So no picture depends
//! on a tree or its history.

mod binary;
mod build;
mod cluster;
mod collapse;
mod extent;
mod fast;
mod instances;
mod morton;
mod node;
mod paths;
mod rebuild;
mod refit;
mod structures;
mod tree;

pub use extent::Extent;
pub use instances::{InstanceTree, TreeAction, TreeWork};
pub use node::{CHILD_LEAF, CHILD_NONE, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, Node4};
pub use rebuild::{Rebuilder, Rebuilt};
pub use structures::Bounds;
pub use tree::{Child, Tree};

/// Nodes a traversal can hold over both levels of trees; each tree is built to need at most half. Good trees over millions of
/// triangles need more than 48 each; who pays for room takes what the trees at hand need.
pub const TRAVERSAL_CAPACITY: u32 = 192;
