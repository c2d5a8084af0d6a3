//! Boxes to tree: cut in two by area ([`super::binary`]), collapsed to up to four children a node ([`super::collapse`]).

use super::binary::{by_area, by_medians};
use super::collapse::collapse;
use super::{TRAVERSAL_CAPACITY, Tree};
use crate::geom::Aabb;

/// Nodes that one tree may ask of a traversal's stack: half of it, for there are two levels of trees.
pub(super) const STACK_SHARE: u32 = TRAVERSAL_CAPACITY / 2;

/// Most primitives in a leaf of a mesh's tree.
pub(super) const MESH_LEAF: u32 = 4;

/// Levels that are cut by area: as many as the stack has room for. Boxes that are ever larger, or ever farther apart, make long
/// paths of small parts, one after the other.
const DEPTHS: [u32; 3] = [56, 24, 3];

impl Tree {
    /// A tree of good quality for what is built once and traced often; boxes must be finite.
    pub fn build(boxes: &[Aabb]) -> Self {
        Self::of_width(boxes, MESH_LEAF, 4)
    }

    /// The same with one primitive a leaf: what a tree over instances is held against.
    pub fn build_single(boxes: &[Aabb]) -> Self {
        Self::of_width(boxes, 1, 4)
    }

    /// With up to `leaf` primitives a leaf, and 2 to 4 children a node.
    pub(super) fn of_width(boxes: &[Aabb], leaf: u32, width: usize) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        within(boxes, leaf, width, STACK_SHARE)
    }
}

/// The best tree whose traversals need no more of a stack than this.
fn within(boxes: &[Aabb], leaf: u32, width: usize, share: u32) -> Tree {
    let trees = DEPTHS.into_iter().map(|deep| {
        let (binary, prims) = by_area(boxes, deep);
        collapse(&binary, prims, leaf, width)
    });
    let mut fitting = trees.filter(|tree| tree.stack_need() <= share);
    // A level adds three at most: 28 of halves, of all primitives that a leaf can name, are within the share.
    fitting
        .next()
        .unwrap_or_else(|| balanced(boxes, leaf, width))
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
            for spread in [0.0, 1e-25, 1.0, 1e6, 1e17] {
                let boxes = boxes(count, spread, 0.0, count as u32 + 1);
                for tree in [Tree::build(&boxes), Tree::build_single(&boxes)] {
                    tree.validate(&boxes).unwrap();
                    assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
                }
            }
        }
    }

    #[test]
    fn trees_keep_to_the_stack_they_are_given() {
        // Each as large as all before it.
        let growing = (0..100).map(|i| {
            let far = 2_f32.powi(i);
            Aabb::of([Vec3::splat(far), Vec3::splat(2.0 * far)])
        });
        let boxes: Vec<Aabb> = growing.collect();
        let needs = [96, 30, 20, 0].map(|share| {
            let tree = within(&boxes, 1, 4, share);
            tree.validate(&boxes).unwrap();
            tree.stack_need()
        });
        assert!(
            needs[0] > 30 && needs[1] > 20 && needs[1] <= 30 && needs[2] <= 20,
            "{needs:?}"
        );
        let medians = balanced(&boxes, 1, 4).stack_need();
        assert_eq!(needs[3], medians, "nothing fits: medians");
    }

    #[test]
    fn equal_boxes_make_a_tree() {
        let boxes = vec![boxes(1, 1.0, 0.0, 5)[0]; 500];
        Tree::build(&boxes).validate(&boxes).unwrap();
    }
}
