//! Entities to a scene file. What is saved is what has a [`SceneId`].

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;

use super::reader::Schema;
use super::schema::{
    self, At, BackgroundFile, ClipFile, Deform, KeysFile, Light, MaterialFile, MeshFile, MorphFile,
    Motion, Pose, Scene, Shape, TextureFile,
};
use super::spawn::{Imported, MeshSource, PoseFiles, SceneRoots};
use super::timeline::{Ids, Timeline};
use super::writer::Writer;
use crate::world::{
    ActiveCamera, Background, Camera, ClipLayer, ClipPlayer, Cone, Cuboid, Cylinder,
    DirectionalLight, Disc, KeyFrames, Material, Morph, Plane, PointLight, Polygon, Rest, SceneId,
    Shear, Sphere, SpotLight, Surface, TextureId, Textures, Torus, TraceDepth, Transform,
    Visibility,
};

/// The scene as the text of a scene file. Loading it gives the same components, bit for bit.
///
/// Entities without a [`SceneId`] are not part of the scene. Poses are those of this moment, of things in motion
/// those they start from; the timeline overrides what it keys. Numbers that are not finite are written as they are, and loading names them.
pub fn save(world: &mut World) -> String {
    text_of(&describe(world))
}

/// The text of a scene file that has these values.
pub fn text_of(scene: &Scene) -> String {
    let mut writer = Writer::pretty();
    scene.write(&mut writer);
    let mut text = writer.finish();
    text.push('\n');
    text
}

/// The scene as values of the file.
pub fn describe(world: &mut World) -> Scene {
    let roots = world
        .get_resource::<SceneRoots>()
        .cloned()
        .unwrap_or_default();
    let mut query = world.query_filtered::<(Entity, Has<Material>), With<SceneId>>();
    let (mut materials, mut entities): (Vec<Entity>, Vec<Entity>) = (Vec::new(), Vec::new());
    for (entity, material) in query.iter(world) {
        if material {
            &mut materials
        } else {
            &mut entities
        }
        .push(entity);
    }
    let world = &*world;
    let ids = Ids {
        entities: by_id(world, &entities),
        materials: by_id(world, &materials),
    };
    let saved: HashSet<Entity> = entities.iter().copied().collect();
    entities.retain(|&entity| {
        let parent = world.get::<ChildOf>(entity).map(ChildOf::parent);
        parent.is_none_or(|parent| !saved.contains(&parent))
    });
    let active = world
        .get_resource::<ActiveCamera>()
        .and_then(|active| active.0);
    Scene {
        background: background_of(world),
        max_generations: world
            .get_resource::<TraceDepth>()
            .copied()
            .unwrap_or_default()
            .0,
        active_camera: active.and_then(|entity| id_of(world, entity)),
        materials: in_order(materials, &roots.materials)
            .into_iter()
            .filter_map(|entity| Some((id_of(world, entity)?, material_of(world, entity)?)))
            .collect(),
        entities: in_order(entities, &roots.entities)
            .into_iter()
            .map(|entity| describe_entity(world, entity))
            .collect(),
        timeline: world
            .get_resource::<Timeline>()
            .map(|timeline| timeline.of_what_is_there(world, &ids))
            .unwrap_or_default(),
    }
}

fn by_id(world: &World, entities: &[Entity]) -> HashMap<String, Entity> {
    let id = |&entity: &Entity| Some((world.get::<SceneId>(entity)?.0.clone(), entity));
    entities.iter().filter_map(id).collect()
}

/// The entities in the order of the file they came from; new ones after them.
fn in_order(mut entities: Vec<Entity>, file: &[Entity]) -> Vec<Entity> {
    let ranks: HashMap<Entity, usize> = file.iter().enumerate().map(|(i, &e)| (e, i)).collect();
    entities.sort_by_key(|entity| (ranks.get(entity).copied().unwrap_or(usize::MAX), *entity));
    entities
}

fn background_of(world: &World) -> BackgroundFile {
    let background = world.get_resource::<Background>().copied();
    let background = background.unwrap_or_default();
    let texture = |id| world.get_resource::<Textures>()?.get(id);
    let panorama = background.picture.and_then(texture);
    BackgroundFile {
        picture: panorama.map(|panorama| panorama.path.clone().into()),
        background: Background {
            picture: None,
            ..background
        },
    }
}

/// Pictures that came from no file of the scene's are left out: there is nothing to load them from.
fn material_of(world: &World, entity: Entity) -> Option<MaterialFile> {
    let material = *world.get::<Material>(entity)?;
    let file_of = |id: Option<TextureId>| {
        let texture = world.get_resource::<Textures>()?.get(id?)?;
        (!texture.path.is_empty()).then(|| TextureFile {
            path: texture.path.clone().into(),
            wrap: texture.wrap,
        })
    };
    Some(MaterialFile {
        color_map: file_of(material.color_map),
        normal_map: file_of(material.normal_map),
        material: Material {
            color_map: None,
            normal_map: None,
            ..material
        },
    })
}

fn id_of(world: &World, entity: Entity) -> Option<At<String>> {
    world.get::<SceneId>(entity).map(|id| id.0.clone().into())
}

fn describe_entity(world: &World, entity: Entity) -> schema::Entity {
    let id = id_of(world, entity);
    let name = world
        .get::<Name>(entity)
        .map(|name| name.as_str().to_owned());
    let children = world.get::<Children>(entity);
    let children = children.into_iter().flat_map(|children| children.iter());
    schema::Entity {
        name: name.filter(|name| id.as_ref().is_none_or(|id| id.value != *name)),
        id,
        hidden: world.get::<Visibility>(entity).is_some_and(|v| !v.shown),
        pose: Pose {
            transform: at_rest(world, entity),
            shear: world.get::<Shear>(entity).copied(),
        },
        shape: shape_of(world, entity),
        deform: deform_of(world, entity),
        clips: clips_of(world, entity),
        structure: of_part(world, entity),
        motion: Motion {
            orbit: world.get(entity).copied(),
            spin: world.get(entity).copied(),
            sway: world.get(entity).copied(),
            path: world.get(entity).cloned(),
        },
        material: world
            .get::<Surface>(entity)
            .and_then(|surface| id_of(world, surface.0)),
        light: light_of(world, entity),
        camera: world.get::<Camera>(entity).copied(),
        children: children
            .filter(|&child| {
                world.get::<SceneId>(child).is_some() && world.get::<Material>(child).is_none()
            })
            .map(|child| describe_entity(world, child))
            .collect(),
    }
}

/// The pose as the file has it: where motion starts from.
fn at_rest(world: &World, entity: Entity) -> Transform {
    match world.get::<Rest>(entity) {
        Some(Rest(pose)) => *pose,
        None => world.get::<Transform>(entity).copied().unwrap_or_default(),
    }
}

/// A component of an entity, or of the first thing of its model file that has it.
fn of_part<T: Component + Clone>(world: &World, entity: Entity) -> Option<T> {
    let own = world.get::<T>(entity).cloned();
    own.or_else(|| {
        let parts = world.get::<Children>(entity)?.iter();
        let mut imported = parts.filter(|&part| world.get::<Imported>(part).is_some());
        imported.find_map(|part| of_part(world, part))
    })
}

/// Poses that came from no file are left out: there is nothing to load them from.
fn deform_of(world: &World, entity: Entity) -> Deform {
    let files = world.get::<PoseFiles>(entity).cloned().unwrap_or_default();
    let named =
        |files: Vec<String>| -> Vec<At<String>> { files.into_iter().map(At::from).collect() };
    let keys: Option<KeyFrames> = of_part(world, entity).filter(|_| !files.keys.is_empty());
    let morph: Option<Morph> = of_part(world, entity).filter(|_| !files.morph.is_empty());
    Deform {
        keys: keys.map(|keys| KeysFile {
            poses: named(files.keys),
            times: keys.times,
            start: keys.start,
            speed: keys.speed,
            repeat: keys.repeat,
        }),
        morph: morph.map(|morph| MorphFile {
            targets: named(files.morph),
            weights: morph.weights,
        }),
        wave: of_part(world, entity),
        twist: of_part(world, entity),
    }
}

/// The clips that play, by name.
fn clips_of(world: &World, entity: Entity) -> Vec<ClipFile> {
    let Some(player) = world.get::<ClipPlayer>(entity) else {
        return Vec::new();
    };
    let clip = |layer: &ClipLayer| {
        let clip = player.clips.clips().get(layer.clip)?;
        Some(ClipFile {
            name: Some(clip.name.clone().into()),
            layer: *layer,
        })
    };
    player.layers.iter().filter_map(clip).collect()
}

fn shape_of(world: &World, entity: Entity) -> Option<Shape> {
    let mesh = world.get::<MeshSource>(entity).map(|source| {
        Shape::Mesh(MeshFile {
            path: source.path.clone().into(),
            smooth_angle: source.smooth_angle,
        })
    });
    mesh.or_else(|| world.get::<Polygon>(entity).cloned().map(Shape::Polygon))
        .or_else(|| world.get::<Sphere>(entity).copied().map(Shape::Sphere))
        .or_else(|| world.get::<Plane>(entity).copied().map(Shape::Plane))
        .or_else(|| world.get::<Cuboid>(entity).copied().map(Shape::Box))
        .or_else(|| world.get::<Disc>(entity).copied().map(Shape::Disc))
        .or_else(|| world.get::<Cylinder>(entity).copied().map(Shape::Cylinder))
        .or_else(|| world.get::<Cone>(entity).copied().map(Shape::Cone))
        .or_else(|| world.get::<Torus>(entity).copied().map(Shape::Torus))
}

fn light_of(world: &World, entity: Entity) -> Option<Light> {
    let point = world.get::<PointLight>(entity).copied().map(Light::Point);
    point
        .or_else(|| {
            world
                .get::<DirectionalLight>(entity)
                .copied()
                .map(Light::Directional)
        })
        .or_else(|| world.get::<SpotLight>(entity).copied().map(Light::Spot))
}
