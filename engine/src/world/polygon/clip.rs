//! Ear clipping of polygons in the plane, with exact predicates.
//!
//! Method: Eberly, "Triangulation by Ear Clipping" (2002); orientations after Shewchuk, "Adaptive Precision
//! Floating-Point Arithmetic and Fast Robust Geometric Predicates" (1997), so no triangle is turned over or left out
//! by rounding. Corners on a straight edge stay corners of triangles: a neighbour that shares them fits without a gap.
//! Ears are taken in order of corners, so a polygon that deforms keeps its triangles until one of them would turn over.
//!
//! Time grows with the square of the number of corners where ears are easily found, with its cube at worst.

use std::ops::Range;

use glam::DVec2;
use robust::{Coord, orient2d};

/// Triangles, by index into `points`, counter-clockwise. `loops[0]` is the outer loop, the others are holes in it, each a
/// range of points in either winding. Loops that cross themselves or each other are covered in part.
pub(super) fn clip(points: &[DVec2], loops: &[Range<usize>]) -> Vec<[u32; 3]> {
    let clipper = Clipper { points };
    let mut rings = loops.iter().enumerate().map(|(i, corners)| {
        let mut ring: Vec<usize> = corners.clone().collect();
        if (clipper.area(&ring) < 0.0) != (i > 0) {
            ring.reverse();
        }
        ring
    });
    let mut ring = rings.next().unwrap_or_default();
    let mut holes: Vec<Vec<usize>> = rings.collect();
    for hole in &mut holes {
        let rightmost = |&a: &usize, &b: &usize| points[hole[a]].x.total_cmp(&points[hole[b]].x);
        let first = (0..hole.len()).max_by(rightmost).unwrap_or(0);
        hole.rotate_left(first);
    }
    holes.sort_by(|a, b| points[b[0]].x.total_cmp(&points[a[0]].x));
    for i in 0..holes.len() {
        clipper.open(&mut ring, &holes[i..]);
    }
    clipper.take_ears(ring)
}

struct Clipper<'a> {
    points: &'a [DVec2],
}

impl Clipper<'_> {
    /// Positive where a, b, c turn counter-clockwise; zero on a line, exactly.
    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| Coord {
            x: self.points[i].x,
            y: self.points[i].y,
        });
        orient2d(a, b, c)
    }

    /// Twice the area of a ring, positive if it is counter-clockwise.
    fn area(&self, ring: &[usize]) -> f64 {
        let Some(&first) = ring.first() else {
            return 0.0;
        };
        let from = self.points[first];
        let next = ring.iter().cycle().skip(1);
        let cross =
            |(&a, &b): (&usize, &usize)| (self.points[a] - from).perp_dot(self.points[b] - from);
        ring.iter().zip(next).map(cross).sum()
    }

    /// Joins the first of `holes` to the ring along the shortest line that meets no edge, there and back.
    fn open(&self, ring: &mut Vec<usize>, holes: &[Vec<usize>]) {
        let hole = &holes[0];
        let from = hole[0];
        let mut places: Vec<usize> = (0..ring.len()).collect();
        let distance = |&i: &usize| self.points[ring[i]].distance_squared(self.points[from]);
        places.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let place = places
            .iter()
            .copied()
            .find(|&i| self.opens_inward(ring, i, from) && self.sees(ring[i], from, ring, holes))
            .unwrap_or(places[0]);
        let there_and_back = hole.iter().copied().chain([from, ring[place]]);
        ring.splice(place + 1..place + 1, there_and_back.collect::<Vec<_>>());
    }

    /// Whether the line from a corner of the ring to a point begins inside the ring.
    fn opens_inward(&self, ring: &[usize], place: usize, to: usize) -> bool {
        let count = ring.len();
        let (before, at, after) = (
            ring[(place + count - 1) % count],
            ring[place],
            ring[(place + 1) % count],
        );
        let (left, right) = (self.turn(before, at, to), self.turn(at, after, to));
        if self.turn(before, at, after) > 0.0 {
            left > 0.0 && right > 0.0
        } else {
            left > 0.0 || right > 0.0
        }
    }

    /// Whether the open line between two corners meets no edge.
    fn sees(&self, a: usize, b: usize, ring: &[usize], holes: &[Vec<usize>]) -> bool {
        let rings = holes.iter().map(Vec::as_slice).chain([ring]);
        rings.into_iter().all(|ring| {
            let next = ring.iter().cycle().skip(1);
            let mut edges = ring.iter().zip(next);
            edges.all(|(&c, &d)| !self.is_cut(a, b, c, d))
        })
    }

    /// Whether the edge from c to d cuts or touches the open line from a to b.
    fn is_cut(&self, a: usize, b: usize, c: usize, d: usize) -> bool {
        let (side_c, side_d) = (self.turn(a, b, c), self.turn(a, b, d));
        let are_apart = |a: f64, b: f64| (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0);
        if are_apart(side_c, side_d) {
            return false;
        }
        let on_line = |side: f64, p: usize| side == 0.0 && self.is_between(a, b, p);
        if on_line(side_c, c) || on_line(side_d, d) {
            return true;
        }
        let is_end = |p: usize| [a, b].iter().any(|&q| self.points[p] == self.points[q]);
        if side_c == 0.0 || side_d == 0.0 || is_end(c) || is_end(d) {
            return false;
        }
        !are_apart(self.turn(c, d, a), self.turn(c, d, b))
    }

    /// Whether a point of the line through a and b lies between them, neither's place included.
    fn is_between(&self, a: usize, b: usize, p: usize) -> bool {
        let [a, b, p] = [a, b, p].map(|i| self.points[i]);
        let axis = usize::from((b - a).abs().y > (b - a).abs().x);
        (a[axis] < p[axis] && p[axis] < b[axis]) || (b[axis] < p[axis] && p[axis] < a[axis])
    }

    /// Cuts off ear after ear, the first one first.
    fn take_ears(&self, mut ring: Vec<usize>) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(ring.len());
        while ring.len() >= 3 {
            let count = ring.len();
            let three = |i: usize| {
                [
                    ring[(i + count - 1) % count],
                    ring[i],
                    ring[(i + 1) % count],
                ]
            };
            if let Some(i) = (0..count).find(|&i| self.is_spent(three(i))) {
                ring.remove(i);
                continue;
            }
            let turns = |i: usize| {
                let [a, b, c] = three(i);
                self.turn(a, b, c) > 0.0
            };
            let ear = (0..count).find(|&i| turns(i) && self.is_empty(three(i), &ring));
            // A ring that crosses itself may have no ear; what is left without one is a line or a knot.
            let Some(i) = ear.or_else(|| (0..count).find(|&i| turns(i))) else {
                break;
            };
            triangles.push(three(i).map(|corner| corner as u32));
            ring.remove(i);
        }
        triangles
    }

    /// Whether a corner encloses nothing any more: it is where the next one is, or the ring turns back there.
    fn is_spent(&self, [a, b, c]: [usize; 3]) -> bool {
        let is_at = |p: usize, q: usize| self.points[p] == self.points[q];
        is_at(b, c) || (self.turn(a, b, c) == 0.0 && !is_at(a, b) && !self.is_between(a, c, b))
    }

    /// Whether no corner of the ring lies in a triangle or on its edges, corners at its corners' places aside.
    fn is_empty(&self, [a, b, c]: [usize; 3], ring: &[usize]) -> bool {
        let corners = [a, b, c].map(|i| self.points[i]);
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        ring.iter().all(|&p| {
            let at = self.points[p];
            let is_near = at.cmpge(low).all() && at.cmple(high).all();
            !is_near
                || corners.contains(&at)
                || self.turn(a, b, p) < 0.0
                || self.turn(b, c, p) < 0.0
                || self.turn(c, a, p) < 0.0
        })
    }
}
