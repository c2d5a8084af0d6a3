//! Refit: every box of a tree again, from the leaves up, for primitives that moved and a topology that stays.
//!
//! Called for meshes whose vertices changed and for instances that moved. The result is what a fresh
//! computation gives for the same topology, bit for bit, serial or parallel: boxes of leaves are grown
//! outward around the very values that the intersector reads ([`Extent::grown`]), and since the union of
//! grown boxes is the grown union, inner boxes are plain unions of their children's.
//!
//! The surface area heuristic's cost comes along (Goldsmith and Salmon 1987; MacDonald and Booth 1990): the
//! sum over all children of half their area times their weight, 1 for a node and the number of primitives
//! for a leaf, over half the area of the root's box. It is what a ray that meets the root's box is expected
//! to visit.

use std::ops::Range;

use glam::{Mat4, Vec3A, Vec4};
use rayon::prelude::*;

use super::build::MESH_LEAF;
use super::{Bounds, Child, Extent, LEAF_COUNT_SHIFT, Node4, Tree};
use crate::geom::Aabb;

/// Nodes whose costs are summed in f32 before they go into an f64.
const CHUNK: usize = 512;
/// Subtrees that a large tree is cut into, so that threads can share them and sums do not depend on threads.
const SUBTREES: u32 = 64;
/// Nodes from which more than one thread is worth waking.
const PARALLEL_FROM: usize = 2048;

impl Node4 {
    /// Sets the boxes of all four slots.
    #[inline]
    pub(super) fn set_boxes(&mut self, boxes: [Extent; 4]) {
        let [a, b, c, d] = boxes;
        let row = |c: Vec3A| Vec4::from((c, 0.0));
        let min = Mat4::from_cols(row(a.min), row(b.min), row(c.min), row(d.min)).transpose();
        let max = Mat4::from_cols(row(a.max), row(b.max), row(c.max), row(d.max)).transpose();
        self.min_x = min.x_axis.to_array();
        self.min_y = min.y_axis.to_array();
        self.min_z = min.z_axis.to_array();
        self.max_x = max.x_axis.to_array();
        self.max_y = max.y_axis.to_array();
        self.max_z = max.z_axis.to_array();
    }

    /// The box around all children; inverted when there are none.
    #[inline]
    pub(super) fn extent(&self) -> Extent {
        let columns = |[x, y, z]: [[f32; 4]; 3]| {
            let m = Mat4::from_cols_array_2d(&[x, y, z, z]).transpose();
            [m.x_axis, m.y_axis, m.z_axis, m.w_axis].map(Vec3A::from_vec4)
        };
        let [a, b, c, d] = columns([self.min_x, self.min_y, self.min_z]);
        let [e, f, g, h] = columns([self.max_x, self.max_y, self.max_z]);
        Extent {
            min: a.min(b).min(c.min(d)),
            max: e.max(f).max(g.max(h)),
        }
    }

    /// Half the area of each child's box times its weight; 0 for no child.
    #[inline]
    pub(super) fn cost(&self) -> Vec4 {
        let side =
            |min: [f32; 4], max: [f32; 4]| (Vec4::from(max) - Vec4::from(min)).max(Vec4::ZERO);
        let x = side(self.min_x, self.max_x);
        let y = side(self.min_y, self.max_y);
        let z = side(self.min_z, self.max_z);
        // A node's number stays below 2^28, so its weight reads as 1; an empty slot has no area.
        let weights = self
            .children
            .map(|slot| ((slot >> LEAF_COUNT_SHIFT & (Child::MAX_LEAF - 1)) + 1) as f32);
        (x * y + y * z + z * x) * Vec4::from(weights)
    }
}

impl Tree {
    /// Fits every box to its content again; the cost (see the module) of the tree as it is then.
    ///
    /// `slot_box` is the box of the primitive at a place in the order of leaves, that is, of
    /// `prims[place]`; it is asked once a place, and must be finite.
    pub fn refit(&mut self, slot_box: impl Fn(usize) -> Extent + Sync) -> f32 {
        let parallel = self.nodes.len() >= PARALLEL_FROM;
        self.refit_by(slot_box, parallel)
    }

    fn refit_by(&mut self, slot_box: impl Fn(usize) -> Extent + Sync, parallel: bool) -> f32 {
        const USUAL: usize = MESH_LEAF as usize;
        match self.bounds {
            Bounds::Boxes => refit::<USUAL>(&mut self.nodes, &self.levels, &slot_box, parallel),
            Bounds::Spheres => self.refit_spheres(slot_box),
            Bounds::Unbounded => self.cost_of_everything(),
        }
    }

    /// What a ray that meets the root's bounds is expected to visit; see the module. 0 for no tree.
    pub fn cost(&self) -> f32 {
        match self.bounds {
            Bounds::Boxes => total_cost(&self.nodes),
            Bounds::Spheres => self.cost_of_spheres(),
            Bounds::Unbounded => self.cost_of_everything(),
        }
    }
}

/// Subtrees first, each depth first (which visits the nodes of every level in order, and vertices that lie
/// close together shortly after one another), then the levels above them.
pub(super) fn refit<const USUAL: usize>(
    nodes: &mut [Node4],
    levels: &[u32],
    slot_box: &(impl Fn(usize) -> Extent + Sync),
    parallel: bool,
) -> f32 {
    let Some(top) = levels.windows(2).position(|l| l[1] - l[0] >= SUBTREES) else {
        let sum = levels
            .windows(2)
            .rev()
            .map(|l| refit_level::<USUAL>(nodes, l[0] as usize..l[1] as usize, slot_box))
            .sum();
        return relative_cost(sum, nodes);
    };
    let mut tasks = subtrees(nodes, &levels[top..]);
    let sums: Vec<f64> = if parallel {
        tasks
            .par_iter_mut()
            .map(|task| fit_all::<USUAL>(task, slot_box))
            .collect()
    } else {
        tasks
            .iter_mut()
            .map(|task| fit_all::<USUAL>(task, slot_box))
            .collect()
    };
    let mut sum = sums.iter().sum();
    for level in levels[..=top].windows(2).rev() {
        sum += refit_level::<USUAL>(nodes, level[0] as usize..level[1] as usize, slot_box);
    }
    relative_cost(sum, nodes)
}

/// The nodes that a subtree (or several neighbours) has on a level, and how many of them are done.
struct Share<'a> {
    nodes: &'a mut [Node4],
    done: usize,
}

/// Cuts the nodes of `levels` into groups of neighbouring subtrees; for each, its share of every level.
fn subtrees<'a>(nodes: &'a mut [Node4], levels: &[u32]) -> Vec<Vec<Share<'a>>> {
    let roots = (levels[1] - levels[0]) as usize;
    let each = roots.div_ceil(SUBTREES as usize);
    let mut cuts: Vec<usize> = (levels[0] as usize..levels[1] as usize)
        .step_by(each)
        .skip(1)
        .collect();
    let mut tasks: Vec<Vec<Share>> = (0..=cuts.len())
        .map(|_| Vec::with_capacity(levels.len()))
        .collect();
    let mut start = levels[0] as usize;
    let (_, mut rest) = nodes.split_at_mut(start);
    for (depth, level) in levels.windows(2).enumerate() {
        let end = level[1] as usize;
        let next_end = *levels.get(depth + 2).unwrap_or(&level[1]) as usize;
        // Where the children of what lies behind each cut begin.
        let below = cuts
            .iter()
            .map(|&cut| first_child(&rest[cut - start..end - start]).unwrap_or(next_end))
            .collect();
        for (task, cut) in tasks.iter_mut().zip(cuts.iter().copied().chain([end])) {
            let (share, remainder) = rest.split_at_mut(cut - start);
            task.push(Share {
                nodes: share,
                done: 0,
            });
            (rest, start) = (remainder, cut);
        }
        cuts = below;
    }
    tasks
}

/// The first inner child of any of these nodes.
fn first_child(nodes: &[Node4]) -> Option<usize> {
    let mut slots = nodes.iter().flat_map(|node| node.children);
    slots.find_map(|slot| match Child::decode(slot) {
        Child::Node(child) => Some(child as usize),
        Child::None | Child::Leaf { .. } => None,
    })
}

/// Fits all subtrees whose roots are the first share; the sum of the costs.
fn fit_all<const USUAL: usize>(shares: &mut [Share], slot_box: &impl Fn(usize) -> Extent) -> f64 {
    let mut sum = 0.0;
    for _ in 0..shares[0].nodes.len() {
        let mut cost = Vec4::ZERO;
        fit::<USUAL>(shares, slot_box, &mut cost);
        let [a, b, c, d] = cost.to_array().map(f64::from);
        sum += (a + b) + (c + d);
    }
    sum
}

/// Fits the next node of the first share and all below it.
fn fit<const USUAL: usize>(
    shares: &mut [Share],
    slot_box: &impl Fn(usize) -> Extent,
    cost: &mut Vec4,
) -> Extent {
    let (share, below) = shares.split_first_mut().expect("a node has a level");
    let node = &mut share.nodes[share.done];
    share.done += 1;
    let mut boxes = [Extent::EMPTY; 4];
    for (fitted, slot) in boxes.iter_mut().zip(node.children) {
        *fitted = match Child::decode(slot) {
            Child::None => continue,
            Child::Node(_) => fit::<USUAL>(below, slot_box, cost),
            Child::Leaf { first, count } => {
                leaf_box::<USUAL>(first as usize, count as usize, slot_box)
            }
        }
    }
    node.set_boxes(boxes);
    *cost += node.cost();
    let [a, b, c, d] = boxes;
    a.union(b).union(c.union(d))
}

/// The grown box of a leaf. Up to `USUAL` primitives take no branch: the last is read again.
#[inline]
fn leaf_box<const USUAL: usize>(
    first: usize,
    count: usize,
    slot_box: &impl Fn(usize) -> Extent,
) -> Extent {
    let last = first + count - 1;
    let usual = (0..USUAL).fold(Extent::EMPTY, |all, offset| {
        all.union(slot_box((first + offset).min(last)))
    });
    (first + USUAL..=last)
        .fold(usual, |all, place| all.union(slot_box(place)))
        .grown()
}

/// Fits the nodes of a level, those below being done; the sum of their costs.
pub(super) fn refit_level<const USUAL: usize>(
    nodes: &mut [Node4],
    level: Range<usize>,
    slot_box: &impl Fn(usize) -> Extent,
) -> f64 {
    let (upper, lower) = nodes.split_at_mut(level.end);
    let mut sum = Vec4::ZERO;
    for node in &mut upper[level.start..] {
        let boxes = node.children.map(|slot| match Child::decode(slot) {
            Child::None => Extent::EMPTY,
            Child::Node(child) => lower[child as usize - level.end].extent(),
            Child::Leaf { first, count } => {
                leaf_box::<USUAL>(first as usize, count as usize, slot_box)
            }
        });
        node.set_boxes(boxes);
        sum += node.cost();
    }
    let [a, b, c, d] = sum.to_array().map(f64::from);
    (a + b) + (c + d)
}

/// [`Tree::cost`] of a range of nodes whose first is the root.
pub(super) fn total_cost(nodes: &[Node4]) -> f32 {
    let chunk = |nodes: &[Node4]| {
        let sum: Vec4 = nodes.iter().map(Node4::cost).sum();
        let [a, b, c, d] = sum.to_array().map(f64::from);
        (a + b) + (c + d)
    };
    relative_cost(nodes.chunks(CHUNK).map(chunk).sum(), nodes)
}

fn relative_cost(sum: f64, nodes: &[Node4]) -> f32 {
    let root = nodes
        .first()
        .map_or(0.0, |root| Aabb::from(root.extent()).half_area());
    if root > 0.0 {
        (sum / f64::from(root)) as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::build::balanced;
    use super::*;

    /// Random boxes around places that the same numbers give whatever the size.
    fn boxes(count: usize, seed: u32, size: f32) -> Vec<Aabb> {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0 - 0.5
        };
        let mut corner = || Vec3::new(random(), random(), random());
        (0..count)
            .map(|_| {
                let center = corner() * 100.0;
                Aabb::of([center + corner() * size, center - corner() * size])
            })
            .collect()
    }

    /// Every box from scratch, and the cost, in the plainest way.
    fn naive(tree: &mut Tree, boxes: &[Aabb]) -> f64 {
        let mut sum = 0.0;
        let mut below = vec![Aabb::EMPTY; tree.nodes.len()];
        for index in (0..tree.nodes.len()).rev() {
            for slot in 0..4 {
                let child = Child::decode(tree.nodes[index].children[slot]);
                let (inside, weight) = match child {
                    Child::None => continue,
                    Child::Node(node) => (below[node as usize], 1),
                    Child::Leaf { first, count } => {
                        let prims = &tree.prims[first as usize..(first + count) as usize];
                        let all = prims.iter().map(|&p| boxes[p as usize]);
                        (all.fold(Aabb::EMPTY, Aabb::union), count)
                    }
                };
                below[index] = below[index].union(inside);
                tree.nodes[index].set_child(slot, &inside.grown(), child);
                sum += f64::from(inside.grown().half_area()) * f64::from(weight);
            }
        }
        sum / f64::from(below[0].grown().half_area())
    }

    #[test]
    fn a_refit_is_a_fresh_computation_of_every_box() {
        for count in [1, 2, 5, 64, 1000, 20_000] {
            for seed in 0..4 {
                let before = boxes(count, seed, 1.0);
                let after = boxes(count, seed + 100, 30.0);
                let usual = Tree::build(&before);
                let large_leaves = balanced(&before, Child::MAX_LEAF, 4);
                for tree in [usual, large_leaves] {
                    check_refit(&tree, &after);
                }
            }
        }
    }

    fn check_refit(tree: &Tree, moved: &[Aabb]) {
        let [mut serial, mut parallel, mut fresh] = [(); 3].map(|()| tree.clone());
        let slot_box = |place: usize| Extent::from(moved[tree.prims[place] as usize]);
        let expected = naive(&mut fresh, moved);
        let cost = serial.refit_by(slot_box, false);
        assert_eq!(cost.to_bits(), parallel.refit_by(slot_box, true).to_bits());
        assert!(serial.nodes == parallel.nodes, "serial and parallel differ");
        assert!(serial.nodes == fresh.nodes, "{} boxes", moved.len());
        serial.validate(moved).unwrap();
        for found in [cost, serial.cost()] {
            let off = (f64::from(found) / expected - 1.0).abs();
            assert!(off < 1e-5, "{found} for {expected}");
        }
    }

    #[test]
    fn no_tree_is_refitted_to_no_tree() {
        let mut tree = Tree::default();
        assert_eq!(tree.refit(|_| Extent::EMPTY), 0.0);
    }
}
