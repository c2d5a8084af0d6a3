//! Running commands: each records what it changed, side effects included.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::TypeRegistry;

use super::change::{self, Change, Way};
use super::command::{Command, FieldSet, Outcome};
use super::parts::{Snapshot, Value, is_bare, with_all_below};
use super::{birth, place};
use crate::time::Time;
use crate::world::ClipPlayer;

/// Does it; what changed, and what besides.
pub(super) fn run(world: &mut World, command: Command) -> Result<(Vec<Change>, Outcome), String> {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    match command {
        Command::Set(sets) => Ok((set_fields(world, &registry, sets)?, Outcome::default())),
        Command::Insert(entities, value) => {
            let entities = there(world, &entities)?;
            let component = (*value).type_id();
            let changes = recorded(world, &entities, |world| {
                for &entity in &entities {
                    change::insert(world, &registry, entity, component, &*value);
                }
                Vec::new()
            });
            Ok((changes, Outcome::default()))
        }
        Command::Remove(entities, component) => {
            let entities = there(world, &entities)?;
            let changes = recorded(world, &entities, |world| {
                for &entity in &entities {
                    change::remove(world, &registry, entity, component);
                }
                Vec::new()
            });
            Ok((changes, Outcome::default()))
        }
        Command::Spawn {
            name,
            parent,
            parts,
        } => Ok(birth::spawn(world, &registry, (&name, parent, &parts))),
        Command::Model { file, scene, pose } => birth::model(world, (&file, &scene), pose),
        Command::Delete(entities) => {
            let entities = with_all_below(world, &there(world, &entities)?);
            let changes = recorded(world, &entities, |world| {
                // Children first: a parent takes nobody along.
                for &entity in entities.iter().rev() {
                    change::strip(world, entity);
                }
                Vec::new()
            });
            let select = Some(Vec::new());
            Ok((changes, Outcome { select }))
        }
        Command::Duplicate(entities) => {
            let entities = topmost(world, &there(world, &entities)?);
            Ok(birth::duplicate(world, &registry, &entities))
        }
        Command::Reparent(entities, parent) => {
            let entities = topmost(world, &there(world, &entities)?);
            place::reparent(world, &entities, parent)
        }
    }
}

/// Those that are there; an error if none is.
fn there(world: &World, entities: &[Entity]) -> Result<Vec<Entity>, String> {
    let mut found: Vec<Entity> = Vec::new();
    for &entity in entities {
        if !is_bare(world, entity) && !found.contains(&entity) {
            found.push(entity);
        }
    }
    if found.is_empty() {
        return Err("it is not there any more".into());
    }
    Ok(found)
}

/// Those that are not below another one of them.
pub(in crate::editor) fn topmost(world: &World, entities: &[Entity]) -> Vec<Entity> {
    let is_below = |&entity: &Entity| {
        let mut above = world.get::<ChildOf>(entity).map(ChildOf::parent);
        while let Some(parent) = above {
            if entities.contains(&parent) {
                return true;
            }
            above = world.get::<ChildOf>(parent).map(ChildOf::parent);
        }
        false
    };
    let entities = entities.iter().copied();
    entities.filter(|entity| !is_below(entity)).collect()
}

/// Runs `act`, which may change these entities, what is below and above them, and entities that it makes and hands back.
pub(super) fn recorded(
    world: &mut World,
    entities: &[Entity],
    act: impl FnOnce(&mut World) -> Vec<Entity>,
) -> Vec<Change> {
    let parents = |world: &World, of: &[Entity]| -> Vec<Entity> {
        let above = of.iter().filter_map(|&e| world.get::<ChildOf>(e));
        above
            .map(ChildOf::parent)
            .chain(of.iter().copied())
            .collect()
    };
    let mut above = parents(world, entities);
    let before = Snapshot::take(world, entities, &above);
    let made = act(world);
    world.flush();
    let mut all = entities.to_vec();
    all.extend(made);
    above.extend(parents(world, &all));
    above.sort_unstable();
    above.dedup();
    before.changes_to(Snapshot::take(world, &all, &above))
}

/// Writes all of them or none.
fn set_fields(
    world: &mut World,
    registry: &TypeRegistry,
    sets: Vec<FieldSet>,
) -> Result<Vec<Change>, String> {
    let mut changes = Vec::new();
    for set in sets {
        match set_field(world, registry, set) {
            Ok(more) => changes.extend(more),
            Err(why) => {
                change::apply(world, &changes, Way::Back);
                return Err(why);
            }
        }
    }
    Ok(changes)
}

fn set_field(
    world: &mut World,
    registry: &TypeRegistry,
    set: FieldSet,
) -> Result<Vec<Change>, String> {
    if set.component == TypeId::of::<ClipPlayer>() {
        return set_player(world, registry, set);
    }
    let target = (set.entity, set.component, set.path.as_str());
    let copy = |world: &World| {
        field_copy(world, registry, target)
            .ok_or_else(|| "there is no such field, or none that can be copied".to_owned())
    };
    let before = copy(world)?;
    if !change::write_field(world, registry, target, &*set.value)? {
        return Ok(Vec::new());
    }
    let after = copy(world)?;
    Ok(vec![Change::Field {
        entity: set.entity,
        component: set.component,
        path: set.path,
        before,
        after,
    }])
}

/// What is paused by hand stands where it is, and goes on from there: a write that has an effect on other fields.
fn set_player(
    world: &mut World,
    registry: &TypeRegistry,
    set: FieldSet,
) -> Result<Vec<Change>, String> {
    let secs = world.get_resource::<Time>().map_or(0.0, |time| time.secs);
    let mut result = Ok(false);
    let changes = recorded(world, &[set.entity], |world| {
        let before = world.get::<ClipPlayer>(set.entity).cloned();
        let target = (set.entity, set.component, set.path.as_str());
        result = change::write_field(world, registry, target, &*set.value);
        let player = world.get_mut::<ClipPlayer>(set.entity);
        if let (Some(mut player), Some(before)) = (player, before)
            && set.path.ends_with(".paused")
            && *player != before
        {
            player.keep_poses(&before.layers, secs);
        }
        Vec::new()
    });
    result.map(|_| changes)
}

fn field_copy(
    world: &World,
    registry: &TypeRegistry,
    (entity, component, path): (Entity, TypeId, &str),
) -> Option<Value> {
    let data = registry.get_type_data::<ReflectComponent>(component)?;
    let whole = data.reflect(world.get_entity(entity).ok()?)?;
    change::field_at(whole, path).ok()?.reflect_clone().ok()
}
