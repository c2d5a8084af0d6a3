//! Which of many points lies in a triangle: a tree of boxes over points that are only ever taken away.
//!
//! Used by [`super::ears`]. A k-d tree (Bentley 1975) split at medians, so that neither clusters nor thin triangles
//! make it look at more than a few boxes where there is nothing; boxes beyond an edge of the triangle are left aside by the
//! edge's own line, not only by the triangle's box.

use std::collections::HashMap;

use glam::DVec2;
use robust::{Coord, orient2d};

/// Points of a leaf.
const LEAF: usize = 8;

/// Points that are still there, by number. No two are at one place: what lies there more than once is counted.
pub struct Near {
    points: Vec<DVec2>,
    /// How often each is still there.
    counts: Vec<u32>,
    /// Numbers of the points, those of a box one after another.
    order: Vec<u32>,
    /// Where in `order` a point is.
    slots: Vec<u32>,
    /// Children of box `k` are `2 k + 1` and `2 k + 2`.
    boxes: Vec<Bounds>,
}

#[derive(Clone, Copy)]
struct Bounds {
    low: DVec2,
    high: DVec2,
    /// Points that are still there.
    here: u32,
}

/// A box on the way down: its number, and its part of [`Near::order`].
type Step = (usize, usize, usize);

impl Near {
    /// The places of these points, and which place each of them has.
    pub fn new(all: &[DVec2]) -> (Self, Vec<u32>) {
        let (mut points, mut counts) = (Vec::new(), Vec::new());
        let mut numbers = HashMap::with_capacity(all.len());
        let places = all.iter().map(|&at| {
            // Adding zero makes -0 and 0 the same place.
            let bits = (at + DVec2::ZERO).to_array().map(f64::to_bits);
            let place = *numbers.entry(bits).or_insert_with(|| {
                points.push(at);
                counts.push(0);
                points.len() as u32 - 1
            });
            counts[place as usize] += 1;
            place
        });
        let places: Vec<u32> = places.collect();
        (Self::of_places(points, counts), places)
    }

    fn of_places(points: Vec<DVec2>, counts: Vec<u32>) -> Self {
        let count = points.len();
        let empty = Bounds {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
            here: 0,
        };
        let leaves = count.div_ceil(LEAF).next_power_of_two();
        let mut near = Self {
            points,
            counts,
            order: (0..count as u32).collect(),
            slots: vec![0; count],
            boxes: vec![empty; 2 * leaves],
        };
        near.build((0, 0, count));
        for (slot, &point) in near.order.iter().enumerate() {
            near.slots[point as usize] = slot as u32;
        }
        near
    }

    fn build(&mut self, (number, start, end): Step) {
        let points = &self.points;
        let part = &mut self.order[start..end];
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &point in part.iter() {
            low = low.min(points[point as usize]);
            high = high.max(points[point as usize]);
        }
        self.boxes[number] = Bounds {
            low,
            high,
            here: part.len() as u32,
        };
        if let Some((left, right)) = halves((number, start, end)) {
            let axis = usize::from((high - low).y > (high - low).x);
            let along = |&point: &u32| points[point as usize][axis];
            part.select_nth_unstable_by(left.2 - start, |a, b| along(a).total_cmp(&along(b)));
            self.build(left);
            self.build(right);
        }
    }

    /// Takes away one of those at a place, and says whether it was the last one.
    pub fn remove(&mut self, point: u32) -> bool {
        self.counts[point as usize] -= 1;
        if self.counts[point as usize] > 0 {
            return false;
        }
        let slot = self.slots[point as usize] as usize;
        let mut step = (0, 0, self.order.len());
        loop {
            self.boxes[step.0].here -= 1;
            let Some((left, right)) = halves(step) else {
                return true;
            };
            step = if slot < left.2 { left } else { right };
        }
    }

    /// A point in a counter-clockwise triangle or on its edges, points at its corners' places aside.
    ///
    /// Which one depends on `seed`, as by chance: those who wait for it to go away wait for all in the triangle to go,
    /// and with points drawn at random there are few to wait for one after another.
    pub fn within(&self, corners: [DVec2; 3], seed: u32) -> Option<u32> {
        let mut steps: Vec<Step> = vec![(0, 0, self.order.len())];
        while let Some(step) = steps.pop() {
            let (number, start, end) = step;
            if !self.boxes[number].meets(corners) {
                continue;
            }
            let is_odd = (number as u32 ^ seed).wrapping_mul(0x9E37_79B9) >> 31 == 1;
            if let Some((left, right)) = halves(step) {
                steps.extend(if is_odd { [left, right] } else { [right, left] });
                continue;
            }
            let part = &self.order[start..end];
            let holds = |&&point: &&u32| {
                self.counts[point as usize] > 0 && encloses(corners, self.points[point as usize])
            };
            let found = match is_odd {
                true => part.iter().rev().find(holds),
                false => part.iter().find(holds),
            };
            if let Some(&point) = found {
                return Some(point);
            }
        }
        None
    }
}

/// The two parts of a box; none: it is a leaf.
fn halves((number, start, end): Step) -> Option<(Step, Step)> {
    let middle = start + (end - start) / 2;
    let is_leaf = end - start <= LEAF;
    (!is_leaf).then(|| {
        (
            (2 * number + 1, start, middle),
            (2 * number + 2, middle, end),
        )
    })
}

impl Bounds {
    /// Whether a point of it may be in the triangle.
    fn meets(&self, corners: [DVec2; 3]) -> bool {
        let [a, b, c] = corners;
        let apart = self.here == 0
            || self.low.cmpgt(a.max(b).max(c)).any()
            || self.high.cmplt(a.min(b).min(c)).any();
        !apart
            && [(a, b), (b, c), (c, a)]
                .iter()
                .all(|&(a, b)| self.is_left(a, b))
    }

    /// Whether a point of it may be on the line from a to b or left of it. Rounding errs towards yes.
    fn is_left(&self, a: DVec2, b: DVec2) -> bool {
        let along = b - a;
        let leftmost = DVec2::new(
            if along.y > 0.0 {
                self.low.x
            } else {
                self.high.x
            },
            if along.x > 0.0 {
                self.high.y
            } else {
                self.low.y
            },
        );
        let to = leftmost - a;
        let (plus, minus) = (along.x * to.y, along.y * to.x);
        !(plus - minus < -1e-15 * (plus.abs() + minus.abs()))
    }
}

/// Whether a point lies in a counter-clockwise triangle or on its edges, but not where a corner is. Exact.
pub fn encloses(corners: [DVec2; 3], at: DVec2) -> bool {
    let [a, b, c] = corners;
    let is_near = at.cmpge(a.min(b).min(c)).all() && at.cmple(a.max(b).max(c)).all();
    let left = |a: DVec2, b: DVec2| !(turn(a, b, at) < 0.0);
    is_near && !corners.contains(&at) && left(a, b) && left(b, c) && left(c, a)
}

/// Positive where a, b, c turn counter-clockwise; zero on a line, exactly.
pub fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

    #[test]
    fn a_point_is_found_where_there_is_one() {
        let random = &mut Random(7);
        for round in 0..200 {
            let count = 1 + (random.unit() * 100.0) as usize;
            // At whole numbers many lie on edges and at corners.
            let coarse = if round % 2 == 0 { 8.0 } else { 1e9 };
            let mut point = || (DVec2::new(random.unit(), random.unit()) * coarse).floor();
            let all: Vec<DVec2> = (0..count).map(|_| point()).collect();
            let (mut near, places) = Near::new(&all);
            for (gone, &place) in places.iter().enumerate() {
                let left = &places[gone..];
                for _ in 0..5 {
                    let [a, b, c] = [point(), point(), point()];
                    let corners = match turn(a, b, c) > 0.0 {
                        true => [a, b, c],
                        false => [a, c, b],
                    };
                    let inside = |i: &u32| encloses(corners, near.points[*i as usize]);
                    let found = near.within(corners, gone as u32);
                    assert!(
                        found.is_none_or(|i| left.contains(&i) && inside(&i)),
                        "{found:?}"
                    );
                    let any = left.iter().any(inside);
                    assert_eq!(found.is_some(), any, "round {round}");
                }
                assert_eq!(near.remove(place), !left[1..].contains(&place));
            }
        }
    }
}
