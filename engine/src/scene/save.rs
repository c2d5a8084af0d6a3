//! Entities to a scene file. What is saved is what has a [`SceneId`].

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;

use super::reader::Schema;
use super::schema::{self, At, Light, MeshFile, Pose, Scene, Shape};
use super::spawn::{MeshSource, SceneRoots};
use super::timeline::Timeline;
use super::writer::Writer;
use crate::world::{
    ActiveCamera, Background, Camera, Cuboid, DirectionalLight, Material, Plane, PointLight,
    Polygon, SceneId, Shear, Sphere, SpotLight, Surface, TraceDepth, Transform, Visibility,
};

/// The scene as the text of a scene file. Loading it gives the same components, bit for bit.
///
/// Entities without a [`SceneId`] are not part of the scene. Poses are those of this moment; the timeline
/// overrides what it keys. Numbers that are not finite are written as they are, and loading names them.
pub fn save(world: &mut World) -> String {
    let mut writer = Writer::pretty();
    describe(world).write(&mut writer);
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
    let saved: HashSet<Entity> = entities.iter().copied().collect();
    entities.retain(|&entity| {
        let parent = world.get::<ChildOf>(entity).map(ChildOf::parent);
        parent.is_none_or(|parent| !saved.contains(&parent))
    });
    let active = world
        .get_resource::<ActiveCamera>()
        .and_then(|active| active.0);
    Scene {
        background: world
            .get_resource::<Background>()
            .copied()
            .unwrap_or_default()
            .0,
        max_generations: world
            .get_resource::<TraceDepth>()
            .copied()
            .unwrap_or_default()
            .0,
        active_camera: active.and_then(|entity| id_of(world, entity)),
        materials: in_order(materials, &roots.materials)
            .into_iter()
            .filter_map(|entity| Some((id_of(world, entity)?, *world.get::<Material>(entity)?)))
            .collect(),
        entities: in_order(entities, &roots.entities)
            .into_iter()
            .map(|entity| describe_entity(world, entity))
            .collect(),
        timeline: world
            .get_resource::<Timeline>()
            .map(|timeline| timeline.source.clone())
            .unwrap_or_default(),
    }
}

/// The entities in the order of the file they came from; new ones after them.
fn in_order(mut entities: Vec<Entity>, file: &[Entity]) -> Vec<Entity> {
    let ranks: HashMap<Entity, usize> = file.iter().enumerate().map(|(i, &e)| (e, i)).collect();
    entities.sort_by_key(|entity| (ranks.get(entity).copied().unwrap_or(usize::MAX), *entity));
    entities
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
            transform: world.get::<Transform>(entity).copied().unwrap_or_default(),
            shear: world.get::<Shear>(entity).copied(),
        },
        shape: shape_of(world, entity),
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
