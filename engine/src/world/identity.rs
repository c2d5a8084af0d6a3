//! Names that outlive a run, and the two settings a scene has of its own.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;

/// The entity's id in its scene file: unique there, stable over save and load.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Clone, PartialEq)]
pub struct SceneId(pub String);

/// What a ray that hits nothing sees, linear RGB.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
pub struct Background(pub Vec3);

impl Default for Background {
    fn default() -> Self {
        Self(Vec3::ZERO)
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
