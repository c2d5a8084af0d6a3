//! A tree: nodes, and primitives in the order of its leaves.

use serde::{Deserialize, Serialize};
use std::ops::Range;

use super::structures::bounds_content;
use super::{Bounds, CHILD_LEAF, CHILD_NONE, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, Node4};
use crate::geom::Aabb;

/// A 4-wide tree over numbered boxes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tree {
    /// Node 0 is the root; empty for no primitives. Breadth first: the children of a level's nodes are the
    /// next level, in the same order.
    #[serde(with = "crate::pod::array")]
    pub nodes: Vec<Node4>,
    /// Primitive numbers; a leaf names a range of these.
    #[serde(with = "crate::pod::array")]
    pub prims: Vec<u32>,
    /// `levels[d]..levels[d + 1]` are the nodes of depth d, the root's being 0; empty for no primitives.
    #[serde(with = "crate::pod::array")]
    pub levels: Vec<u32>,
    /// What slots of nodes hold.
    pub bounds: Bounds,
}

/// What a slot of [`Node4::children`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Nothing.
    None,
    /// A node.
    Node(u32),
    /// A range of [`Tree::prims`].
    Leaf {
        /// First of the range.
        first: u32,
        /// 1 to 8.
        count: u32,
    },
}

impl Child {
    /// Most primitives a leaf can hold.
    pub const MAX_LEAF: u32 = 8;

    /// Reads a slot.
    #[inline]
    pub fn decode(slot: u32) -> Self {
        if slot == CHILD_NONE {
            Self::None
        } else if slot & CHILD_LEAF == 0 {
            Self::Node(slot)
        } else {
            Self::Leaf {
                first: slot & LEAF_FIRST_MASK,
                count: ((slot & !CHILD_LEAF) >> LEAF_COUNT_SHIFT) + 1,
            }
        }
    }

    /// Writes a slot.
    pub fn encode(self) -> u32 {
        match self {
            Self::None => CHILD_NONE,
            Self::Node(node) => node,
            Self::Leaf { first, count } => CHILD_LEAF | (count - 1) << LEAF_COUNT_SHIFT | first,
        }
    }
}

impl Node4 {
    /// The box of a slot.
    pub fn child_box(&self, slot: usize) -> Aabb {
        Aabb {
            min: glam::Vec3::new(self.min_x[slot], self.min_y[slot], self.min_z[slot]),
            max: glam::Vec3::new(self.max_x[slot], self.max_y[slot], self.max_z[slot]),
        }
    }

    /// Puts a child and its box into a slot.
    pub fn set_child(&mut self, slot: usize, bounds: &Aabb, child: Child) {
        [self.min_x[slot], self.min_y[slot], self.min_z[slot]] = bounds.min.to_array();
        [self.max_x[slot], self.max_y[slot], self.max_z[slot]] = bounds.max.to_array();
        self.children[slot] = child.encode();
    }
}

impl Tree {
    /// Levels of nodes: 0 for no primitives, 1 for a root alone.
    pub fn depth(&self) -> usize {
        self.levels.len().saturating_sub(1)
    }

    /// The nodes of a level, less than [`Tree::depth`].
    pub fn level(&self, depth: usize) -> Range<usize> {
        self.levels[depth] as usize..self.levels[depth + 1] as usize
    }

    /// The box around everything in a tree of boxes, grown; empty for no primitives.
    pub fn around(&self) -> Aabb {
        self.nodes
            .first()
            .map_or(Aabb::EMPTY, |root| root.extent().into())
    }

    /// Nodes a traversal may have to keep at once, whatever the ray.
    pub fn stack_need(&self) -> u32 {
        stack_need(&self.nodes)
    }

    /// Walks the tree and checks every invariant: each primitive in exactly one leaf, every bound around
    /// all that is below it (exact compare), nodes breadth first in the levels that are stated.
    ///
    /// # Errors
    /// The first violation, as a sentence.
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), String> {
        self.validate_order()?;
        let mut seen = vec![0_u32; boxes.len()];
        let mut below = vec![Aabb::EMPTY; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            for slot in 0..4 {
                let inside = match Child::decode(node.children[slot]) {
                    Child::None => continue,
                    Child::Node(child) => below[child as usize],
                    Child::Leaf { first, count } => {
                        let range = first as usize..(first + count) as usize;
                        let prims = self
                            .prims
                            .get(range)
                            .ok_or_else(|| format!("a leaf of node {index} is out of range"))?;
                        prims.iter().for_each(|&p| seen[p as usize] += 1);
                        prims
                            .iter()
                            .fold(Aabb::EMPTY, |b, &p| b.union(boxes[p as usize]))
                    }
                };
                if !bounds_content(node, slot, &inside, self.bounds) {
                    return Err(format!(
                        "slot {slot} of node {index} is smaller than its content"
                    ));
                }
                below[index] = below[index].union(inside);
            }
        }
        match seen.iter().position(|&count| count != 1) {
            Some(prim) => Err(format!("primitive {prim} is in {} leaves", seen[prim])),
            None => Ok(()),
        }
    }
    /// Checks that nodes are in breadth-first order, each the child of one, and that the levels are theirs.
    fn validate_order(&self) -> Result<(), String> {
        let mut levels = if self.nodes.is_empty() {
            vec![]
        } else {
            vec![0, 1]
        };
        let mut next = 1;
        for (index, node) in self.nodes.iter().enumerate() {
            if levels.last() == Some(&(index as u32)) {
                levels.push(next);
            }
            for &slot in &node.children {
                match Child::decode(slot) {
                    Child::Node(child) if child != next => {
                        return Err(format!("node {index} has child {child} for {next}"));
                    }
                    Child::Node(_) => next += 1,
                    Child::None | Child::Leaf { .. } => {}
                }
            }
        }
        if !self.nodes.is_empty() && next as usize != self.nodes.len() {
            return Err(format!("{next} nodes of {} are reached", self.nodes.len()));
        }
        if levels != self.levels {
            return Err(format!("levels {:?} for {levels:?}", self.levels));
        }
        Ok(())
    }
}

/// [`Tree::stack_need`] of nodes whose children come after them.
pub(super) fn stack_need(nodes: &[Node4]) -> u32 {
    let mut need = vec![1_u32; nodes.len()];
    for (index, node) in nodes.iter().enumerate().rev() {
        let children = node.children.iter().filter(|&&c| c != CHILD_NONE).count() as u32;
        let deepest = node
            .children
            .iter()
            .filter_map(|&c| match Child::decode(c) {
                Child::Node(child) => Some(need[child as usize]),
                _ => None,
            });
        need[index] = children.max(children.saturating_sub(1) + deepest.max().unwrap_or(0));
    }
    need.first().copied().unwrap_or(0)
}
