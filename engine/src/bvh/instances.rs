//! The tree over the instances of a frame, which follows them as cheaply as measured cost says.
//!
//! The packer calls [`InstanceTree::update`] once a frame with the box of every row. What it does (nothing,
//! paths from leaf to root, a refit of all boxes, a new tree) never changes a hit, so it may depend on the
//! clock: it keeps running averages of what each costs a row. The rule:
//!
//! - Where building a tree of full quality takes next to nothing of what tracing takes, that is done: a few
//!   things in a costly picture.
//! - Some rows moved: their paths, unless so many that a refit is cheaper.
//! - Rows went: free slots. Rows came: put in, unless a new tree is cheaper.
//! - A new tree is due when the cost of the tree by the surface area heuristic is more than 1.5 times what
//!   it was when built; when slots of nodes are mostly free; when putting rows in has made the tree so deep
//!   that a traversal's stack could overflow; or when tracing has lost more through drift than building
//!   costs. Of the last, every frame adds (cost / cost when built - 1) times the time spent in tracing
//!   ([`InstanceTree::trace_nanos`]), and a tree is due when that is more than a new tree costs beyond a refit
//!   (buying after having paid the price in rent is at most twice as dear as knowing the future).

mod changes;

use std::ops::Range;
use std::time::Instant;

use self::changes::{Changes, is_there};
use super::build::STACK_SHARE;
use super::cluster::Clusters;
use super::fast::{NOWHERE, RowTree};
use super::paths::Trail;
use super::refit::total_cost;
use super::tree::stack_need;
use super::{Extent, Node4};
use crate::geom::Aabb;

/// Drift of the cost at which a new tree is always due.
const MOST_DRIFT: f32 = 1.5;
/// Rows from which a refit wakes more than one thread.
const PARALLEL_FROM: usize = 8192;
/// Levels that never need more of a stack than a tree's share, whatever is in them.
const SAFE_DEPTH: usize = (STACK_SHARE as usize - 4) / 3 + 1;
/// Tracing is taken to be so many times as dear as a new tree until it was measured.
const TRACE_PER_BUILD: f64 = 8.0;

/// The share of the time spent in tracing that a tree of full quality may take a frame.
const CAREFUL_SHARE: f64 = 0.02;

/// Nodes between two that were written to, up to which they make one range.
const DIRTY_GAP: u32 = 4;

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TreeAction {
    /// Nothing.
    #[default]
    None,
    /// Boxes from some leaves to the root; rows that came and went.
    Paths,
    /// Every box.
    Refit,
    /// A new tree.
    Rebuild,
}

/// An update's account.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TreeWork {
    /// What was done.
    pub action: TreeAction,
    /// Rows that moved, came or went, as far as it was told; all after a refit or a new tree.
    pub rows: u32,
    /// Nodes written to.
    pub nodes: u32,
    /// Cost by the surface area heuristic, see [`super::Tree::cost`], before.
    pub cost_before: f32,
    /// The same afterwards.
    pub cost_after: f32,
    /// Time taken.
    pub nanos: u64,
}

/// A running average of nanoseconds a row.
#[derive(Clone, Copy, Debug)]
struct Price(f64);

impl Price {
    fn learn(&mut self, nanos: f64, rows: usize) {
        self.0 += 0.2 * (nanos / rows.max(1) as f64 - self.0);
    }

    fn of(self, rows: usize) -> f64 {
        self.0 * rows as f64
    }
}

/// The tree, what it was made for, and what its upkeep costs.
#[derive(Clone, Debug)]
pub struct InstanceTree {
    /// Nanoseconds that tracing through this tree takes a frame, where that is measured; see the module.
    pub trace_nanos: Option<f64>,
    tree: RowTree,
    clusters: Clusters,
    /// Rows in the tree.
    live: usize,
    /// Levels of the tree, with those that rows which came have added.
    deepest: usize,
    /// Slots left free by rows that went.
    free: usize,
    /// Half the areas of all slots.
    area: f64,
    cost: f32,
    cost_when_built: f32,
    /// What drift has cost since the tree was built, in nanoseconds.
    lost: f64,
    paths: Price,
    refits: Price,
    builds: Price,
    careful_builds: Price,
    dirty: Vec<Range<u32>>,
    changes: Changes,
    trail: Trail,
    boxes: Vec<Extent>,
    rows: Vec<u32>,
}

impl Default for InstanceTree {
    fn default() -> Self {
        Self {
            trace_nanos: None,
            tree: RowTree::default(),
            clusters: Clusters::default(),
            live: 0,
            deepest: 0,
            free: 0,
            area: 0.0,
            cost: 0.0,
            cost_when_built: 0.0,
            lost: 0.0,
            // Right to a factor; then measured.
            paths: Price(300.0),
            refits: Price(20.0),
            builds: Price(100.0),
            careful_builds: Price(800.0),
            dirty: Vec::new(),
            changes: Changes::default(),
            trail: Trail::default(),
            boxes: Vec::new(),
            rows: Vec::new(),
        }
    }
}

impl InstanceTree {
    /// The nodes; leaves hold one row each, their `first` being its number.
    pub fn nodes(&self) -> &[Node4] {
        &self.tree.nodes
    }

    /// Ranges of nodes that the last update wrote to, in order, apart from one another.
    pub fn dirty(&self) -> &[Range<u32>] {
        &self.dirty
    }

    /// Cost by the surface area heuristic.
    pub fn cost(&self) -> f32 {
        self.cost
    }

    /// Makes the tree one over these boxes, by row; an empty one, or one that is no number, is of no row.
    ///
    /// `changed` are the rows to look at, rows past the old end among them; `None`: all of them.
    pub fn update(&mut self, boxes: &[Aabb], changed: Option<&[u32]>) -> TreeWork {
        let start = Instant::now();
        self.dirty.clear();
        let mut work = TreeWork {
            cost_before: self.cost,
            ..TreeWork::default()
        };
        self.changes.sort(&mut self.tree.places, boxes, changed);
        let Changes { moved, came, went } = &self.changes;
        let touched = moved.len() + came.len() + went.len();
        let was_empty = self.live == 0;
        self.live = self.live + came.len() - went.len();
        self.free = (self.free + went.len()).saturating_sub(came.len());
        work.rows = touched as u32;
        let carefully =
            self.careful_builds.of(self.live) < CAREFUL_SHARE * self.trace_nanos.unwrap_or(0.0);
        work.action = if touched == 0 {
            TreeAction::None
        } else if carefully || was_empty || self.is_new_tree_due() {
            TreeAction::Rebuild
        } else {
            self.follow(boxes)
        };
        if work.action == TreeAction::Rebuild {
            self.rebuild_by(boxes, carefully);
        }
        self.tree.places.truncate(boxes.len());
        self.note_drift(work.action);
        work.nodes = self.dirty.iter().map(|r| r.end - r.start).sum();
        work.cost_after = self.cost;
        work.nanos = start.elapsed().as_nanos() as u64;
        work
    }

    /// Whether to build a new tree before having looked at what moved.
    fn is_new_tree_due(&self) -> bool {
        let Changes { moved, came, went } = &self.changes;
        let build = self.builds.of(self.live);
        let single = self.paths.of(came.len() + went.len());
        let follow = self.refits.of(self.live).min(self.paths.of(moved.len()));
        self.live == 0
            || self.tree.nodes.is_empty()
            || self.free > self.live
            || single + follow > build
            || self.lost > (build - follow).max(0.0) && self.cost > self.cost_when_built
    }

    /// Follows the changes within the tree as it is, unless that makes a bad tree.
    fn follow(&mut self, boxes: &[Aabb]) -> TreeAction {
        let start = Instant::now();
        let grown = |row: u32| Extent::from(boxes[row as usize]).grown();
        let changes = std::mem::take(&mut self.changes);
        let Changes { moved, came, went } = &changes;
        let all = self.paths.of(moved.len()) > self.refits.of(self.live);
        for &row in went {
            self.tree.remove_row(row, &mut self.trail);
        }
        for &row in came {
            self.tree.insert_row(row, grown(row), &mut self.trail);
            let depth = self.tree.depth_of(self.tree.places[row as usize]);
            self.deepest = self.deepest.max(depth);
        }
        if !all {
            for &row in moved {
                self.tree.move_row(row, grown(row), &mut self.trail);
            }
        }
        let singles = came.len() + went.len() + if all { 0 } else { moved.len() };
        if singles > 0 {
            self.paths.learn(start.elapsed().as_nanos() as f64, singles);
        }
        let has_come = !came.is_empty();
        self.changes = changes;
        self.note_trail();
        if all {
            self.refit(boxes);
        }
        let too_deep =
            has_come && self.deepest > SAFE_DEPTH && stack_need(&self.tree.nodes) > STACK_SHARE;
        if too_deep || self.cost > MOST_DRIFT * self.cost_when_built {
            TreeAction::Rebuild
        } else if all {
            TreeAction::Refit
        } else {
            TreeAction::Paths
        }
    }

    /// Nodes that a traversal may have to keep at once, at most.
    pub fn stack_bound(&self) -> u32 {
        // Three siblings a level, and what is taken up next.
        (3 * self.deepest as u32 + 1).min(STACK_SHARE)
    }

    /// Fits every box of the tree as it is, whatever [`InstanceTree::update`] would do; the rows are those of
    /// the last update.
    pub fn refit(&mut self, boxes: &[Aabb]) {
        let start = Instant::now();
        let row_box = |row: usize| Extent::from(boxes[row]);
        self.cost = self.tree.refit(&row_box, self.live >= PARALLEL_FROM);
        self.area = f64::from(self.cost) * self.root_area();
        self.note_all_dirty();
        self.refits
            .learn(start.elapsed().as_nanos() as f64, self.live);
    }

    /// Makes a new tree, whatever [`InstanceTree::update`] would do.
    pub fn rebuild(&mut self, boxes: &[Aabb]) {
        self.rebuild_by(boxes, false);
    }

    fn rebuild_by(&mut self, boxes: &[Aabb], carefully: bool) {
        let start = Instant::now();
        self.rows.clear();
        self.rows
            .extend((0..boxes.len() as u32).filter(|&row| is_there(&boxes[row as usize])));
        self.boxes.clear();
        self.boxes.extend(
            self.rows
                .iter()
                .map(|&row| Extent::from(boxes[row as usize])),
        );
        self.tree.places.resize(boxes.len(), NOWHERE);
        if carefully {
            self.tree.build_carefully(&self.boxes, &self.rows);
        } else {
            self.tree.build(&mut self.clusters, &self.boxes, &self.rows);
        }
        self.live = self.rows.len();
        self.free = 0;
        self.cost = total_cost(&self.tree.nodes);
        self.cost_when_built = self.cost;
        self.deepest = self.tree.levels.len();
        self.area = f64::from(self.cost) * self.root_area();
        self.note_all_dirty();
        let price = if carefully {
            &mut self.careful_builds
        } else {
            &mut self.builds
        };
        price.learn(start.elapsed().as_nanos() as f64, self.live);
    }

    fn root_area(&self) -> f64 {
        let root = self.tree.nodes.first();
        root.map_or(0.0, |root| f64::from(Aabb::from(root.extent()).half_area()))
    }

    fn note_all_dirty(&mut self) {
        self.dirty.clear();
        if !self.tree.nodes.is_empty() {
            self.dirty.push(0..self.tree.nodes.len() as u32);
        }
    }

    /// Takes in what single rows have changed.
    fn note_trail(&mut self) {
        self.area += std::mem::take(&mut self.trail.growth);
        let root = self.root_area();
        self.cost = if root > 0.0 {
            (self.area / root) as f32
        } else {
            0.0
        };
        let nodes = &mut self.trail.nodes;
        nodes.sort_unstable();
        for node in nodes.drain(..) {
            match self.dirty.last_mut() {
                Some(range) if node <= range.end + DIRTY_GAP => range.end = range.end.max(node + 1),
                _ => self.dirty.push(node..node + 1),
            }
        }
    }

    fn note_drift(&mut self, action: TreeAction) {
        match action {
            TreeAction::None => {}
            TreeAction::Rebuild => self.lost = 0.0,
            TreeAction::Paths | TreeAction::Refit => {
                let supposed = TRACE_PER_BUILD * self.builds.of(self.live);
                let drift = f64::from(self.cost / self.cost_when_built) - 1.0;
                self.lost += drift.max(0.0) * self.trace_nanos.unwrap_or(supposed);
            }
        }
    }

    /// Checks every invariant of a tree over these boxes.
    ///
    /// # Errors
    /// The first violation, as a sentence.
    pub fn validate(&self, boxes: &[Aabb]) -> Result<(), String> {
        let there = boxes
            .iter()
            .map(|b| is_there(b).then_some(*b))
            .collect::<Vec<_>>();
        self.tree.validate(&there)
    }
}

#[cfg(test)]
mod tests;
