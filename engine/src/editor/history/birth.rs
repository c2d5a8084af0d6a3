//! How entities come to be: new ones, and copies of others.

use std::any::TypeId;
use std::path::Path;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_reflect::TypeRegistry;

use super::change::{self, Change};
use super::command::Outcome;
use super::parts::{Value, authored, copy_of, is_bare, with_all_below};
use super::run::recorded;
use crate::scene::{self, SceneRoots};
use crate::world::{Material, Rest, SceneId, Transform};

/// An id that no entity of the scene has, from a word that people read.
pub fn unique_id(world: &mut World, wanted: &str) -> String {
    let mut ids = world.query::<&SceneId>();
    let taken: std::collections::HashSet<&str> = ids.iter(world).map(|id| id.0.as_str()).collect();
    if !taken.contains(wanted) {
        return wanted.to_owned();
    }
    // "ball 2" is followed by "ball 3".
    let (stem, number) = match wanted.rsplit_once(' ') {
        Some((stem, number)) => (stem, number.parse::<u64>().ok()),
        None => (wanted, None),
    };
    let (stem, first) = match number {
        Some(number) => (stem, number.saturating_add(1)),
        None => (wanted, 2),
    };
    (first..)
        .map(|number| format!("{stem} {number}"))
        .find(|id| !taken.contains(id.as_str()))
        .unwrap_or_else(|| wanted.to_owned())
}

pub(super) fn spawn(
    world: &mut World,
    registry: &TypeRegistry,
    (name, parent, parts): (&str, Option<Entity>, &[Value]),
) -> (Vec<Change>, Outcome) {
    let id = unique_id(world, name);
    let parent = parent.filter(|&parent| !is_bare(world, parent));
    let entity = world.spawn_empty().id();
    let above: Vec<Entity> = parent.into_iter().collect();
    let changes = recorded(world, &above, |world| {
        for part in parts {
            change::insert(world, registry, entity, (**part).type_id(), &**part);
        }
        let mut made = world.entity_mut(entity);
        made.insert((Name::new(id.clone()), SceneId(id)));
        match parent {
            Some(parent) => drop(made.insert(ChildOf(parent))),
            None => list_after(world, entity, None),
        }
        vec![entity]
    });
    let select = Some(vec![entity]);
    (changes, Outcome { select })
}

/// What a model's file shows, as new entities.
pub(super) fn model(
    world: &mut World,
    (file, scene): (&Path, &Path),
    pose: Transform,
) -> Result<(Vec<Change>, Outcome), String> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let id = unique_id(world, &name);
    let made =
        scene::add_model(world, (&id, file), scene).map_err(|problems| problems.to_string())?;
    let Some(&root) = made.first() else {
        return Err("the file shows nothing".into());
    };
    if let Some(mut transform) = world.get_mut::<Transform>(root) {
        *transform = pose;
    }
    list_after(world, root, None);
    let all = with_all_below(world, &made);
    let changes = recorded(world, &[], |_| all);
    let select = Some(vec![root]);
    Ok((changes, Outcome { select }))
}

/// Gives a new entity at the top its place in the scene's file: after another one, or last.
pub(super) fn list_after(world: &mut World, entity: Entity, after: Option<Entity>) {
    let is_material = world.get::<Material>(entity).is_some();
    let mut roots = world.get_resource_or_init::<SceneRoots>();
    let list = if is_material {
        &mut roots.materials
    } else {
        &mut roots.entities
    };
    let after = after.and_then(|after| list.iter().position(|&e| e == after));
    list.insert(after.map_or(list.len(), |after| after + 1), entity);
}

pub(super) fn duplicate(
    world: &mut World,
    registry: &TypeRegistry,
    entities: &[Entity],
) -> (Vec<Change>, Outcome) {
    let originals = with_all_below(world, entities);
    let mut copies: EntityHashMap<Entity> = originals
        .iter()
        .map(|&original| (original, world.spawn_empty().id()))
        .collect();
    let made: Vec<Entity> = originals.iter().map(|e| copies[e]).collect();
    let above: Vec<Entity> = entities
        .iter()
        .filter_map(|&e| Some(world.get::<ChildOf>(e)?.parent()))
        .collect();
    let changes = recorded(world, &above, |world| {
        for (&original, &copy) in originals.iter().zip(&made) {
            for component in authored(world, registry, original) {
                copy_part(world, registry, (original, copy, component), &mut copies);
            }
        }
        for (&original, &copy) in originals.iter().zip(&made) {
            if let Some(SceneId(id)) = world.get::<SceneId>(original).cloned() {
                let is_named = world
                    .get::<Name>(original)
                    .is_some_and(|n| n.as_str() != id);
                let id = unique_id(world, &id);
                let mut copy = world.entity_mut(copy);
                if !is_named {
                    copy.insert(Name::new(id.clone()));
                }
                copy.insert(SceneId(id));
            }
            if world.get::<ChildOf>(original).is_none() {
                list_after(world, copy, Some(original));
            }
        }
        made.clone()
    });
    let select = Some(entities.iter().map(|e| copies[e]).collect());
    (changes, Outcome { select })
}

/// Copies a component; entities that it names and that are copied too become the copies.
fn copy_part(
    world: &mut World,
    registry: &TypeRegistry,
    (original, copy, component): (Entity, Entity, TypeId),
    copies: &mut EntityHashMap<Entity>,
) {
    // An id is given once.
    if component == TypeId::of::<SceneId>() {
        return;
    }
    let Some(mut value) = copy_of(world, registry, original, component) else {
        return;
    };
    if let Some(data) = registry.get_type_data::<ReflectComponent>(component) {
        data.map_entities(&mut *value, copies);
    }
    change::insert(world, registry, copy, component, &*value);
    world.flush();
    if component == TypeId::of::<Rest>() {
        return;
    }
    // A rest pose takes that of its entity as it comes: it is written again by whoever comes after it.
    if let Some(rest) = world.get::<Rest>(original).copied()
        && let Some(mut now) = world.get_mut::<Rest>(copy)
    {
        now.set_if_neq(rest);
    }
}
