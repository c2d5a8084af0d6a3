//! Turning on the spot.

use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::{DQuat, DVec3};

use super::{Rest, release};
use crate::world::{Transform, turn};

/// Turns about an axis through the entity's own origin.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Rest)]
#[component(summary_tick, on_remove = release)]
pub struct Spin {
    /// In the entity's own space at rest; any length but 0.
    pub axis: DVec3,
    /// Seconds a turn, counter-clockwise seen from the axis' tip; negative the other way, 0 stands still.
    pub period: f64,
    /// Radians.
    pub phase: f64,
}

impl Default for Spin {
    fn default() -> Self {
        Self {
            axis: DVec3::Y,
            period: 1.0,
            phase: 0.0,
        }
    }
}

impl Spin {
    /// The turn at a time in seconds, in the entity's own space.
    pub fn at(&self, secs: f64) -> DQuat {
        let axis = self.axis.normalize_or(DVec3::Y);
        let (sin, cos) = (0.5 * (TAU * turn(secs, self.period) + self.phase)).sin_cos();
        DQuat::from_vec4((axis * sin).extend(cos))
    }
}
