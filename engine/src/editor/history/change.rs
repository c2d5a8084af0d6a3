//! A change that can go both ways: of a field, of a whole component, of the order of children.
//!
//! Nothing is despawned: an entity that is deleted is stripped bare. No query finds it then, every system that follows
//! components sees them go, and its id stays its own, so that all who name it (surfaces, parents, the timeline, the active
//! camera) mean the same entity again once it has its components back.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::{GetPath, PartialReflect, Reflect, TypeRegistry};

use super::parts::{Value, is_bare};

/// What was there before, and what after.
#[derive(Debug)]
pub enum Change {
    /// One field of a component.
    Field {
        /// Whose.
        entity: Entity,
        /// Of which component.
        component: TypeId,
        /// Where in it, as bevy_reflect writes paths.
        path: String,
        /// Its value before.
        before: Value,
        /// Its value after.
        after: Value,
    },
    /// A component that came, went or changed as a whole.
    Part {
        /// Whose.
        entity: Entity,
        /// Which component.
        component: TypeId,
        /// Before; none: it was not there.
        before: Option<Value>,
        /// After; none: it is not there.
        after: Option<Value>,
    },
    /// The order of an entity's children; which they are is told by the changes of theirs.
    Order {
        /// Whose children.
        parent: Entity,
        /// Before.
        before: Vec<Entity>,
        /// After.
        after: Vec<Entity>,
    },
}

/// Which way through a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// To what was before.
    Back,
    /// To what was after.
    Forth,
}

impl Change {
    /// The entity it is about.
    pub fn entity(&self) -> Entity {
        match self {
            Self::Field { entity, .. } | Self::Part { entity, .. } => *entity,
            Self::Order { parent, .. } => *parent,
        }
    }

    /// Takes a later change of the same thing into this one, or gives it back.
    pub fn join(&mut self, later: Self) -> Option<Self> {
        match (self, later) {
            (
                Self::Field {
                    entity,
                    component,
                    path,
                    after,
                    ..
                },
                Self::Field {
                    entity: e,
                    component: c,
                    path: p,
                    after: last,
                    ..
                },
            ) if (*entity, *component) == (e, c) && *path == p => *after = last,
            (
                Self::Part {
                    entity,
                    component,
                    after,
                    ..
                },
                Self::Part {
                    entity: e,
                    component: c,
                    after: last,
                    ..
                },
            ) if (*entity, *component) == (e, c) => *after = last,
            (
                Self::Order { parent, after, .. },
                Self::Order {
                    parent: p,
                    after: last,
                    ..
                },
            ) if *parent == p => *after = last,
            (_, later) => return Some(later),
        }
        None
    }

    /// The component it leads to: none unless it is about a whole one.
    fn part(&self, way: Way) -> Option<(Entity, TypeId, Option<&dyn Reflect>)> {
        let Self::Part {
            entity,
            component,
            before,
            after,
        } = self
        else {
            return None;
        };
        let target = match way {
            Way::Back => before,
            Way::Forth => after,
        };
        Some((*entity, *component, target.as_deref()))
    }
}

/// Takes the world through changes that were made together.
pub fn apply(world: &mut World, changes: &[Change], way: Way) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let parts: Vec<_> = changes.iter().filter_map(|c| c.part(way)).collect();
    remove_parts(world, &registry, &parts);
    // A child takes its place below a parent that is all there.
    let is_link = |component: TypeId| component == TypeId::of::<ChildOf>();
    for links in [false, true] {
        for &(entity, component, target) in &parts {
            if let Some(value) = target
                && is_link(component) == links
            {
                insert(world, &registry, entity, component, value);
            }
        }
    }
    world.flush();
    // What components do to each other as they come (a rest pose takes that of its entity) is put right again.
    for &(entity, component, target) in &parts {
        if let Some(value) = target
            && !is_link(component)
        {
            write_whole(world, &registry, entity, component, value);
        }
    }
    let in_order: Box<dyn Iterator<Item = &Change>> = match way {
        Way::Back => Box::new(changes.iter().rev()),
        Way::Forth => Box::new(changes.iter()),
    };
    for change in in_order {
        match change {
            Change::Field {
                entity,
                component,
                path,
                before,
                after,
            } => {
                let value = if way == Way::Back { before } else { after };
                if let Err(why) =
                    write_field(world, &registry, (*entity, *component, path), &**value)
                {
                    tracing::warn!("{entity}{path} stays as it is: {why}");
                }
            }
            Change::Order {
                parent,
                before,
                after,
            } => put_in_order(
                world,
                *parent,
                if way == Way::Back { before } else { after },
            ),
            Change::Part { .. } => {}
        }
    }
}

fn remove_parts(
    world: &mut World,
    registry: &TypeRegistry,
    parts: &[(Entity, TypeId, Option<&dyn Reflect>)],
) {
    // Links first: a parent takes nobody along.
    for links in [true, false] {
        for &(entity, component, target) in parts {
            if target.is_none() && links == (component == TypeId::of::<ChildOf>()) {
                remove(world, registry, entity, component);
            }
        }
    }
    world.flush();
    for &(entity, _, target) in parts {
        if target.is_none() && is_bare(world, entity) {
            strip(world, entity);
        }
    }
}

/// Takes off all components; the id stays.
pub fn strip(world: &mut World, entity: Entity) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.clear();
    }
    world.flush();
}

/// Takes a component off an entity that has it.
pub fn remove(world: &mut World, registry: &TypeRegistry, entity: Entity, component: TypeId) {
    let data = registry.get_type_data::<ReflectComponent>(component);
    if let (Some(data), Ok(mut entity)) = (data, world.get_entity_mut(entity)) {
        data.remove(&mut entity);
    }
}

/// Gives an entity a component; what reflection does not see of it is written as well.
pub fn insert(
    world: &mut World,
    registry: &TypeRegistry,
    entity: Entity,
    component: TypeId,
    value: &dyn Reflect,
) {
    let can_change = component != TypeId::of::<ChildOf>();
    let data = registry.get_type_data::<ReflectComponent>(component);
    let (Some(data), Ok(mut found)) = (data, world.get_entity_mut(entity)) else {
        return;
    };
    if can_change && data.contains(&found) {
        return write_whole(world, registry, entity, component, value);
    }
    data.insert(&mut found, value.as_partial_reflect(), registry);
    if can_change {
        write_whole(world, registry, entity, component, value);
    }
}

/// Makes a component that is there equal to a value; one that is equal is left alone, its change tick with it.
fn write_whole(
    world: &mut World,
    registry: &TypeRegistry,
    entity: Entity,
    component: TypeId,
    value: &dyn Reflect,
) {
    if let Err(why) = write_field(world, registry, (entity, component, ""), value) {
        tracing::warn!("a component of {entity} stays as it is: {why}");
    }
}

/// Writes a field, or with an empty path the component, to the very value where the types agree. Whether that changed it.
///
/// # Errors
/// Why it cannot be.
pub fn write_field(
    world: &mut World,
    registry: &TypeRegistry,
    (entity, component, path): (Entity, TypeId, &str),
    value: &dyn PartialReflect,
) -> Result<bool, String> {
    let data = registry
        .get_type_data::<ReflectComponent>(component)
        .ok_or("its component is not reflected")?;
    let mut found = world
        .get_entity_mut(entity)
        .map_err(|_| "the entity is gone".to_owned())?;
    let now = data
        .reflect(&found)
        .ok_or("the entity has no such component")?;
    if field_at(now, path)?.reflect_partial_eq(value) == Some(true) {
        return Ok(false);
    }
    let mut whole = data
        .reflect_mut(&mut found)
        .ok_or("the component cannot be changed in place")?;
    let field = if path.is_empty() {
        whole.as_partial_reflect_mut()
    } else {
        whole
            .reflect_path_mut(path)
            .map_err(|error| error.to_string())?
    };
    let mut exact = value.try_as_reflect().and_then(|v| v.reflect_clone().ok());
    if let (Some(field), Some(value)) = (field.try_as_reflect_mut(), exact.take()) {
        match field.set(value) {
            Ok(()) => return Ok(true),
            Err(other) => exact = Some(other),
        }
    }
    let value = exact.as_deref().map_or(value, |v| v.as_partial_reflect());
    field
        .try_apply(value)
        .map(|()| true)
        .map_err(|error| error.to_string())
}

/// A field of a component, or with an empty path all of it.
pub fn field_at<'a>(root: &'a dyn Reflect, path: &str) -> Result<&'a dyn PartialReflect, String> {
    if path.is_empty() {
        return Ok(root.as_partial_reflect());
    }
    root.reflect_path(path).map_err(|error| error.to_string())
}

fn put_in_order(world: &mut World, parent: Entity, order: &[Entity]) {
    let Some(mut children) = world.get_mut::<Children>(parent) else {
        return;
    };
    if **children == *order {
        return;
    }
    let rank = |child: &Entity| order.iter().position(|e| e == child).unwrap_or(order.len());
    children.sort_by_cached_key(rank);
}
