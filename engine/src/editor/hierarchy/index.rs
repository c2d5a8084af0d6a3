//! All that the hierarchy can list, in the order of a walk through the tree: found anew only when that may have changed.

use std::any::TypeId;
use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_ecs::system::SystemParam;

use super::Tree;
use crate::editor::naming::label;
use crate::scene::SceneRoots;
use crate::world::{Material, SceneId, Transform, Visibility};

/// One thing.
#[derive(Debug)]
pub struct Item {
    /// Which.
    pub entity: Entity,
    /// How many are above it.
    pub depth: usize,
    /// What people call it.
    pub label: String,
    /// The same as a search compares it.
    lower: String,
    /// How many of the items that follow are below it.
    pub below: usize,
    /// Its own switch is off.
    pub hidden: bool,
}

/// All there is.
#[derive(Debug, Default)]
pub struct Index {
    items: Vec<Item>,
    version: u64,
    /// The state of the history that it was found in.
    state: u64,
    stale: bool,
}

/// What an entity has that is listed.
type Listed = Or<(With<Transform>, With<Material>, With<SceneId>, With<Name>)>;

/// What tells that the list may be another one.
#[derive(SystemParam)]
pub struct Gone<'w, 's> {
    poses: RemovedComponents<'w, 's, Transform>,
    materials: RemovedComponents<'w, 's, Material>,
    names: RemovedComponents<'w, 's, Name>,
    links: RemovedComponents<'w, 's, ChildOf>,
}

/// Notes that something came, went, was renamed, hidden or hung elsewhere.
pub fn watch(
    mut tree: ResMut<Tree>,
    mut gone: Gone,
    changed: Query<
        (),
        Or<(
            Added<Transform>,
            Added<Material>,
            Changed<Name>,
            Changed<SceneId>,
            Changed<ChildOf>,
            Changed<Visibility>,
        )>,
    >,
) {
    let lost = gone.poses.read().count()
        + gone.materials.read().count()
        + gone.names.read().count()
        + gone.links.read().count();
    if lost > 0 || !changed.is_empty() {
        tree.bypass_change_detection().index.stale = true;
    }
}

impl Index {
    /// All there is, in order.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Another number whenever the items may be others.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Finds all there is, if that may have changed.
    pub fn refresh(&mut self, world: &mut World, state: u64) {
        if self.version > 0 && !self.stale && self.state == state {
            return;
        }
        (self.stale, self.state) = (false, state);
        self.version += 1;
        self.items.clear();
        for root in roots(world) {
            self.add(world, root);
        }
    }

    fn add(&mut self, world: &World, root: Entity) {
        let first = self.items.len();
        let mut pending = vec![(root, 0)];
        while let Some((entity, depth)) = pending.pop() {
            let label = label(world, entity);
            self.items.push(Item {
                entity,
                depth,
                lower: label.to_lowercase(),
                label,
                below: 0,
                hidden: world.get::<Visibility>(entity).is_some_and(|v| !v.shown),
            });
            if let Some(children) = world.get::<Children>(entity) {
                pending.extend(children.iter().rev().map(|child| (child, depth + 1)));
            }
        }
        // From the end: what is below an item is up to the next one that is not deeper.
        let mut open: Vec<usize> = Vec::new();
        for row in first..self.items.len() {
            while let Some(&last) = open.last()
                && self.items[last].depth >= self.items[row].depth
            {
                open.pop();
            }
            for &above in &open {
                self.items[above].below += 1;
            }
            open.push(row);
        }
    }

    /// The rows of branches that are open.
    pub fn open_rows(&self, closed: &HashSet<Entity>) -> Vec<usize> {
        let mut rows = Vec::with_capacity(self.items.len());
        let mut at = 0;
        while let Some(item) = self.items.get(at) {
            rows.push(at);
            at += 1;
            if item.below > 0 && closed.contains(&item.entity) {
                at += item.below;
            }
        }
        rows
    }

    /// The rows with a text in their name, in lower case, that have a component if one is asked for.
    pub fn matching(&self, world: &World, text: &str, component: Option<TypeId>) -> Vec<usize> {
        let registry = world.resource::<AppTypeRegistry>().read();
        let data = component.map(|id| registry.get_type_data::<ReflectComponent>(id));
        let has = |entity: Entity| match data {
            None => true,
            Some(data) => data.is_some_and(|data| {
                world
                    .get_entity(entity)
                    .is_ok_and(|entity| data.contains(entity))
            }),
        };
        let items = self.items.iter().enumerate();
        items
            .filter(|(_, item)| item.lower.contains(text) && has(item.entity))
            .map(|(row, _)| row)
            .collect()
    }
}

/// What has no parent: entities in the order of the scene's file, what the file does not have, then materials.
fn roots(world: &mut World) -> Vec<Entity> {
    let order = world
        .get_resource::<SceneRoots>()
        .cloned()
        .unwrap_or_default();
    let ranks: HashMap<Entity, usize> = order
        .entities
        .iter()
        .chain(&order.materials)
        .enumerate()
        .map(|(rank, &entity)| (entity, rank))
        .collect();
    let mut query = world.query_filtered::<(Entity, Has<Material>), (Listed, Without<ChildOf>)>();
    let mut roots: Vec<(bool, usize, Entity)> = query
        .iter(world)
        .map(|(entity, material)| {
            let rank = ranks.get(&entity).copied().unwrap_or(usize::MAX);
            (material, rank, entity)
        })
        .collect();
    roots.sort_unstable();
    roots.into_iter().map(|(.., entity)| entity).collect()
}
