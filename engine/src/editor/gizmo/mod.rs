//! Handles in the picture: move, turn and scale what is selected; the radius of a ball, the opening of a spot light.
//!
//! They have the same size on the screen wherever the thing is. What a drag does is a function of where it began and where
//! the mouse is now, so snapping is relative to the start and nothing adds up; all of it is one step of the history.

mod drag;
mod handles;

pub use drag::Drag;
pub use handles::{Handle, handles, under};

use bevy_ecs::prelude::*;
use glam::{DAffine3, DQuat, DVec3};

use super::sight::Sight;
use crate::world::{GlobalTransform, Sphere, SpotLight};

/// Length of an axis on the screen, points.
pub const REACH: f64 = 84.0;
/// How near the mouse has to be to a handle, points.
pub const NEAR: f32 = 8.0;

/// What the handles do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Move along axes, in planes, or in the plane of the picture.
    #[default]
    Move,
    /// Turn about axes.
    Rotate,
    /// Scale along the thing's own axes, or all at once.
    Scale,
}

/// The handles as they are set, and the drag in progress.
#[derive(Resource, Debug, Default)]
pub struct Gizmo {
    /// What they do.
    pub mode: Mode,
    /// Along the thing's own axes; false: the world's.
    pub own_axes: bool,
    /// The handle under the mouse.
    pub hover: Option<Handle>,
    /// What is being dragged.
    pub drag: Option<Drag>,
    /// Drags so far: each is a group of the history.
    pub drags: u64,
}

/// Where the handles are, and what they are of.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The entity that leads the selection.
    pub entity: Entity,
    /// Their middle, in the world.
    pub pivot: DVec3,
    /// Unit axes, in the world.
    pub axes: [DVec3; 3],
    /// Length of an axis in the world.
    pub reach: f64,
    /// Radius in the world of the ball it is, if it is one.
    pub radius: Option<f64>,
    /// Axis and opening (half, radians) of the spot light it is, if it is one.
    pub cone: Option<(DVec3, f64)>,
}

impl Frame {
    /// The frame of an entity with a pose; none: it has none, or is not before the eye.
    pub fn of(world: &World, sight: &Sight, entity: Entity, own_axes: bool) -> Option<Self> {
        let pose: DAffine3 = world.get::<GlobalTransform>(entity)?.0;
        let pivot = pose.translation;
        sight.place(pivot)?;
        let (_, rotation, _) = pose.to_scale_rotation_translation();
        let turn = if own_axes { rotation } else { DQuat::IDENTITY };
        let radius = world.get::<Sphere>(entity).map(|sphere| {
            let scale = pose.matrix3.determinant().abs().cbrt();
            sphere.radius * scale
        });
        let cone = world.get::<SpotLight>(entity).map(|light| {
            let axis = pose.transform_vector3(DVec3::NEG_Z);
            (axis.normalize_or(DVec3::NEG_Z), light.outer_angle)
        });
        Some(Self {
            entity,
            pivot,
            axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis),
            reach: sight.world_per_point(pivot) * REACH,
            radius,
            cone,
        })
    }
}

#[cfg(test)]
mod tests;
