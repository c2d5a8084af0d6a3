//! What an entity is made of, kept apart from the world: its components but those that systems derive.
//!
//! Taken before and after a command; the difference of the two is what the command did, side effects included.

use std::any::TypeId;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::{Reflect, TypeRegistry};

use super::change::Change;
use crate::world::{GlobalTransform, GlobalVisibility, OwnMesh, Rest, Transform};

/// A component, or a field of one, by itself.
pub type Value = Box<dyn Reflect>;

/// Components that systems derive from others: they come and go with those.
pub fn is_derived(component: TypeId) -> bool {
    [
        TypeId::of::<GlobalTransform>(),
        TypeId::of::<GlobalVisibility>(),
        TypeId::of::<OwnMesh>(),
        TypeId::of::<Children>(),
    ]
    .contains(&component)
}

/// Whether an entity has nothing on it but what is derived: it is as good as gone.
pub fn is_bare(world: &World, entity: Entity) -> bool {
    let Ok(found) = world.get_entity(entity) else {
        return true;
    };
    found.archetype().components().iter().all(|&component| {
        let info = world.components().get_info(component);
        info.and_then(|info| info.type_id()).is_some_and(is_derived)
    })
}

/// The components of an entity that reflection knows and no system derives, in order of their names.
pub fn authored(world: &World, registry: &TypeRegistry, entity: Entity) -> Vec<TypeId> {
    let Ok(found) = world.get_entity(entity) else {
        return Vec::new();
    };
    let mut known: Vec<(&str, TypeId)> = found
        .archetype()
        .components()
        .iter()
        .filter_map(|&component| world.components().get_info(component)?.type_id())
        .filter(|&id| !is_derived(id))
        .filter_map(|id| registry.get(id))
        .filter(|registration| registration.data::<ReflectComponent>().is_some())
        .map(|registration| (registration.type_info().type_path(), registration.type_id()))
        .collect();
    known.sort_unstable();
    known.into_iter().map(|(_, id)| id).collect()
}

/// A copy of a component; none: the entity does not have it, or it cannot be copied.
pub fn copy_of(
    world: &World,
    registry: &TypeRegistry,
    entity: Entity,
    component: TypeId,
) -> Option<Value> {
    let data = registry.get_type_data::<ReflectComponent>(component)?;
    let value = data.reflect(world.get_entity(entity).ok()?)?;
    value.reflect_clone().ok()
}

/// Entities as they were at a moment.
#[derive(Debug, Default)]
pub struct Snapshot {
    parts: Vec<(Entity, TypeId, Value)>,
    orders: Vec<(Entity, Vec<Entity>)>,
}

impl Snapshot {
    /// The parts of these entities, and the order of the children below these parents.
    pub fn take(world: &World, entities: &[Entity], parents: &[Entity]) -> Self {
        let registry = world.resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        let mut parts = Vec::new();
        for &entity in entities {
            for component in authored(world, &registry, entity) {
                let copy = copy_of(world, &registry, entity, component);
                parts.extend(copy.map(|copy| (entity, component, copy)));
            }
        }
        let order = |&parent: &Entity| {
            let children = world.get::<Children>(parent)?;
            Some((parent, children.to_vec()))
        };
        Self {
            parts,
            orders: parents.iter().filter_map(order).collect(),
        }
    }

    fn moving(&self) -> EntityHashSet {
        let rests = self.parts.iter();
        let rests = rests.filter(|(_, component, _)| *component == TypeId::of::<Rest>());
        rests.map(|(entity, ..)| *entity).collect()
    }

    /// What it takes to come from here to there.
    ///
    /// Where motion begins or ends the pose is told though it is the same just now: motion writes it from then on.
    pub fn changes_to(mut self, mut after: Self) -> Vec<Change> {
        let mut changes = Vec::new();
        let (moved, moves) = (self.moving(), after.moving());
        let tells_pose = |entity: Entity, component: TypeId| {
            component == TypeId::of::<Transform>()
                && moved.contains(&entity) != moves.contains(&entity)
        };
        for (entity, component, value) in std::mem::take(&mut self.parts) {
            let there = after
                .parts
                .iter()
                .position(|(e, c, _)| (*e, *c) == (entity, component));
            let there = there.map(|at| after.parts.swap_remove(at).2);
            let is_equal = there.as_deref().is_some_and(|there| {
                value.reflect_partial_eq(there.as_partial_reflect()) == Some(true)
            });
            if !is_equal || tells_pose(entity, component) {
                changes.push(Change::Part {
                    entity,
                    component,
                    before: Some(value),
                    after: there,
                });
            }
        }
        let new = after.parts.into_iter();
        changes.extend(new.map(|(entity, component, value)| Change::Part {
            entity,
            component,
            before: None,
            after: Some(value),
        }));
        for (parent, order) in after.orders {
            let known = self.orders.iter().position(|(p, _)| *p == parent);
            let before = known.map_or_else(Vec::new, |at| self.orders.swap_remove(at).1);
            if before != order {
                changes.push(Change::Order {
                    parent,
                    before,
                    after: order,
                });
            }
        }
        // Parents that lost all their children.
        changes.extend(
            self.orders
                .into_iter()
                .map(|(parent, before)| Change::Order {
                    parent,
                    before,
                    after: Vec::new(),
                }),
        );
        changes
    }
}

/// An entity and all below it, parents first.
pub fn with_all_below(world: &World, entities: &[Entity]) -> Vec<Entity> {
    let mut found: Vec<Entity> = Vec::new();
    let mut seen = EntityHashSet::default();
    let mut pending: Vec<Entity> = entities.iter().rev().copied().collect();
    while let Some(entity) = pending.pop() {
        if seen.insert(entity) {
            found.push(entity);
            let children = world.get::<Children>(entity);
            pending.extend(children.into_iter().flat_map(|c| c.iter().rev()));
        }
    }
    found
}
