//! Ear clipping of polygons in the plane, with exact predicates.
//!
//! Method: Eberly, "Triangulation by Ear Clipping" (2002); orientations after Shewchuk, "Adaptive Precision
//! Floating-Point Arithmetic and Fast Robust Geometric Predicates" (1997), so no triangle is turned over or left out
//! by rounding. Corners on a straight edge stay corners of triangles: a neighbour that shares them fits without a gap.
//! Ears are taken in order of corners, so a polygon that deforms keeps its triangles until one of them would turn over.
//!
//! Trees over corners and edges ([`super::near`], [`super::edges`]) keep tens of thousands of corners a matter of a
//! fraction of a second.

use std::ops::Range;

use glam::DVec2;

use super::ears::{Cut, take_ears};
use super::edges::Edges;
use super::near::turn;

/// Nearest corners that are tried at first for the line to a hole.
const NEAREST: usize = 8;

/// What a polygon is cut into. `loops[0]` is the outer loop, the others are holes in it, each a range of points in
/// either winding. Loops that cross themselves or each other are covered in part.
pub fn clip(points: &[DVec2], loops: &[Range<usize>]) -> Cut {
    let mut rings = loops.iter().enumerate().map(|(i, corners)| {
        let mut ring: Vec<usize> = corners.clone().collect();
        if (area(points, &ring) < 0.0) != (i > 0) {
            ring.reverse();
        }
        ring
    });
    let mut ring = rings.next().unwrap_or_default();
    let mut holes: Vec<Vec<usize>> = rings.collect();
    if !holes.is_empty() {
        for hole in &mut holes {
            let rightmost =
                |&a: &usize, &b: &usize| points[hole[a]].x.total_cmp(&points[hole[b]].x);
            let first = (0..hole.len()).max_by(rightmost).unwrap_or(0);
            hole.rotate_left(first);
        }
        holes.sort_by(|a, b| points[b[0]].x.total_cmp(&points[a[0]].x));
        let mut edges = Edges::new(points, loops);
        for hole in &holes {
            open(points, &mut ring, hole, &mut edges);
        }
    }
    take_ears(points, &ring)
}

/// Twice the area of a ring, positive if it is counter-clockwise.
fn area(points: &[DVec2], ring: &[usize]) -> f64 {
    let Some(&first) = ring.first() else {
        return 0.0;
    };
    let from = points[first];
    let next = ring.iter().cycle().skip(1);
    let cross = |(&a, &b): (&usize, &usize)| (points[a] - from).perp_dot(points[b] - from);
    ring.iter().zip(next).map(cross).sum()
}

/// Joins a hole to the ring along the shortest line that meets no edge, there and back.
fn open(points: &[DVec2], ring: &mut Vec<usize>, hole: &[usize], edges: &mut Edges) {
    let from = hole[0];
    let distance = |&i: &usize| points[ring[i]].distance_squared(points[from]);
    let nearer = |a: &usize, b: &usize| distance(a).total_cmp(&distance(b)).then(a.cmp(b));
    let mut places: Vec<usize> = (0..ring.len()).collect();
    let (mut tried, mut place) = (0, None);
    while tried < places.len() && place.is_none() {
        // Most holes see one of the nearest corners: the others need not be sorted.
        let rest = &mut places[tried..];
        let count = rest.len().min(NEAREST.max(tried * 3));
        if count < rest.len() {
            rest.select_nth_unstable_by(count - 1, nearer);
        }
        rest[..count].sort_unstable_by(nearer);
        let mut nearest = rest[..count].iter().copied();
        place =
            nearest.find(|&i| opens_inward(points, ring, i, from) && edges.let_see(ring[i], from));
        tried += count;
    }
    let place = place.unwrap_or(places[0]);
    edges.add([from, ring[place]]);
    let there_and_back = hole.iter().copied().chain([from, ring[place]]);
    ring.splice(place + 1..place + 1, there_and_back.collect::<Vec<_>>());
}

/// Whether the line from a corner of the ring to a point begins inside the ring.
fn opens_inward(points: &[DVec2], ring: &[usize], place: usize, to: usize) -> bool {
    let count = ring.len();
    let before = points[ring[(place + count - 1) % count]];
    let (at, after) = (points[ring[place]], points[ring[(place + 1) % count]]);
    let to = points[to];
    let (left, right) = (turn(before, at, to), turn(at, after, to));
    if turn(before, at, after) > 0.0 {
        left > 0.0 && right > 0.0
    } else {
        left > 0.0 || right > 0.0
    }
}
