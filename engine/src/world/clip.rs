//! Clips: animations that files bring along, as keys of the poses of entities.
//!
//! Importers fill [`Clip`], the scene loader makes a [`ClipSet`] of all that a model has, and a [`ClipPlayer`] on the
//! entity that shows the model plays them.

mod player;
mod sample;
mod set;
#[cfg(test)]
mod tests;

pub use player::{ClipLayer, ClipPlayer, play_clips};
pub use set::{ClipPlace, ClipSet};

use serde::{Deserialize, Serialize};

/// An animation of some entities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clip {
    /// What the file calls it.
    pub name: String,
    /// Seconds at which it begins.
    pub start: f64,
    /// Seconds at which it ends; not before it begins.
    pub end: f64,
    /// What it moves.
    pub tracks: Vec<Track>,
}

/// Keys of one value of one entity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Which of the entities that the clip's owner knows.
    pub target: usize,
    /// What it writes.
    pub channel: Channel,
    /// Seconds, at least one, none less than the one before; of two that are equal the later holds from there on.
    #[serde(with = "crate::pod::array")]
    pub times: Vec<f64>,
    /// Key by key: [`Channel`]'s numbers; with [`Interpolation::Cubic`] three times as many: the velocity (a second)
    /// with which the key is reached, the value, the velocity with which it is left; with [`Interpolation::Squad`] what it bends
    /// towards before the key, the value, what it bends towards after it.
    #[serde(with = "crate::pod::array")]
    pub values: Vec<f64>,
    /// What is between the keys.
    pub interpolation: Interpolation,
}

/// What a [`Track`] writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Channel {
    /// Three numbers.
    Translation,
    /// A unit quaternion: x, y, z, w.
    Rotation,
    /// Three numbers.
    Scale,
    /// Weights of morph targets: as many numbers as there are targets.
    Weights,
    /// A camera's full vertical opening angle, radians.
    VerticalFov,
    /// Shown from 0.5 on.
    Shown,
}

/// What is between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// The earlier one.
    Step,
    /// The straight way; rotations by the shorter arc (Shoemake 1985).
    Linear,
    /// The cubic Hermite curve.
    Cubic,
    /// Rotations: the curve on the sphere of unit quaternions that Shoemake calls `squad` (1987).
    Squad,
}
