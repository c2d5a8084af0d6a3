//! Motion along a line of points.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::{DQuat, DVec3};

use super::{Rest, release};
use crate::world::{Transform, turn};

/// Travels along points, an equal time from each to the next; open paths lead there and back in a period.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Rest)]
#[component(summary_tick, on_remove = release)]
pub struct PathMotion {
    /// From the rest position, in the parent's space; none: no motion.
    pub points: Vec<DVec3>,
    /// Seconds a round; negative runs the other way, 0 stands still.
    pub period: f64,
    /// Share of a round that is behind it at time 0.
    pub start: f64,
    /// Whether the last point leads to the first again.
    pub closed: bool,
    /// A Catmull-Rom curve through the points (Catmull and Rom 1974); else straight lines.
    pub smooth: bool,
    /// Whether the rest pose's -Z is turned to where it goes, with +Y up.
    pub look_along: bool,
}

impl Default for PathMotion {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            period: 1.0,
            start: 0.0,
            closed: true,
            smooth: true,
            look_along: false,
        }
    }
}

impl PathMotion {
    /// Position from the rest position at a time in seconds, and the turn to where it goes.
    pub fn at(&self, secs: f64) -> (DVec3, Option<DQuat>) {
        if self.points.is_empty() {
            return (DVec3::ZERO, None);
        }
        let share = (turn(secs, self.period) + self.start).rem_euclid(1.0);
        let count = self.points.len() - usize::from(!self.closed);
        let (way, ahead) = if self.closed {
            (share, 1.0)
        } else if share < 0.5 {
            (2.0 * share, 1.0)
        } else {
            (2.0 - 2.0 * share, -1.0)
        };
        let place = way * count as f64;
        let segment = (place as usize).min(count.saturating_sub(1));
        let (position, direction) = self.segment(segment, place - segment as f64);
        let look = self.look_along.then(|| {
            let ahead = direction * (ahead * self.period.signum());
            Transform::looking_at(DVec3::ZERO, ahead, DVec3::Y).rotation
        });
        (position, look)
    }

    /// Position and derivative on the way from a point to the next.
    pub(super) fn segment(&self, first: usize, t: f64) -> (DVec3, DVec3) {
        let points = &self.points;
        let (count, last) = (points.len(), points.len() - 1);
        let [b, c] =
            [first, first + 1].map(|i| points[if self.closed { i % count } else { i.min(last) }]);
        if !self.smooth {
            return (b.lerp(c, t), c - b);
        }
        // Beyond the ends of an open path the line goes on straight.
        let a = match first.checked_sub(1) {
            Some(before) => points[before],
            None if self.closed => points[last],
            None => b * 2.0 - c,
        };
        let d = match points.get(first + 2) {
            Some(&after) => after,
            None if self.closed => points[(first + 2) % count],
            None => c * 2.0 - b,
        };
        let linear = (c - a) * 0.5;
        let square = a - b * 2.5 + c * 2.0 - d * 0.5;
        let cube = (d - a) * 0.5 + (b - c) * 1.5;
        let position = b + (linear + (square + cube * t) * t) * t;
        let derivative = linear + (square * 2.0 + cube * (3.0 * t)) * t;
        (position, derivative)
    }
}
