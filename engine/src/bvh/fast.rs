//! [`RowTree`]: a tree whose leaf slots hold one row each, directly; built quickly ([`Clusters`] collapsed to
//! four children a node). What the instance tree keeps; [`super::paths`] changes single rows of it.

use rayon::prelude::*;

use super::build::{STACK_SHARE, balanced};
use super::cluster::Clusters;
use super::refit::{refit, refit_level, total_cost};
use super::tree::stack_need;
use super::{CHILD_NONE, Child, Extent, Node4, Tree};
use crate::geom::Aabb;

/// Nodes of a level from which more than one thread gathers them.
const PARALLEL_FROM: usize = 2048;
/// No slot.
pub const NOWHERE: u32 = u32::MAX;

/// Nodes whose leaves name rows directly, and the ways back up.
///
/// A slot is numbered four times its node and which child of it.
#[derive(Clone, Debug, Default)]
pub struct RowTree {
    /// Node 0 is the root; empty for no rows. Children come after their parents.
    pub nodes: Vec<Node4>,
    /// `levels[d]..levels[d + 1]` are the nodes of depth d, breadth first; nodes behind the last level were
    /// put in since the tree was built.
    pub levels: Vec<u32>,
    /// Of every node: the slot that names it.
    pub parents: Vec<u32>,
    /// Of every row: the slot that holds it, or [`NOWHERE`].
    pub places: Vec<u32>,
    /// The nodes of the binary tree that nodes stand for, while building.
    sources: Vec<u32>,
}

impl RowTree {
    /// Makes the tree anew over boxes, `rows` being the row of each, less than the length of `places`.
    pub fn build(&mut self, clusters: &mut Clusters, boxes: &[Extent], rows: &[u32]) {
        self.nodes.clear();
        self.levels.clear();
        self.parents.clear();
        self.places.fill(NOWHERE);
        if boxes.is_empty() {
            return;
        }
        let root = clusters.build(boxes);
        self.levels.push(0);
        self.sources.clear();
        self.sources.push(root);
        self.parents.push(NOWHERE);
        while self.nodes.len() < self.sources.len() {
            let level = self.nodes.len()..self.sources.len();
            self.levels.push(level.end as u32);
            self.nodes.resize(level.end, Node4::EMPTY);
            let (nodes, sources) = (&mut self.nodes[level.clone()], &self.sources[level.clone()]);
            let gather = |(node, &source): (&mut Node4, &u32)| gather(clusters, source, node);
            if level.len() >= PARALLEL_FROM {
                let nodes = nodes.par_iter_mut().with_min_len(PARALLEL_FROM / 4);
                nodes.zip(sources).for_each(gather);
            } else {
                nodes.iter_mut().zip(sources).for_each(gather);
            }
            let leaves = clusters.order.len() as u32;
            for index in level {
                self.number_children(index, leaves, |leaf| {
                    rows[clusters.order[leaf as usize] as usize]
                });
            }
        }
        if stack_need(&self.nodes) > STACK_SHARE {
            // By medians, which cannot overflow a traversal's stack.
            let plain: Vec<Aabb> = boxes.iter().map(|&b| b.into()).collect();
            self.take_over(balanced(&plain, 1, 4), rows);
        }
    }

    /// The same by [`Tree::build_single`]: slower, and a better tree.
    pub fn build_carefully(&mut self, boxes: &[Extent], rows: &[u32]) {
        let plain: Vec<Aabb> = boxes.iter().map(|&b| b.into()).collect();
        self.places.fill(NOWHERE);
        self.take_over(Tree::build_single(&plain), rows);
    }

    /// Makes a tree over boxes, one a leaf, this one over `rows`.
    fn take_over(&mut self, tree: Tree, rows: &[u32]) {
        (self.nodes, self.levels) = (tree.nodes, tree.levels);
        self.parents.clear();
        self.parents.resize(self.nodes.len(), NOWHERE);
        for (index, node) in self.nodes.iter_mut().enumerate() {
            for (slot, child) in node.children.iter_mut().enumerate() {
                let place = (4 * index + slot) as u32;
                match Child::decode(*child) {
                    Child::None => {}
                    Child::Node(child) => self.parents[child as usize] = place,
                    Child::Leaf { first, count } => {
                        let row = rows[tree.prims[first as usize] as usize];
                        self.places[row as usize] = place;
                        *child = Child::Leaf { first: row, count }.encode();
                    }
                }
            }
        }
    }

    /// Fits every box again; `row_box` is that of a row. The cost, as [`super::Tree::refit`] has it.
    pub fn refit(&mut self, row_box: &(impl Fn(usize) -> Extent + Sync), parallel: bool) -> f32 {
        let built = self.levels.last().map_or(0, |&end| end as usize);
        if built == self.nodes.len() {
            return refit::<1>(&mut self.nodes, &self.levels, row_box, parallel);
        }
        for index in (built..self.nodes.len()).rev() {
            refit_level::<1>(&mut self.nodes, index..index + 1, row_box);
        }
        for level in self.levels.windows(2).rev() {
            refit_level::<1>(
                &mut self.nodes,
                level[0] as usize..level[1] as usize,
                row_box,
            );
        }
        total_cost(&self.nodes)
    }

    /// Turns the binary nodes in a node's slots into rows, and into the numbers of nodes to come.
    fn number_children(&mut self, index: usize, leaves: u32, row: impl Fn(u32) -> u32) {
        for (slot, child) in self.nodes[index].children.iter_mut().enumerate() {
            let place = (4 * index + slot) as u32;
            if *child == CHILD_NONE {
                continue;
            }
            if *child < leaves {
                let first = row(*child);
                self.places[first as usize] = place;
                *child = Child::Leaf { first, count: 1 }.encode();
            } else {
                self.sources.push(*child);
                self.parents.push(place);
                *child = Child::Node(self.sources.len() as u32 - 1).encode();
            }
        }
    }

    /// Checks every invariant of a tree over the rows that are there.
    ///
    /// # Errors
    /// The first violation, as a sentence.
    pub fn validate(&self, rows: &[Option<Aabb>]) -> Result<(), String> {
        let mut held = vec![NOWHERE; rows.len()];
        let mut below = vec![Aabb::EMPTY; self.nodes.len()];
        let mut names = vec![NOWHERE; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            for slot in 0..4 {
                let place = (4 * index + slot) as u32;
                let inside = match Child::decode(node.children[slot]) {
                    Child::None => Aabb::EMPTY,
                    Child::Node(child) if child as usize <= index => {
                        return Err(format!("node {index} has child {child}, not after it"));
                    }
                    Child::Node(child) => {
                        names[child as usize] = place;
                        below[child as usize]
                    }
                    Child::Leaf { first, .. } => {
                        let Some(row) = rows.get(first as usize).copied().flatten() else {
                            return Err(format!("row {first} is held but not there"));
                        };
                        held[first as usize] = place;
                        row.grown()
                    }
                };
                if node.child_box(slot) != inside {
                    let found = node.child_box(slot);
                    return Err(format!(
                        "slot {slot} of node {index}: {found:?} for {inside:?}"
                    ));
                }
                below[index] = below[index].union(inside);
            }
        }
        if held != self.places {
            return Err("rows are not held where their places say".into());
        }
        if let Some(lost) = (0..rows.len()).find(|&row| rows[row].is_some() && held[row] == NOWHERE)
        {
            return Err(format!("row {lost} is not held"));
        }
        if names != self.parents {
            return Err("nodes are not named where their parents say".into());
        }
        match stack_need(&self.nodes) {
            need if need > STACK_SHARE => Err(format!("a stack of {need} is needed")),
            _ => Ok(()),
        }
    }
}

/// Fills the node that takes in the children of a binary node, and of those the largest, until it has four;
/// its slots name binary nodes.
fn gather(clusters: &Clusters, source: u32, node: &mut Node4) {
    let leaves = clusters.order.len() as u32;
    let mut group = [source, CHILD_NONE, CHILD_NONE, CHILD_NONE];
    let mut boxes = [Extent::EMPTY; 4];
    let mut areas = [f32::INFINITY; 4];
    boxes[0] = clusters.boxes[source as usize];
    for size in 1..4 {
        let open = (1..size).fold(0, |a, b| if areas[b] > areas[a] { b } else { a });
        if group[open] < leaves {
            break;
        }
        let children = clusters.children[(group[open] - leaves) as usize];
        for (slot, child) in [open, size].into_iter().zip(children) {
            let b = clusters.boxes[child as usize];
            (group[slot], boxes[slot]) = (child, b);
            areas[slot] = if child < leaves { -1.0 } else { b.half_area() };
        }
    }
    node.set_boxes(boxes.map(Extent::grown));
    for (slot, &child) in group.iter().enumerate() {
        if child == CHILD_NONE {
            node.set_child(slot, &Aabb::EMPTY, Child::None);
        }
    }
    node.children = group;
}
