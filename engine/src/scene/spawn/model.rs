//! Model files to entities: each at most once in the store of meshes, however many entities show it.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::DAffine3;

use super::clips::{clip_set, own_entities, player};
use super::{Imported, MeshSource, Spawner};
use crate::import::{Content, Model, Node, Solid};
use crate::scene::resolve::{MeshKey, mesh_key};
use crate::scene::schema::{self, MeshFile};
use crate::world::{
    ClipSet, Mesh, MeshId, Meshes, Skin, Surface, TextureId, Textures, Transform, Visibility,
};

/// A model whose meshes are in the store.
#[derive(Clone)]
pub struct Stored {
    model: Arc<Model>,
    meshes: Vec<MeshId>,
    clips: Arc<ClipSet>,
    key: MeshKey,
}

/// What of the scene file goes onto every part of a model.
#[derive(Clone, Copy)]
struct Wearer<'a> {
    file: &'a schema::Entity,
    mesh: &'a MeshFile,
    material: Option<Entity>,
}

impl Spawner {
    /// What a model file holds: a single thing on the entity itself, else its nodes below it.
    pub(super) fn model(
        &mut self,
        world: &mut World,
        entity: Entity,
        (file, mesh): (&schema::Entity, &MeshFile),
        material: Option<Entity>,
    ) {
        world.entity_mut(entity).insert(MeshSource {
            path: mesh.path.value.clone(),
            smooth_angle: mesh.smooth_angle,
        });
        let Some(stored) = self.stored(world, mesh) else {
            return;
        };
        let wearer = Wearer {
            file,
            mesh,
            material,
        };
        let nodes = match stored.model.nodes.as_slice() {
            [only] if is_plain(only) && stored.clips.clips().is_empty() => vec![entity],
            nodes => spawn_nodes(world, entity, nodes),
        };
        let mut bound = Vec::new();
        let mut targets = nodes.clone();
        for (node, &place) in stored.model.nodes.iter().zip(&nodes) {
            for content in &node.contents {
                let target = if own_entities(node) == 0 {
                    place
                } else {
                    let child = spawn_child(world, place, &name_of(&stored, node, content));
                    targets.push(child);
                    child
                };
                self.content(world, target, (&stored, content), wearer);
                bound.push((target, content));
            }
        }
        for (target, content) in bound {
            bind(world, target, (&stored.model, content), &nodes);
        }
        if let Some(player) = player(&stored.clips, targets, &file.clips) {
            world.entity_mut(entity).insert(player);
        }
    }

    /// The model of a file; its meshes are stored at its first use.
    fn stored(&mut self, world: &mut World, mesh: &MeshFile) -> Option<Stored> {
        let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
        if let Some(mut model) = self.models.remove(&key) {
            let clips = std::mem::take(&mut model.clips);
            store_textures(world, &mut model);
            let mut store = world.get_resource_or_init::<Meshes>();
            let parts = model.parts.iter_mut().map(|part| {
                let mut data = std::mem::take(&mut part.mesh);
                // What children of a node are called.
                part.mesh.name.clone_from(&data.name);
                data.path.clone_from(&key.0);
                store.add(data)
            });
            let stored = Stored {
                meshes: parts.collect(),
                clips: clip_set(&model, clips),
                model: Arc::new(model),
                key: key.clone(),
            };
            self.stored.insert(key.clone(), stored);
        }
        self.stored.get(&key).cloned()
    }

    fn content(
        &mut self,
        world: &mut World,
        target: Entity,
        (stored, content): (&Stored, &Content),
        wearer: Wearer,
    ) {
        let (Content::Part { material, .. } | Content::Solid { material, .. }) = content else {
            return insert_plain(&mut world.entity_mut(target), content);
        };
        let own = material.and_then(|row| Some((row, stored.model.materials.get(row)?)));
        let surface = match (wearer.material, own) {
            (Some(material), _) => Some(material),
            (None, Some(own)) => Some(self.imported_material(world, &stored.key.0, own)),
            (None, None) => None,
        };
        let mut entity = world.entity_mut(target);
        if let Some(surface) = surface {
            entity.insert(Surface(surface));
        }
        let &Content::Part { part, .. } = content else {
            return insert_plain(&mut entity, content);
        };
        let id = stored.meshes[part];
        entity.insert(Mesh(id));
        if let Some(structure) = wearer.file.structure {
            entity.insert(structure);
        }
        let part_data = &stored.model.parts[part];
        if let Some(keys) = &part_data.keys {
            entity.insert(keys.clone());
        }
        if let Some(morph) = &part_data.morph {
            entity.insert(morph.clone());
        }
        self.deform(world, target, &wearer.file.deform, (wearer.mesh, part, id));
    }
}

/// Puts a model's pictures into the store; its materials then name them there.
fn store_textures(world: &mut World, model: &mut Model) {
    let mut store = world.get_resource_or_init::<Textures>();
    let textures = std::mem::take(&mut model.textures).into_iter();
    let rows: Vec<TextureId> = textures.map(|texture| store.add(texture)).collect();
    let stored = |row: Option<TextureId>| rows.get(row?.0 as usize).copied();
    for (_, material) in &mut model.materials {
        material.color_map = stored(material.color_map);
        material.normal_map = stored(material.normal_map);
    }
}

/// Whether a node adds nothing to what stands at it.
fn is_plain(node: &Node) -> bool {
    node.pose == Transform::IDENTITY
        && node.shear.is_none()
        && !node.hidden
        && node.contents.len() == 1
}

fn spawn_nodes(world: &mut World, root: Entity, nodes: &[Node]) -> Vec<Entity> {
    let mut entities: Vec<Entity> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let parent = node.parent.map_or(root, |row| entities[row]);
        let entity = spawn_child(world, parent, &node.name);
        let mut entity = world.entity_mut(entity);
        entity.insert((
            node.pose,
            Visibility {
                shown: !node.hidden,
            },
        ));
        if let Some(shear) = node.shear {
            entity.insert(shear);
        }
        entities.push(entity.id());
    }
    entities
}

fn spawn_child(world: &mut World, parent: Entity, name: &str) -> Entity {
    world
        .spawn((
            ChildOf(parent),
            Name::new(name.to_owned()),
            Transform::IDENTITY,
            Imported,
        ))
        .id()
}

/// The name of one of several things at a node.
fn name_of(stored: &Stored, node: &Node, content: &Content) -> String {
    match content {
        &Content::Part { part, .. } => stored.model.parts[part].mesh.name.clone(),
        _ => node.name.clone(),
    }
}

/// What needs no other row.
fn insert_plain(entity: &mut EntityWorldMut, content: &Content) {
    match *content {
        Content::Part { .. } => {}
        Content::Solid { solid, .. } => match solid {
            Solid::Sphere(sphere) => drop(entity.insert(sphere)),
            Solid::Cylinder(cylinder) => drop(entity.insert(cylinder)),
            Solid::Cone(cone) => drop(entity.insert(cone)),
        },
        Content::Point(light) => drop(entity.insert(light)),
        Content::Directional(light) => drop(entity.insert(light)),
        Content::Spot(light) => drop(entity.insert(light)),
        Content::Camera(camera) => drop(entity.insert(camera)),
    }
}

/// Ties a mesh to its joints, which are all there now.
fn bind(world: &mut World, target: Entity, (model, content): (&Model, &Content), nodes: &[Entity]) {
    let &Content::Part {
        part,
        skin: Some(skin),
        ..
    } = content
    else {
        return;
    };
    let (Some(binding), Some(joints)) = (&model.parts[part].binding, model.skins.get(skin)) else {
        return;
    };
    let joint_from_mesh: Vec<DAffine3> = joints.joint_from_mesh.clone();
    world.entity_mut(target).insert(Skin {
        binding: Arc::clone(binding),
        joints: joints.nodes.iter().map(|&row| nodes[row]).collect(),
        joint_from_mesh,
    });
}
