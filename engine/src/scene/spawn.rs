//! A resolved scene to entities, and away with them again.

mod clips;
mod deform;
mod model;

pub use deform::PoseFiles;
use deform::{Poses, deform_by_formula, files_of};
use model::Stored;

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;

use glam::DVec3;

use super::resolve::{MeshKey, PoseKey, Resolved, TextureKey, pictures, texture_key};
use super::schema::{self, Light, MaterialFile, Motion, Shape};
use super::timeline::{Ids, Timeline};
use crate::import::Model;
use crate::world::{
    ActiveCamera, Background, Framing, Material, Mesh, MeshId, Meshes, SceneId, Surface, Texture,
    TextureId, Textures, TraceDepth, Visibility,
};

/// The model file an entity shows. A single thing stands on the entity itself, several on children that are
/// [`Imported`].
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
pub struct MeshSource {
    /// As the scene file has it.
    pub path: String,
    /// Degrees; see `smooth_angle` in the manual.
    pub smooth_angle: Option<f64>,
}

/// Made from a file the scene names: saving leaves it out, loading makes it again.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Imported;

/// Order of the scene's entities in its file.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneRoots {
    /// Entities of the material table.
    pub materials: Vec<Entity>,
    /// Entities without a parent.
    pub entities: Vec<Entity>,
}

/// Removes all that came from a scene file, frees its meshes and textures and resets background, depth and timeline.
pub fn unload(world: &mut World) {
    let meshes = used_meshes(world, true);
    let mut query = world.query_filtered::<Entity, Or<(With<SceneId>, With<Imported>)>>();
    let entities: Vec<Entity> = query.iter(world).collect();
    for entity in entities {
        // A child is gone with its parent.
        if world.entities().contains(entity) {
            world.despawn(entity);
        }
    }
    let kept = used_meshes(world, false);
    let mut store = world.get_resource_or_init::<Meshes>();
    for id in meshes.difference(&kept) {
        store.remove(*id);
    }
    let mut materials = world.query::<&Material>();
    let shown = materials
        .iter(world)
        .flat_map(|material| [material.color_map, material.normal_map]);
    let shown: HashSet<TextureId> = shown.flatten().collect();
    world.get_resource_or_init::<Textures>().retain(&shown);
    world.insert_resource(Background::default());
    world.insert_resource(TraceDepth::default());
    world.insert_resource(ActiveCamera::default());
    world.remove_resource::<Framing>();
    world.insert_resource(Timeline::default());
    world.insert_resource(SceneRoots::default());
}

/// Meshes of files that entities show: those of the scene, or all. Polygons free their own.
fn used_meshes(world: &mut World, of_scene: bool) -> HashSet<MeshId> {
    let mut query = world.query::<(&Mesh, Has<SceneId>, Has<Imported>)>();
    query
        .iter(world)
        .filter(|(_, scene, imported)| !of_scene || *scene || *imported)
        .map(|(mesh, ..)| mesh.0)
        .collect()
}

/// Puts a scene into a world that has none.
pub fn spawn(world: &mut World, resolved: Resolved) {
    let Resolved {
        scene,
        models,
        poses,
        textures,
        sky,
    } = resolved;
    let textures = store_textures(world, textures);
    let mut store = world.get_resource_or_init::<Textures>();
    let background = Background {
        picture: sky.map(|sky| store.add(sky)),
        ..scene.background.background
    };
    world.insert_resource(background);
    world.insert_resource(TraceDepth(scene.max_generations));
    let mut spawner = Spawner::new(models, poses);
    spawner.take_ids(&scene.entities);
    let mut roots = SceneRoots::default();
    for (id, file) in &scene.materials {
        let material = material_of(file, &textures);
        let name = Name::new(id.value.clone());
        let entity = world
            .spawn((SceneId(id.value.clone()), name, material))
            .id();
        spawner.ids.materials.insert(id.value.clone(), entity);
        roots.materials.push(entity);
    }
    for entity in &scene.entities {
        roots.entities.push(spawner.entity(world, entity, None));
    }
    let active = scene
        .active_camera
        .and_then(|id| spawner.ids.entities.get(&id.value).copied());
    world.insert_resource(ActiveCamera(active));
    let timeline = Timeline::compile(scene.timeline, &spawner.ids, world);
    world.insert_resource(timeline);
    world.insert_resource(roots);
}

/// Adds the entities of a scene to the one that is there, and nothing else of it; these, and the materials of their files.
pub fn add(world: &mut World, resolved: Resolved) -> (Vec<Entity>, Vec<Entity>) {
    let mut spawner = Spawner::new(resolved.models, resolved.poses);
    let mut ids = world.query::<&SceneId>();
    spawner.taken = ids.iter(world).map(|id| id.0.clone()).collect();
    let entities = resolved.scene.entities.iter();
    let entities = entities.map(|entity| spawner.entity(world, entity, None));
    let entities = entities.collect();
    (entities, spawner.imported.into_values().collect())
}

/// Puts pictures into the store; those that could not be read are left out.
fn store_textures(
    world: &mut World,
    textures: HashMap<TextureKey, Option<Texture>>,
) -> HashMap<TextureKey, TextureId> {
    let mut store = world.get_resource_or_init::<Textures>();
    let mut stored = HashMap::new();
    // By name: the order of a hash map would give textures other rows from run to run.
    let mut textures: Vec<_> = textures.into_iter().collect();
    textures.sort_by_key(|(key, _)| format!("{key:?}"));
    for (key, texture) in textures {
        if let Some(texture) = texture {
            stored.insert(key, store.add(texture));
        }
    }
    stored
}

/// A material of the scene file with its pictures.
fn material_of(file: &MaterialFile, textures: &HashMap<TextureKey, TextureId>) -> Material {
    let maps = pictures(file);
    let [color_map, normal_map] = maps
        .map(|(map, space)| map.and_then(|map| textures.get(&texture_key(map, space)).copied()));
    Material {
        color_map,
        normal_map,
        ..file.material
    }
}

struct Spawner {
    models: HashMap<MeshKey, Model>,
    poses: Poses,
    stored: HashMap<MeshKey, Stored>,
    /// Materials of a file that the scene does not name itself, by their rows: names may repeat.
    imported: HashMap<(String, usize), Entity>,
    taken: HashSet<String>,
    ids: Ids,
}

impl Spawner {
    fn new(models: HashMap<MeshKey, Model>, poses: HashMap<PoseKey, Vec<Vec<DVec3>>>) -> Self {
        Self {
            models,
            poses: Poses {
                read: poses,
                ..Poses::default()
            },
            stored: HashMap::new(),
            imported: HashMap::new(),
            taken: HashSet::new(),
            ids: Ids::default(),
        }
    }

    fn take_ids(&mut self, entities: &[schema::Entity]) {
        for entity in entities {
            self.taken
                .extend(entity.id.as_ref().map(|id| id.value.clone()));
            self.take_ids(&entity.children);
        }
    }

    /// The entity's id, or the first free one of its kind.
    fn id_of(&mut self, entity: &schema::Entity) -> String {
        if let Some(id) = &entity.id {
            return id.value.clone();
        }
        let kind = match (&entity.shape, &entity.light, &entity.camera) {
            (Some(shape), ..) => shape.name(),
            (None, Some(_), _) => "light",
            (None, None, Some(_)) => "camera",
            (None, None, None) => "group",
        };
        let mut number = self.taken.len() + 1;
        loop {
            let id = format!("{kind} {number}");
            if self.taken.insert(id.clone()) {
                return id;
            }
            number += 1;
        }
    }

    fn entity(
        &mut self,
        world: &mut World,
        file: &schema::Entity,
        parent: Option<Entity>,
    ) -> Entity {
        let id = self.id_of(file);
        let name = file.name.clone().unwrap_or_else(|| id.clone());
        let entity = world
            .spawn((
                SceneId(id.clone()),
                Name::new(name),
                file.pose.transform,
                Visibility {
                    shown: !file.hidden,
                },
            ))
            .id();
        self.ids.entities.insert(id, entity);
        let material = file
            .material
            .as_ref()
            .and_then(|id| self.ids.materials.get(&id.value));
        let material = material.copied();
        let mut spawned = world.entity_mut(entity);
        if let Some(parent) = parent {
            spawned.insert(ChildOf(parent));
        }
        if let Some(shear) = file.pose.shear {
            spawned.insert(shear);
        }
        if let Some(material) = material {
            spawned.insert(Surface(material));
        }
        match file.light {
            Some(Light::Point(light)) => drop(spawned.insert(light)),
            Some(Light::Directional(light)) => drop(spawned.insert(light)),
            Some(Light::Spot(light)) => drop(spawned.insert(light)),
            None => {}
        }
        if let Some(camera) = file.camera {
            spawned.insert(camera);
        }
        if let Some(files) = files_of(&file.deform) {
            spawned.insert(files);
        }
        insert_motion(&mut spawned, &file.motion);
        match &file.shape {
            Some(Shape::Sphere(sphere)) => drop(spawned.insert(*sphere)),
            Some(Shape::Plane(plane)) => drop(spawned.insert(*plane)),
            Some(Shape::Box(cuboid)) => drop(spawned.insert(*cuboid)),
            Some(Shape::Disc(disc)) => drop(spawned.insert(*disc)),
            Some(Shape::Cylinder(cylinder)) => drop(spawned.insert(*cylinder)),
            Some(Shape::Cone(cone)) => drop(spawned.insert(*cone)),
            Some(Shape::Torus(torus)) => drop(spawned.insert(*torus)),
            Some(Shape::Polygon(polygon)) => {
                spawned.insert(polygon.clone());
                if let Some(structure) = file.structure {
                    spawned.insert(structure);
                }
                deform_by_formula(world, entity, &file.deform);
            }
            Some(Shape::Mesh(mesh)) => self.model(world, entity, (file, mesh), material),
            None => {}
        }
        for child in &file.children {
            self.entity(world, child, Some(entity));
        }
        entity
    }

    /// The entity of a file's material; one of the same name in the scene file stands in for it.
    fn imported_material(
        &mut self,
        world: &mut World,
        path: &str,
        (row, (name, material)): (usize, &(String, Material)),
    ) -> Entity {
        if let Some(&own) = self.ids.materials.get(name) {
            return own;
        }
        *self
            .imported
            .entry((path.to_owned(), row))
            .or_insert_with(|| {
                world
                    .spawn((Name::new(name.clone()), *material, Imported))
                    .id()
            })
    }
}

fn insert_motion(entity: &mut EntityWorldMut, motion: &Motion) {
    if let Some(orbit) = motion.orbit {
        entity.insert(orbit);
    }
    if let Some(spin) = motion.spin {
        entity.insert(spin);
    }
    if let Some(sway) = motion.sway {
        entity.insert(sway);
    }
    if let Some(path) = &motion.path {
        entity.insert(path.clone());
    }
}
