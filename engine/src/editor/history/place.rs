//! Where entities hang: another parent, the same place in the world.

use bevy_ecs::prelude::*;
use glam::DAffine3;

use super::birth::list_after;
use super::change::Change;
use super::command::Outcome;
use super::parts::{is_bare, with_all_below};
use super::run::recorded;
use crate::editor::naming::label;
use crate::scene::SceneRoots;
use crate::world::{Material, Rest, Shear, Transform};

pub(super) fn reparent(
    world: &mut World,
    entities: &[Entity],
    parent: Option<Entity>,
) -> Result<(Vec<Change>, Outcome), String> {
    if let Some(parent) = parent {
        if is_bare(world, parent) {
            return Err("what it is to hang from is not there any more".into());
        }
        if with_all_below(world, entities).contains(&parent) {
            return Err(format!(
                "{} is part of what is moved: nothing can hang from itself",
                label(world, parent)
            ));
        }
        if world.get::<Material>(parent).is_some() {
            return Err("nothing can hang from a material".into());
        }
    }
    let moved: Vec<Entity> = entities
        .iter()
        .copied()
        .filter(|&e| world.get::<ChildOf>(e).map(ChildOf::parent) != parent)
        .filter(|&e| world.get::<Material>(e).is_none())
        .collect();
    let mut touched = moved.clone();
    touched.extend(parent);
    let changes = recorded(world, &touched, |world| {
        for &entity in &moved {
            stay_in_place(world, entity, parent);
            match parent {
                Some(parent) => drop(world.entity_mut(entity).insert(ChildOf(parent))),
                None => {
                    world.entity_mut(entity).remove::<ChildOf>();
                    let roots = world.get_resource_or_init::<SceneRoots>();
                    if !roots.entities.contains(&entity) {
                        list_after(world, entity, None);
                    }
                }
            }
        }
        Vec::new()
    });
    Ok((changes, Outcome::default()))
}

/// world_from_local of an entity, from this frame's poses.
pub(in crate::editor) fn world_from(world: &World, entity: Option<Entity>) -> DAffine3 {
    let mut poses = Vec::new();
    let mut next = entity;
    while let Some(entity) = next {
        if let Some(transform) = world.get::<Transform>(entity) {
            poses.push((transform, world.get::<Shear>(entity)));
        }
        next = world.get::<ChildOf>(entity).map(ChildOf::parent);
    }
    crate::world::world_from_local(poses)
}

/// Gives an entity the pose below a new parent that it has in the world now. What a translation, a rotation and a scale
/// cannot say goes into its [`Shear`].
fn stay_in_place(world: &mut World, entity: Entity, parent: Option<Entity>) {
    let old = world.get::<ChildOf>(entity).map(ChildOf::parent);
    let new_from_old = world_from(world, parent).inverse() * world_from(world, old);
    if !new_from_old.is_finite() {
        return;
    }
    let shear = world
        .get::<Shear>(entity)
        .map_or(DAffine3::IDENTITY, |s| s.0);
    // What moves by itself is moved where it rests.
    let rest = world.get::<Rest>(entity).map(|rest| rest.0);
    let Some(pose) = rest.or_else(|| world.get::<Transform>(entity).copied()) else {
        return;
    };
    let wanted = new_from_old * pose.affine();
    let (scale, rotation, translation) = wanted.to_scale_rotation_translation();
    let next = Transform {
        translation,
        rotation,
        scale,
    };
    let left = next.affine().inverse() * wanted;
    let size = wanted
        .matrix3
        .abs()
        .to_cols_array()
        .into_iter()
        .fold(1e-300, f64::max);
    let is_exact = next.affine().abs_diff_eq(wanted, 1e-9 * size.max(1.0));
    if rest.is_some() {
        if let Some(mut rest) = world.get_mut::<Rest>(entity) {
            rest.0 = next;
        }
    } else if let Some(mut transform) = world.get_mut::<Transform>(entity) {
        *transform = next;
    }
    if !is_exact && left.is_finite() {
        world.entity_mut(entity).insert(Shear(left * shear));
    }
}
