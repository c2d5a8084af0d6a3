//! Cuts a ring of corners into triangles, ear by ear, the first one first.
//!
//! What is cut off is what a plain search would cut off (the first corner that is an ear, in order), but it is not
//! searched for again: a corner whose triangle is not empty waits for one of the points in it to go away, and is
//! looked at again then. Only the two neighbours of a corner that goes, and those who wait for it, change.

use std::collections::BTreeSet;

use glam::DVec2;

use super::near::{Near, turn};

/// What a ring was cut into.
#[derive(Debug, Default, PartialEq)]
pub struct Cut {
    /// By index of corner, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The ring crosses itself: not each triangle was an ear.
    pub is_knot: bool,
    /// What is left of a knot that turns clockwise everywhere, by index of corner.
    pub rest: Vec<u32>,
}

/// Cuts off ear after ear of a counter-clockwise ring of indices into `points`.
pub fn take_ears(points: &[DVec2], ring: &[usize]) -> Cut {
    let turns = |[a, b, c]: [usize; 3]| turn(points[a], points[b], points[c]) > 0.0;
    // Nearly all faces of files are such; the general way comes to the same.
    if let &[a, b, c, d] = ring
        && [[d, a, b], [a, b, c], [b, c, d], [c, d, a]]
            .into_iter()
            .all(turns)
    {
        return Cut {
            triangles: [[d, a, b], [d, b, c]]
                .map(|t| t.map(|corner| corner as u32))
                .to_vec(),
            ..Cut::default()
        };
    }
    Ring::new(points, ring).cut()
}

/// The places of a ring: a corner of the polygon may stand at several.
struct Ring<'a> {
    corners: &'a [usize],
    at: Vec<DVec2>,
    before: Vec<u32>,
    after: Vec<u32>,
    left: usize,
    /// The points of the places, and which of them each place is at.
    near: Near,
    points: Vec<u32>,
    /// Places that enclose nothing any more.
    spent: BTreeSet<u32>,
    /// Places where the ring turns left, and those of them whose triangle is empty.
    convex: BTreeSet<u32>,
    ears: BTreeSet<u32>,
    /// Who waits for a point to go, and for which point one waits.
    waiting: Vec<Vec<u32>>,
    waits_for: Vec<u32>,
}

/// Instead of a point: none.
const NONE: u32 = u32::MAX;

impl<'a> Ring<'a> {
    fn new(points: &[DVec2], corners: &'a [usize]) -> Self {
        let count = corners.len() as u32;
        let at: Vec<DVec2> = corners.iter().map(|&corner| points[corner]).collect();
        let (near, points) = Near::new(&at);
        let mut ring = Self {
            corners,
            near,
            points,
            at,
            before: (0..count).map(|i| (i + count - 1) % count).collect(),
            after: (0..count).map(|i| (i + 1) % count).collect(),
            left: corners.len(),
            spent: BTreeSet::new(),
            convex: BTreeSet::new(),
            ears: BTreeSet::new(),
            waiting: vec![Vec::new(); corners.len()],
            waits_for: vec![NONE; corners.len()],
        };
        for place in 0..count {
            ring.look_at(place);
        }
        ring
    }

    fn cut(mut self) -> Cut {
        let mut cut = Cut {
            triangles: Vec::with_capacity(self.left),
            ..Cut::default()
        };
        while self.left >= 3 {
            if let Some(&place) = self.spent.first() {
                self.remove(place);
                continue;
            }
            let ear = self.ears.first().or_else(|| {
                cut.is_knot = true;
                self.convex.first()
            });
            let Some(&place) = ear else {
                cut.rest = self.rest();
                break;
            };
            let corner = |place: u32| self.corners[place as usize] as u32;
            cut.triangles.push(self.three(place).map(corner));
            self.remove(place);
        }
        cut
    }

    /// A place between its neighbours.
    fn three(&self, place: u32) -> [u32; 3] {
        [
            self.before[place as usize],
            place,
            self.after[place as usize],
        ]
    }

    /// Finds out what a place is.
    fn look_at(&mut self, place: u32) {
        self.forget(place);
        let three = self.three(place).map(|i| self.at[i as usize]);
        let [a, b, c] = three;
        let turn = turn(a, b, c);
        // It is where the next one is, or the ring turns back there.
        if b == c || (turn == 0.0 && a != b && !is_between(a, c, b)) {
            self.spent.insert(place);
        } else if turn > 0.0 {
            self.convex.insert(place);
            match self.near.within(three, place) {
                None => {
                    self.ears.insert(place);
                }
                Some(other) => {
                    self.waits_for[place as usize] = other;
                    self.waiting[other as usize].push(place);
                }
            }
        }
    }

    fn forget(&mut self, place: u32) {
        self.spent.remove(&place);
        self.convex.remove(&place);
        self.ears.remove(&place);
        self.waits_for[place as usize] = NONE;
    }

    fn remove(&mut self, place: u32) {
        self.forget(place);
        let point = self.points[place as usize];
        let is_gone = self.near.remove(point);
        self.left -= 1;
        let [before, _, after] = self.three(place);
        self.after[before as usize] = after;
        self.before[after as usize] = before;
        let freed = match is_gone {
            true => std::mem::take(&mut self.waiting[point as usize]),
            false => Vec::new(),
        };
        for other in freed {
            let is_neighbour = other == before || other == after;
            if self.waits_for[other as usize] == point && !is_neighbour {
                self.look_at(other);
            }
        }
        self.look_at(before);
        self.look_at(after);
    }

    /// The corners that are left, in order.
    fn rest(&self) -> Vec<u32> {
        let is_left = |&place: &usize| self.after[self.before[place] as usize] == place as u32;
        let Some(first) = (0..self.corners.len()).find(is_left) else {
            return Vec::new();
        };
        let next = |&place: &u32| Some(self.after[place as usize]);
        let places = std::iter::successors(Some(first as u32), next).take(self.left);
        places
            .map(|place| self.corners[place as usize] as u32)
            .collect()
    }
}

/// Whether a point of the line through a and b lies between them, neither's place included.
pub fn is_between(a: DVec2, b: DVec2, p: DVec2) -> bool {
    let axis = usize::from((b - a).abs().y > (b - a).abs().x);
    (a[axis] < p[axis] && p[axis] < b[axis]) || (b[axis] < p[axis] && p[axis] < a[axis])
}
