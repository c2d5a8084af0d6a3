//! Position, rotation and scale of an entity, local and in the world, in f64.
//!
//! [`Transform`] is what people and systems write; [`GlobalTransform`] is derived by
//! [`super::propagate`] and read by extraction. f64 keeps a scene ten million units from the origin
//! exact; the tracers subtract the camera before they round to f32.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::{DAffine3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::propagate::Inherited;

/// Pose of an entity relative to its parent: p' = translation + rotation * (scale * p).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(GlobalTransform)]
pub struct Transform {
    /// Position in the parent's space, in world units.
    pub translation: DVec3,
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Factors along the local axes; negative mirrors, zero makes the entity vanish.
    pub scale: DVec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// No motion at all.
    pub const IDENTITY: Self = Self {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };

    /// A pure translation.
    pub fn from_translation(translation: DVec3) -> Self {
        Self {
            translation,
            ..Self::IDENTITY
        }
    }

    /// A pose at `eye` whose -Z axis looks at `target` and whose +Y axis is as near to `up` as can be.
    ///
    /// Where `eye == target`, or `up` is parallel to the view, another up is chosen: never NaN.
    pub fn looking_at(eye: DVec3, target: DVec3, up: DVec3) -> Self {
        let back = (eye - target).try_normalize().unwrap_or(DVec3::Z);
        let right = up
            .cross(back)
            .try_normalize()
            .unwrap_or_else(|| back.any_orthonormal_vector());
        let up = back.cross(right);
        Self {
            translation: eye,
            rotation: DQuat::from_mat3(&glam::DMat3::from_cols(right, up, back)).normalize(),
            scale: DVec3::ONE,
        }
    }

    /// The affine map parent_from_local.
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// An extra affine map applied before [`Transform`]: world = parent * transform * affine.
///
/// For what translation, rotation and scale cannot say (shear; matrices of imported files).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Shear(pub DAffine3);

/// parent_from_local of an entity's own components.
fn parent_from_local(transform: &Transform, shear: Option<&Shear>) -> DAffine3 {
    match shear {
        Some(Shear(shear)) => transform.affine() * *shear,
        None => transform.affine(),
    }
}

/// world_from_local out of this frame's poses, from an entity up to its root.
///
/// For systems that run before propagation, when [`GlobalTransform`] is still last frame's.
pub fn world_from_local<'a>(
    poses: impl IntoIterator<Item = (&'a Transform, Option<&'a Shear>)>,
) -> DAffine3 {
    poses
        .into_iter()
        .fold(DAffine3::IDENTITY, |inner, (transform, shear)| {
            parent_from_local(transform, shear) * inner
        })
}

/// world_from_local of an entity; written by propagation only.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct GlobalTransform(pub DAffine3);

impl Inherited for GlobalTransform {
    type Local = Transform;
    type Extra = Shear;

    fn compose(parent: Option<&Self>, local: &Transform, shear: Option<&Shear>) -> Self {
        let parent_from_local = parent_from_local(local, shear);
        match parent {
            Some(Self(world_from_parent)) => Self(*world_from_parent * parent_from_local),
            None => Self(parent_from_local),
        }
    }
}
