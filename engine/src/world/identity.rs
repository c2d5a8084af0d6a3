//! Names that outlive a run, and the two settings a scene has of its own.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;

use super::TextureId;

/// The entity's id in its scene file: unique there, stable over save and load.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Clone, PartialEq)]
pub struct SceneId(pub String);

/// What a ray that hits nothing sees, linear RGB: the horizon's colour where it goes level, and the more of the zenith's or
/// the ground's the steeper it goes up or down. Where all three are one, the background is plain.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub struct Background {
    /// Straight up (+Y).
    pub zenith: Vec3,
    /// Level.
    pub horizon: Vec3,
    /// Straight down.
    pub ground: Vec3,
    /// A panorama (equirectangular) that the colours are multiplied with; -Z is in its middle, +X to the right.
    pub picture: Option<TextureId>,
    /// How far the panorama is turned about +Y, radians.
    pub turn: f64,
}

impl From<Vec3> for Background {
    fn from(color: Vec3) -> Self {
        Self {
            zenith: color,
            horizon: color,
            ground: color,
            picture: None,
            turn: 0.0,
        }
    }
}

impl Background {
    /// Whether it is the same everywhere.
    pub fn is_plain(&self) -> bool {
        self.zenith == self.horizon && self.ground == self.horizon && self.picture.is_none()
    }

    /// The same with each colour changed.
    #[must_use]
    pub fn map(self, mut change: impl FnMut(Vec3) -> Vec3) -> Self {
        Self {
            zenith: change(self.zenith),
            horizon: change(self.horizon),
            ground: change(self.ground),
            ..self
        }
    }

    /// The brightest of each channel.
    pub fn brightest(&self) -> Vec3 {
        self.zenith.max(self.horizon).max(self.ground)
    }
}

/// How many generations of rays are followed; the camera's ray is the first, what comes after is black.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceDepth(pub u32);

impl Default for TraceDepth {
    fn default() -> Self {
        Self(8)
    }
}
