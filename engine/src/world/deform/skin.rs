//! Skinning: vertices that follow joints.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::DAffine3;

use super::{DeformStep, SkinBinding};
use crate::world::FARTHEST;

/// Moves every vertex with the joints it is bound to (linear blend skinning), after [`super::Morph`].
///
/// A joint carries a vertex by mesh_from_world * world_from_joint * joint_from_mesh, the last of these taken
/// in the bind pose; so what joints and mesh do together deforms nothing. A joint that is gone stays where it
/// was bound.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Skin {
    /// Which joints hold which vertex.
    #[reflect(ignore)]
    pub binding: Arc<SkinBinding>,
    /// Entities with a pose.
    #[entities]
    pub joints: Vec<Entity>,
    /// joint_from_mesh in the bind pose, one a joint (the inverse bind matrices).
    pub joint_from_mesh: Vec<DAffine3>,
}

impl Skin {
    /// The step for a mesh of so many vertices; `world_from` gives the pose of a joint that is there.
    ///
    /// # Errors
    /// What keeps it from deforming that mesh.
    pub(in crate::world) fn step(
        &self,
        vertices: usize,
        world_from_mesh: DAffine3,
        world_from: impl Fn(Entity) -> Option<DAffine3>,
    ) -> Result<DeformStep, String> {
        let bound = self.binding.joints.len();
        if bound != vertices || self.binding.weights.len() != vertices {
            return Err(format!(
                "a skin binds {bound} vertices, the mesh has {vertices}"
            ));
        }
        if self.joints.len() != self.joint_from_mesh.len() {
            return Err(format!(
                "{} joints with {} bind matrices",
                self.joints.len(),
                self.joint_from_mesh.len()
            ));
        }
        if vertices > 0 && self.binding.highest_joint() as usize >= self.joints.len() {
            return Err(format!(
                "a skin names joint {}, but there are {}",
                self.binding.highest_joint(),
                self.joints.len()
            ));
        }
        let mesh_from_world = world_from_mesh.inverse();
        let carried = |(&joint, joint_from_mesh): (&Entity, &DAffine3)| match world_from(joint) {
            Some(world_from_joint) => mesh_from_world * world_from_joint * *joint_from_mesh,
            None => DAffine3::IDENTITY,
        };
        let joints: Vec<DAffine3> = self
            .joints
            .iter()
            .zip(&self.joint_from_mesh)
            .map(carried)
            .collect();
        let within = |m: &DAffine3| m.to_cols_array().iter().all(|x| x.abs() <= FARTHEST);
        if !joints.iter().all(within) {
            return Err("a joint's pose is not finite, or the mesh's cannot be inverted".into());
        }
        Ok(DeformStep::Skin {
            binding: Arc::clone(&self.binding),
            joints,
        })
    }
}
