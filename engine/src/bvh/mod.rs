//! Trees.

mod node;
pub use node::{CHILD_LEAF, CHILD_NONE, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, Node4};
