//! Changes of single rows of a [`RowTree`]: the box of a row, and every box above it that has to follow; a
//! row that comes or goes.
//!
//! What is left is what a refit of the whole tree would leave, bit for bit. A row that goes leaves a free
//! slot with an inverted box. A row that comes goes down where it enlarges boxes least (Goldsmith and
//! Salmon 1987), into a free slot there or, splitting a leaf's slot, into a new node at the end.

use super::fast::{NOWHERE, RowTree};
use super::{CHILD_NONE, Child, Extent, Node4};
use crate::geom::Aabb;

/// What changes left behind.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    /// Nodes written to, some perhaps twice.
    pub nodes: Vec<u32>,
    /// How much the sum of half the areas of all slots grew.
    pub growth: f64,
}

impl RowTree {
    /// The box of a row moved; `grown` is what its slot shall be.
    pub fn move_row(&mut self, row: u32, grown: Extent, trail: &mut Trail) {
        self.set_upward(self.places[row as usize], grown.into(), trail);
    }

    /// A row goes away.
    pub fn remove_row(&mut self, row: u32, trail: &mut Trail) {
        let place = std::mem::replace(&mut self.places[row as usize], NOWHERE);
        self.nodes[place as usize / 4].children[place as usize % 4] = CHILD_NONE;
        trail.nodes.push(place / 4);
        self.set_upward(place, Aabb::EMPTY, trail);
    }

    /// A row comes to a tree that has a root.
    pub fn insert_row(&mut self, row: u32, grown: Extent, trail: &mut Trail) {
        let bounds = Aabb::from(grown);
        let mut node = 0;
        let place = loop {
            let slot = best_slot(&self.nodes[node as usize], &bounds);
            let place = 4 * node + slot as u32;
            match Child::decode(self.nodes[node as usize].children[slot]) {
                Child::None => break place,
                Child::Node(child) => node = child,
                Child::Leaf { .. } => break 4 * self.split(place, trail) + 1,
            }
        };
        self.places[row as usize] = place;
        let leaf = Child::Leaf {
            first: row,
            count: 1,
        };
        self.nodes[place as usize / 4].children[place as usize % 4] = leaf.encode();
        trail.nodes.push(place / 4);
        self.set_upward(place, bounds, trail);
    }

    /// Puts a new node between a slot and its leaf; the node's number.
    fn split(&mut self, place: u32, trail: &mut Trail) -> u32 {
        let new = self.nodes.len() as u32;
        let (node, slot) = (place as usize / 4, place as usize % 4);
        let bounds = self.nodes[node].child_box(slot);
        let child = Child::decode(self.nodes[node].children[slot]);
        let mut below = Node4::EMPTY;
        below.set_child(0, &bounds, child);
        if let Child::Leaf { first, .. } = child {
            self.places[first as usize] = 4 * new;
        }
        self.nodes[node].children[slot] = Child::Node(new).encode();
        self.nodes.push(below);
        self.parents.push(place);
        trail.nodes.extend([node as u32, new]);
        trail.growth += f64::from(bounds.half_area());
        new
    }

    /// Sets the box of a slot and of those above, as far up as something changes.
    fn set_upward(&mut self, mut place: u32, mut bounds: Aabb, trail: &mut Trail) {
        while place != NOWHERE {
            let (index, slot) = (place as usize / 4, place as usize % 4);
            let node = &mut self.nodes[index];
            let before = node.child_box(slot);
            if before == bounds {
                return;
            }
            node.set_child(slot, &bounds, Child::decode(node.children[slot]));
            trail.nodes.push(index as u32);
            trail.growth += f64::from(bounds.half_area()) - f64::from(before.half_area());
            bounds = node.extent().into();
            place = self.parents[index];
        }
    }

    /// Levels of nodes from the root to that of a slot, both included.
    pub fn depth_of(&self, place: u32) -> usize {
        let up = |&place: &u32| match self.parents[place as usize / 4] {
            NOWHERE => None,
            above => Some(above),
        };
        std::iter::successors(Some(place), up).count()
    }
}

/// Where a box goes on its way down: the child that it enlarges least, unless a free slot is cheaper.
fn best_slot(node: &Node4, bounds: &Aabb) -> usize {
    let enlarged = |slot: usize| {
        let child = node.child_box(slot);
        match Child::decode(node.children[slot]) {
            Child::None => bounds.half_area(),
            Child::Node(_) => child.union(*bounds).half_area() - child.half_area(),
            // Both leaves would lie in a node of their own.
            Child::Leaf { .. } => child.union(*bounds).half_area() + bounds.half_area(),
        }
    };
    (0..4)
        .min_by(|&a, &b| enlarged(a).total_cmp(&enlarged(b)))
        .unwrap_or(0)
}
