//! Looking at a point or a moving entity.
//!
//! `GlobalTransform` is last frame's when the timeline runs, so world positions are composed here from the
//! f64 transforms just written. A look depends on the rotations above its own entity and above its target;
//! looks are sorted so that those come first. Where they depend on each other in a circle no order is
//! right; the loader reports that as a problem.

use bevy_ecs::prelude::*;
use glam::{DAffine3, DVec3};

use super::{Ids, set_rotation, world_position};
use crate::scene::schema::{LookAt, Path};
use crate::world::{Transform, world_from_local};

/// An entity turned to what it looks at.
#[derive(Debug)]
pub struct Look {
    entity: Entity,
    target: Target,
    up: DVec3,
}

#[derive(Debug)]
enum Target {
    Point(DVec3),
    Entity(Entity),
}

impl Look {
    /// Turns the entity; its position and all above it are settled.
    pub fn turn(&self, world: &mut World) {
        let target = match self.target {
            Target::Point(point) => point,
            Target::Entity(entity) => world_position(world, entity),
        };
        let Some(transform) = world.get::<Transform>(self.entity) else {
            return;
        };
        let eye = transform.translation;
        let parent = world.get::<ChildOf>(self.entity).map(ChildOf::parent);
        let world_from_parent = parent.map_or(DAffine3::IDENTITY, |p| global(world, p));
        let parent_from_world = world_from_parent.inverse();
        let target = parent_from_world.transform_point3(target);
        let up = parent_from_world.transform_vector3(self.up);
        if target.is_finite() && up.is_finite() {
            set_rotation(world, self.entity, &Transform::looking_at(eye, target, up));
        }
    }
}

/// An entity's ancestors, its parent first.
fn above(world: &World, entity: Entity) -> impl Iterator<Item = Entity> {
    let parent = |entity| world.get::<ChildOf>(entity).map(ChildOf::parent);
    std::iter::successors(parent(entity), move |&entity| parent(entity))
}

/// world_from_local of an entity from this frame's transforms.
pub fn global(world: &World, entity: Entity) -> DAffine3 {
    world_from_local(
        std::iter::once(entity)
            .chain(above(world, entity))
            .filter_map(|entity| Some((world.get(entity)?, world.get(entity)))),
    )
}

/// The looks of all paths, each after those it depends on.
pub fn ordered(paths: &[Path], ids: &Ids, world: &World) -> Vec<Look> {
    let mut looks: Vec<Look> = paths
        .iter()
        .filter_map(|path| {
            Some(Look {
                entity: *ids.entities.get(&path.target.value)?,
                target: match path.look_at.as_ref()? {
                    LookAt::Point(point) => Target::Point(*point),
                    LookAt::Entity(id) => Target::Entity(*ids.entities.get(&id.value)?),
                },
                up: path.up,
            })
        })
        .collect();
    let needs: Vec<Vec<usize>> = looks
        .iter()
        .map(|look| {
            let mut needed: Vec<Entity> = above(world, look.entity).collect();
            if let Target::Entity(target) = look.target {
                needed.extend(above(world, target));
            }
            (0..looks.len())
                .filter(|&i| needed.contains(&looks[i].entity))
                .collect()
        })
        .collect();
    let order = sorted(&needs).unwrap_or_else(|_| (0..looks.len()).collect());
    let mut slots: Vec<Option<Look>> = looks.drain(..).map(Some).collect();
    order.into_iter().filter_map(|i| slots[i].take()).collect()
}

/// An order in which every row comes after the rows it needs.
///
/// # Errors
/// A row that needs itself, directly or through others.
pub fn sorted(needs: &[Vec<usize>]) -> Result<Vec<usize>, usize> {
    let mut order = Vec::with_capacity(needs.len());
    let mut done = vec![false; needs.len()];
    // Quadratic at worst; there are a handful of paths.
    while order.len() < needs.len() {
        let ready: Vec<usize> = (0..needs.len())
            .filter(|&i| !done[i] && needs[i].iter().all(|&n| done[n]))
            .collect();
        if ready.is_empty() {
            return Err(done.iter().position(|done| !done).unwrap_or_default());
        }
        for i in ready {
            done[i] = true;
            order.push(i);
        }
    }
    Ok(order)
}
