//! Whether one corner sees another: a tree of boxes over the edges of a polygon.
//!
//! Used by [`super::clip`], which joins holes to the outer loop along lines that meet no edge.

use std::ops::Range;

use glam::DVec2;

use super::ears::is_between;
use super::near::turn;

/// Edges of a leaf.
const LEAF: usize = 4;

/// Edges between points.
pub struct Edges<'a> {
    points: &'a [DVec2],
    /// Those of a box one after another.
    edges: Vec<[usize; 2]>,
    /// Children of box `k` are `2 k + 1` and `2 k + 2`.
    boxes: Vec<[DVec2; 2]>,
    /// Those that came later.
    more: Vec<[usize; 2]>,
}

impl<'a> Edges<'a> {
    /// The edges of closed loops.
    pub fn new(points: &'a [DVec2], loops: &[Range<usize>]) -> Self {
        let of_loop = |corners: &Range<usize>| {
            let next = corners.clone().cycle().skip(1);
            corners
                .clone()
                .zip(next)
                .map(|(a, b)| [a, b])
                .collect::<Vec<_>>()
        };
        let edges: Vec<[usize; 2]> = loops.iter().flat_map(of_loop).collect();
        let leaves = edges.len().div_ceil(LEAF).next_power_of_two();
        let mut tree = Self {
            points,
            boxes: vec![[DVec2::INFINITY, DVec2::NEG_INFINITY]; 2 * leaves],
            edges,
            more: Vec::new(),
        };
        tree.build(0, 0..tree.edges.len());
        tree
    }

    fn build(&mut self, number: usize, part: Range<usize>) {
        let points = self.points;
        let edges = &mut self.edges[part.clone()];
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &point in edges.iter().flatten() {
            low = low.min(points[point]);
            high = high.max(points[point]);
        }
        self.boxes[number] = [low, high];
        if part.len() > LEAF {
            let axis = usize::from((high - low).y > (high - low).x);
            let along = |&[a, b]: &[usize; 2]| points[a][axis] + points[b][axis];
            let half = edges.len() / 2;
            edges.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
            let middle = part.start + half;
            self.build(2 * number + 1, part.start..middle);
            self.build(2 * number + 2, middle..part.end);
        }
    }

    /// One edge more.
    pub fn add(&mut self, edge: [usize; 2]) {
        self.more.push(edge);
    }

    /// Whether the open line between two corners meets no edge.
    pub fn let_see(&self, a: usize, b: usize) -> bool {
        let (low, high) = (
            self.points[a].min(self.points[b]),
            self.points[a].max(self.points[b]),
        );
        let cuts = |&[c, d]: &[usize; 2]| self.is_cut(a, b, c, d);
        if self.more.iter().any(cuts) {
            return false;
        }
        let mut parts = vec![(0, 0..self.edges.len())];
        while let Some((number, part)) = parts.pop() {
            let [least, most] = self.boxes[number];
            if least.cmpgt(high).any() || most.cmplt(low).any() {
                continue;
            }
            if part.len() > LEAF {
                let middle = part.start + part.len() / 2;
                parts.push((2 * number + 1, part.start..middle));
                parts.push((2 * number + 2, middle..part.end));
            } else if self.edges[part].iter().any(cuts) {
                return false;
            }
        }
        true
    }

    /// Whether the edge from c to d cuts or touches the open line from a to b.
    fn is_cut(&self, a: usize, b: usize, c: usize, d: usize) -> bool {
        let [a, b, c, d] = [a, b, c, d].map(|i| self.points[i]);
        let (side_c, side_d) = (turn(a, b, c), turn(a, b, d));
        let are_apart = |a: f64, b: f64| (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0);
        if are_apart(side_c, side_d) {
            return false;
        }
        let on_line = |side: f64, p: DVec2| side == 0.0 && is_between(a, b, p);
        if on_line(side_c, c) || on_line(side_d, d) {
            return true;
        }
        let is_end = |p: DVec2| p == a || p == b;
        if side_c == 0.0 || side_d == 0.0 || is_end(c) || is_end(d) {
            return false;
        }
        !are_apart(turn(c, d, a), turn(c, d, b))
    }
}
