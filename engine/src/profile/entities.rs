//! What each entity costs of the picture: a column for lists of entities.

use std::collections::HashMap;

use bevy_ecs::prelude::*;

/// Rays and tests of an entity in the last survey.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EntityCost {
    /// Rays that met it.
    pub met: u64,
    /// Rays that it sent on: mirrored, refracted, to lights.
    pub sent: u64,
    /// Its share of all the picture's work, from 0 to 1.
    pub share: f64,
}

/// The last survey; empty until somebody asked for one.
#[derive(Resource, Clone, Debug, Default)]
pub struct EntityCosts(pub HashMap<Entity, EntityCost>);

impl EntityCosts {
    /// What an entity costs; none: it is in no picture, or nobody has asked.
    pub fn of(&self, entity: Entity) -> Option<EntityCost> {
        self.0.get(&entity).copied()
    }
}
