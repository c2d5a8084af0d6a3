//! A binary tree over boxes, quickly: parallel locally-ordered clustering on the Morton order (Meister and
//! Bittner 2018), laid out so that the search for neighbours runs in vector registers.
//!
//! The order is cut into segments that are clustered on their own until few clusters are left, then what
//! is left of all of them together. Segments depend on the number of boxes alone, so the tree does not
//! depend on threads. [`super::fast`] makes four-wide nodes of it.

use glam::{Mat4, Vec3A};
use rayon::prelude::*;

use super::Extent;
use super::morton::MortonSort;

/// Neighbours on either side among which a cluster looks for the best to merge with.
const REACH: usize = 8;
/// Most boxes of a segment.
const SEGMENT: usize = 4096;
/// A segment is left to the common end when its clusters are fewer than its boxes by this factor.
const SEGMENT_END: usize = 16;
/// Boxes from which more than one thread is worth waking.
const PARALLEL_FROM: usize = 20_000;

/// A binary tree. Nodes below the number of boxes are leaves: boxes in Morton order.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    sort: MortonSort,
    /// Of each leaf: the number of its box.
    pub order: Vec<u32>,
    /// The box of every node. Of inner nodes there may be unused ones.
    pub boxes: Vec<Extent>,
    /// Of inner nodes, the first of which has the number of boxes as its number.
    pub children: Vec<[u32; 2]>,
    segments: Vec<Segment>,
    top: Segment,
}

/// Clusters that wait for being merged, in order: their boxes, also one coordinate a list, and nodes.
#[derive(Clone, Debug, Default)]
struct Segment {
    boxes: Vec<Extent>,
    nodes: Vec<u32>,
    sides: [Vec<f32>; 6],
    /// The best [`pair_key`] with a cluster behind.
    ahead: Vec<f32>,
    /// The best [`pair_key`] with a cluster before.
    back: Vec<f32>,
    /// How far away the best of both is.
    offset: Vec<i32>,
}

impl Clusters {
    /// The tree over at least one box; the number of its root.
    pub fn build(&mut self, boxes: &[Extent]) -> u32 {
        let count = boxes.len();
        self.order.clear();
        self.order.extend(self.sort.sort(boxes));
        let in_order = self.order.iter().map(|&i| boxes[i as usize]);
        self.boxes.clear();
        self.boxes.extend(in_order);
        self.boxes.resize(2 * count, Extent::EMPTY);
        self.children.clear();
        self.children.resize(count, [0; 2]);
        let parts = count.div_ceil(SEGMENT);
        let each = count.div_ceil(parts);
        let end = if parts == 1 { 1 } else { each / SEGMENT_END };
        self.segments.resize(parts, Segment::default());
        let mut tasks = self.tasks(each);
        if count >= PARALLEL_FROM {
            tasks.par_iter_mut().for_each(|task| task.run(end));
        } else {
            tasks.iter_mut().for_each(|task| task.run(end));
        }
        match &self.segments[..] {
            [all] => all.nodes[0],
            _ => self.join(),
        }
    }

    /// Cuts the boxes into segments of so many.
    fn tasks(&mut self, each: usize) -> Vec<Task<'_>> {
        let count = self.order.len();
        let (leaves, inner) = self.boxes.split_at_mut(count);
        let boxes = inner.chunks_mut(each);
        let children = self.children.chunks_mut(each);
        let parts = self.segments.iter_mut().zip(leaves.chunks(each));
        let task = |(part, (((segment, leaves), boxes), children))| {
            let first = (part * each) as u32;
            let base = count as u32 + first;
            Task {
                segment,
                leaves,
                first,
                out: Output {
                    boxes,
                    children,
                    base,
                    used: 0,
                },
            }
        };
        parts
            .zip(boxes)
            .zip(children)
            .enumerate()
            .map(task)
            .collect()
    }

    /// Merges what the segments have left.
    fn join(&mut self) -> u32 {
        let base = self.boxes.len();
        self.top.boxes.clear();
        self.top.nodes.clear();
        for segment in &self.segments {
            self.top.boxes.extend_from_slice(&segment.boxes);
            self.top.nodes.extend_from_slice(&segment.nodes);
        }
        let left = self.top.nodes.len();
        self.boxes.resize(base + left, Extent::EMPTY);
        let children = self.children.len();
        self.children.resize(children + left, [0; 2]);
        let mut out = Output {
            boxes: &mut self.boxes[base..],
            children: &mut self.children[children..],
            base: base as u32,
            used: 0,
        };
        self.top.merge_down_to(1, &mut out);
        self.top.nodes[0]
    }
}

/// The clustering of one segment.
struct Task<'a> {
    segment: &'a mut Segment,
    leaves: &'a [Extent],
    /// The node that the first leaf is.
    first: u32,
    out: Output<'a>,
}

impl Task<'_> {
    fn run(&mut self, end: usize) {
        self.segment.boxes.clear();
        self.segment.boxes.extend_from_slice(self.leaves);
        self.segment.nodes.clear();
        let end_of_leaves = self.first + self.leaves.len() as u32;
        self.segment.nodes.extend(self.first..end_of_leaves);
        self.segment.merge_down_to(end, &mut self.out);
    }
}

/// Where a segment puts inner nodes.
struct Output<'a> {
    boxes: &'a mut [Extent],
    children: &'a mut [[u32; 2]],
    base: u32,
    used: usize,
}

impl Segment {
    fn merge_down_to(&mut self, end: usize, out: &mut Output) {
        while self.nodes.len() > end.max(1) {
            self.find_neighbours();
            let before = self.nodes.len();
            self.merge(out);
            // Nested boxes, say: few agree on whom to merge with. Then the order alone decides once.
            if (before - self.nodes.len()) * 8 < before && self.nodes.len() > end.max(1) {
                self.pair_up();
                self.merge(out);
            }
        }
    }

    /// Finds for every cluster the neighbour with which its union is smallest.
    fn find_neighbours(&mut self) {
        self.spread();
        let count = self.nodes.len();
        for keys in [&mut self.ahead, &mut self.back] {
            keys.clear();
            keys.resize(count, f32::INFINITY);
        }
        for distance in 1..=REACH.min(count - 1) {
            let pairs = count - distance;
            let (ahead, back) = (&mut self.ahead[..pairs], &mut self.back[distance..]);
            try_pairs(&self.sides, distance, ahead, back);
        }
        self.offset.resize(count, 0);
        let keys = self.ahead.iter().zip(&self.back);
        for (offset, (&ahead, &back)) in self.offset.iter_mut().zip(keys) {
            let way = if ahead <= back { 1 } else { -1 };
            let key = less(ahead, back);
            let found = if key < f32::INFINITY { 1 } else { 0 };
            *offset = way * found * distance_of(key);
        }
    }

    /// Takes the next in the list as everyone's best neighbour.
    fn pair_up(&mut self) {
        let count = self.nodes.len();
        for (i, offset) in self.offset[..count].iter_mut().enumerate() {
            *offset = match i % 2 {
                1 => -1,
                _ if i + 1 < count => 1,
                _ => 0,
            };
        }
    }

    /// Merges those that are each other's best neighbour, the others move up.
    fn merge(&mut self, out: &mut Output) {
        let count = self.nodes.len();
        let (boxes, nodes) = (&mut self.boxes[..count], &mut self.nodes[..count]);
        let offsets = &self.offset[..count];
        let mut kept = 0;
        for i in 0..count {
            let other = i.wrapping_add_signed(offsets[i] as isize);
            let (mut b, mut node) = (boxes[i], nodes[i]);
            if other != i && offsets[other] == -offsets[i] {
                if other < i {
                    continue;
                }
                b = b.union(boxes[other]);
                node = out.add(b, [node, nodes[other]]);
            }
            (boxes[kept], nodes[kept]) = (b, node);
            kept += 1;
        }
        self.boxes.truncate(kept);
        self.nodes.truncate(kept);
    }

    /// Lays the boxes out one coordinate a list, with room for whole registers.
    fn spread(&mut self) {
        let padded = self.boxes.len().next_multiple_of(4);
        self.sides
            .iter_mut()
            .for_each(|side| side.resize(padded, 0.0));
        let [min_x, min_y, min_z, max_x, max_y, max_z] =
            self.sides.each_mut().map(|side| side.chunks_exact_mut(4));
        let mins = min_x.zip(min_y).zip(min_z);
        let maxs = max_x.zip(max_y).zip(max_z);
        let last = *self.boxes.last().unwrap_or(&Extent::EMPTY);
        for ((boxes, ((min_x, min_y), min_z)), ((max_x, max_y), max_z)) in
            self.boxes.chunks(4).zip(mins).zip(maxs)
        {
            let of = |i: usize| *boxes.get(i).unwrap_or(&last);
            let [a, b, c, d] = [of(0), of(1), of(2), of(3)];
            let min = rows(a.min, b.min, c.min, d.min);
            let max = rows(a.max, b.max, c.max, d.max);
            min.x_axis.write_to_slice(min_x);
            min.y_axis.write_to_slice(min_y);
            min.z_axis.write_to_slice(min_z);
            max.x_axis.write_to_slice(max_x);
            max.y_axis.write_to_slice(max_y);
            max.z_axis.write_to_slice(max_z);
        }
    }
}

/// Four points, one coordinate a column.
fn rows(a: Vec3A, b: Vec3A, c: Vec3A, d: Vec3A) -> Mat4 {
    let [a, b, c, d] = [a.extend(0.0), b.extend(0.0), c.extend(0.0), d.extend(0.0)];
    Mat4::from_cols(a, b, c, d).transpose()
}

impl Output<'_> {
    /// The number of a new node.
    #[inline]
    fn add(&mut self, b: Extent, children: [u32; 2]) -> u32 {
        self.boxes[self.used] = b;
        self.children[self.used] = children;
        self.used += 1;
        self.base + self.used as u32 - 1
    }
}

/// Tries each cluster with the one so far behind it.
fn try_pairs(sides: &[Vec<f32>; 6], distance: usize, ahead: &mut [f32], back: &mut [f32]) {
    let pairs = ahead.len();
    let back = &mut back[..pairs];
    let [a_min_x, a_min_y, a_min_z, a_max_x, a_max_y, a_max_z] =
        sides.each_ref().map(|side| &side[..pairs]);
    let [b_min_x, b_min_y, b_min_z, b_max_x, b_max_y, b_max_z] = sides
        .each_ref()
        .map(|side| &side[distance..distance + pairs]);
    for i in 0..pairs {
        let x = more(a_max_x[i], b_max_x[i]) - less(a_min_x[i], b_min_x[i]);
        let y = more(a_max_y[i], b_max_y[i]) - less(a_min_y[i], b_min_y[i]);
        let z = more(a_max_z[i], b_max_z[i]) - less(a_min_z[i], b_min_z[i]);
        let key = pair_key(x * y + y * z + z * x, distance, i);
        ahead[i] = less(key, ahead[i]);
        back[i] = less(key, back[i]);
    }
}

/// Orders pairs by the area of their union, and in the lowest bits says how far apart they are. Of equals
/// (boxes in rows, or the same many times) the nearest wins, then the even one with its successor: the same
/// on both sides, so that many agree.
#[inline]
fn pair_key(area: f32, distance: usize, first: usize) -> f32 {
    let code = (distance as u32 - 1) << 1 | (first as u32 & 1);
    f32::from_bits(area.to_bits() & !(2 * REACH as u32 - 1) | code)
}

/// The distance in a [`pair_key`].
fn distance_of(key: f32) -> i32 {
    (key.to_bits() >> 1 & (REACH as u32 - 1)) as i32 + 1
}

/// `a` if it is less; so an `a` that is no number is left out, and it is one instruction.
#[inline]
fn less(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn more(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
