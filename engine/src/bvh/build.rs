//! Boxes to tree: cut in two by area ([`super::binary`]), collapsed to up to four children a node ([`super::collapse`]).

use super::binary::{by_area, by_medians};
use super::collapse::collapse;
use super::{TRAVERSAL_CAPACITY, Tree};
use crate::geom::Aabb;

/// Nodes that one tree may ask of a traversal's stack: half of it, for there are two levels of trees.
pub(super) const STACK_SHARE: u32 = TRAVERSAL_CAPACITY / 2;

/// Most primitives in a leaf of a mesh's tree.
pub(super) const MESH_LEAF: u32 = 4;

impl Tree {
    /// A tree of good quality for what is built once and traced often; boxes must be finite.
    pub fn build(boxes: &[Aabb]) -> Self {
        Self::by_area(boxes, MESH_LEAF, 4)
    }

    /// The same with one primitive a leaf: what a tree over instances is held against.
    pub fn build_single(boxes: &[Aabb]) -> Self {
        Self::by_area(boxes, 1, 4)
    }

    /// With up to `leaf` primitives a leaf, and 2 to 4 children a node.
    pub(super) fn by_area(boxes: &[Aabb], leaf: u32, width: usize) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let (binary, prims) = by_area(boxes);
        let tree = collapse(&binary, prims, leaf, width);
        if tree.stack_need() <= STACK_SHARE {
            return tree;
        }
        // Nested boxes can make a tree as deep as that. Medians cannot: 2^28 primitives need 28 levels of 2, 84 entries.
        balanced(boxes, leaf, width)
    }
}

/// The tree by medians.
pub(super) fn balanced(boxes: &[Aabb], leaf: u32, width: usize) -> Tree {
    let (binary, prims) = by_medians(boxes, leaf);
    collapse(&binary, prims, 1, width)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::testing::boxes;

    #[test]
    fn every_tree_holds_its_invariants() {
        for count in [0, 1, 2, 3, 4, 5, 7, 8, 9, 64, 1000, 20_000] {
            for spread in [0.0, 1.0, 1e6] {
                let boxes = boxes(count, spread, 0.0, count as u32 + 1);
                for tree in [Tree::build(&boxes), Tree::build_single(&boxes)] {
                    tree.validate(&boxes).unwrap();
                    assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
                }
            }
        }
    }

    #[test]
    fn boxes_nested_like_onions_do_not_overflow_the_stack() {
        let boxes: Vec<Aabb> = (0..3000)
            .map(|i| {
                let half = Vec3::splat(1.004_f32.powi(i));
                Aabb {
                    min: -half,
                    max: half,
                }
            })
            .collect();
        let tree = Tree::build_single(&boxes);
        tree.validate(&boxes).unwrap();
        assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
        balanced(&boxes, 1, 4).validate(&boxes).unwrap();
    }

    #[test]
    fn equal_boxes_make_a_tree() {
        let boxes = vec![boxes(1, 1.0, 0.0, 5)[0]; 500];
        Tree::build(&boxes).validate(&boxes).unwrap();
    }
}
