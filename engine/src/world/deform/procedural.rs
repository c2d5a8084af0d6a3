//! Deformers by formula: a wave that runs through a mesh, and a twist about a line.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::DVec3;
use std::f64::consts::TAU;

use super::DeformStep;
use crate::world::{FARTHEST, turn};

/// Most radians that the phase of a wave or the angle of a twist may differ by within a mesh: as far as the
/// sines of f32 tracers are exact.
const MOST_RADIANS: f64 = 8192.0;

/// Moves vertices to and fro as a plane wave passes, after [`super::Skin`].
///
/// A vertex p is moved by amplitude * sin(TAU * (p . direction / length - secs / period) + phase).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Wave {
    /// Where the wave runs, in the mesh's space; any length but 0.
    pub direction: DVec3,
    /// From crest to crest, in the mesh's units; more than 0.
    pub length: f64,
    /// Displacement at a crest.
    pub amplitude: DVec3,
    /// Seconds from crest to crest at one place; negative runs backwards, 0 stands still.
    pub period: f64,
    /// Radians.
    pub phase: f64,
}

impl Default for Wave {
    fn default() -> Self {
        Self {
            direction: DVec3::X,
            length: 1.0,
            amplitude: DVec3::new(0.0, 0.1, 0.0),
            period: 1.0,
            phase: 0.0,
        }
    }
}

impl Wave {
    /// The step at a time in seconds, for a mesh of this extent.
    ///
    /// # Errors
    /// What keeps it from being evaluated.
    pub(in crate::world) fn step(&self, secs: f64, extent: f64) -> Result<DeformStep, String> {
        let Some(direction) = self.direction.try_normalize() else {
            return Err("a wave needs a direction".into());
        };
        let number = TAU / self.length;
        if !(self.length > 0.0 && number * extent <= MOST_RADIANS) {
            return Err("a wave's length must be more than 0 and not tiny beside the mesh".into());
        }
        let phase = TAU * turn(secs, self.period) - self.phase;
        if !(self.amplitude.abs().max_element() <= FARTHEST && phase.is_finite()) {
            return Err("a wave's numbers must be finite".into());
        }
        Ok(DeformStep::Wave {
            wave: direction * number,
            amplitude: self.amplitude,
            phase,
        })
    }
}

/// Turns a mesh about a line, the more the farther along it; the last deformer.
///
/// The angle is (rate + swing * sin(TAU * secs / period)) * distance along the axis, + angle.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Twist {
    /// A point of the line, in the mesh's space; nothing turns there but by `angle`.
    pub origin: DVec3,
    /// Along the line; any length but 0.
    pub axis: DVec3,
    /// Radians per unit along the line.
    pub rate: f64,
    /// Radians per unit that are added and taken away in turn.
    pub swing: f64,
    /// Seconds of a swing there and back; 0 stands still.
    pub period: f64,
    /// Radians everywhere.
    pub angle: f64,
}

impl Default for Twist {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            axis: DVec3::Y,
            rate: 1.0,
            swing: 0.0,
            period: 1.0,
            angle: 0.0,
        }
    }
}

impl Twist {
    /// The step at a time in seconds, for a mesh of this extent.
    ///
    /// # Errors
    /// What keeps it from being evaluated.
    pub(in crate::world) fn step(&self, secs: f64, extent: f64) -> Result<DeformStep, String> {
        let Some(axis) = self.axis.try_normalize() else {
            return Err("a twist needs an axis".into());
        };
        let rate = self.rate + self.swing * (TAU * turn(secs, self.period)).sin();
        if !(rate.abs() * extent <= MOST_RADIANS) {
            return Err("a twist's rate must be finite and not huge for the mesh".into());
        }
        if !(self.origin.abs().max_element() <= FARTHEST && self.angle.is_finite()) {
            return Err("a twist's numbers must be finite".into());
        }
        Ok(DeformStep::Twist {
            origin: self.origin,
            axis,
            rate,
            offset: self.angle,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_is_the_same_after_whole_periods() {
        let wave = Wave {
            period: 2.5,
            ..Wave::default()
        };
        let twist = Twist {
            swing: 0.5,
            period: 0.75,
            ..Twist::default()
        };
        for secs in [0.0, 0.5, 1.125] {
            let later = secs + 7.5e8;
            assert_eq!(wave.step(secs, 1.0), wave.step(later, 1.0));
            assert_eq!(twist.step(secs, 1.0), twist.step(later, 1.0));
        }
    }

    #[test]
    fn what_cannot_be_evaluated_is_refused() {
        for wave in [
            Wave {
                direction: DVec3::ZERO,
                ..Wave::default()
            },
            Wave {
                length: 0.0,
                ..Wave::default()
            },
            Wave {
                amplitude: DVec3::NAN,
                ..Wave::default()
            },
            Wave {
                length: 1e-9,
                ..Wave::default()
            },
        ] {
            assert!(wave.step(0.0, 1.0).is_err(), "{wave:?}");
        }
        for rate in [f64::NAN, f64::INFINITY, 1e9] {
            let twist = Twist {
                rate,
                ..Twist::default()
            };
            assert!(twist.step(0.0, 1.0).is_err(), "{twist:?}");
        }
    }
}
