//! Motion on a circle.

use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::DVec3;

use super::{Rest, release};
use crate::world::{Transform, turn};

/// Travels on a circle about a point beside the rest position; the rotation stays.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Rest)]
#[component(summary_tick, on_remove = release)]
pub struct Orbit {
    /// Middle of the circle from the rest position, in the parent's space.
    pub center: DVec3,
    /// The circle is at right angles to it, and runs counter-clockwise seen from its tip. Any length but 0.
    pub axis: DVec3,
    /// In the parent's units.
    pub radius: f64,
    /// Seconds a turn; negative runs the other way, 0 stands still.
    pub period: f64,
    /// Radians from where the turn starts, which is towards +X (towards +Y about the x axis itself).
    pub phase: f64,
}

impl Default for Orbit {
    fn default() -> Self {
        Self {
            center: DVec3::ZERO,
            axis: DVec3::Y,
            radius: 1.0,
            period: 1.0,
            phase: 0.0,
        }
    }
}

impl Orbit {
    /// Position from the rest position at a time in seconds.
    pub fn at(&self, secs: f64) -> DVec3 {
        let axis = self.axis.normalize_or(DVec3::Y);
        let start = if axis.x.abs() < 0.9 {
            DVec3::X
        } else {
            DVec3::Y
        };
        let ahead = axis.cross(start).normalize_or(DVec3::Z);
        let (sin, cos) = (TAU * turn(secs, self.period) + self.phase).sin_cos();
        self.center + (ahead.cross(axis) * cos + ahead * sin) * self.radius
    }
}
