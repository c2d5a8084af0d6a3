//! Motion to and fro.

use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::DVec3;

use super::{Rest, release};
use crate::world::{Transform, turn};

/// Swings to both sides of the rest position; many, each of another phase, are a wave.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Rest)]
#[component(summary_tick, on_remove = release)]
pub struct Sway {
    /// Farthest displacement, in the parent's space.
    pub amplitude: DVec3,
    /// Seconds there and back; 0 stands still.
    pub period: f64,
    /// Radians; 0 starts at rest, on the way towards `amplitude`.
    pub phase: f64,
}

impl Default for Sway {
    fn default() -> Self {
        Self {
            amplitude: DVec3::Y,
            period: 1.0,
            phase: 0.0,
        }
    }
}

impl Sway {
    /// Position from the rest position at a time in seconds.
    pub fn at(&self, secs: f64) -> DVec3 {
        self.amplitude * (TAU * turn(secs, self.period) + self.phase).sin()
    }
}
