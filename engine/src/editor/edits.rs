//! Edits: what an inspector wants changed, queued and applied in one place.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::{GetPath, PartialReflect, Reflect};

use crate::time::Time;
use crate::world::ClipPlayer;

/// A wish to change one field of one component of one entity.
#[derive(Debug)]
pub struct Edit {
    /// Whose.
    pub entity: Entity,
    /// Which component.
    pub component: TypeId,
    /// Where in the component, as bevy_reflect writes paths (".translation"); empty: all of it.
    pub path: String,
    /// What it is to become.
    pub value: Box<dyn PartialReflect>,
}

/// Edits that wait for [`crate::schedule::FrameSet::Edit`], in order.
#[derive(Resource, Debug, Default)]
pub struct EditQueue(pub Vec<Edit>);

/// Applies all queued edits. An equal value is no change and leaves the change ticks alone.
pub(super) fn apply_edits(world: &mut World) {
    let edits = std::mem::take(&mut world.resource_mut::<EditQueue>().0);
    for edit in edits {
        let player = |world: &World| world.get::<ClipPlayer>(edit.entity).cloned();
        let before = player(world).filter(|_| edit.path.ends_with(".paused"));
        if let Err(why) = apply(world, &edit) {
            tracing::warn!("an edit of {}{} failed: {why}", edit.entity, edit.path);
        }
        keep_pose(world, edit.entity, before);
    }
}

/// What is paused by hand stands where it is, and goes on from there.
fn keep_pose(world: &mut World, entity: Entity, before: Option<ClipPlayer>) {
    let secs = world.get_resource::<Time>().map_or(0.0, |time| time.secs);
    let player = world.get_mut::<ClipPlayer>(entity);
    if let Some((mut player, before)) = player.zip(before)
        && *player != before
    {
        player.keep_poses(&before.layers, secs);
    }
}

fn apply(world: &mut World, edit: &Edit) -> Result<(), String> {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let component = registry
        .get_type_data::<ReflectComponent>(edit.component)
        .ok_or("its component is not reflected")?;
    let mut entity = world
        .get_entity_mut(edit.entity)
        .map_err(|_| "the entity is gone".to_owned())?;
    let now = component
        .reflect(&entity)
        .ok_or("the entity has no such component")?;
    let field = at(now, &edit.path)?;
    if field.reflect_partial_eq(&*edit.value) == Some(true) {
        return Ok(());
    }
    let mut target = component
        .reflect_mut(&mut entity)
        .ok_or("the component cannot be changed in place")?;
    let field = if edit.path.is_empty() {
        target.as_partial_reflect_mut()
    } else {
        target
            .reflect_path_mut(edit.path.as_str())
            .map_err(|error| error.to_string())?
    };
    field
        .try_apply(&*edit.value)
        .map_err(|error| error.to_string())
}

fn at<'a>(root: &'a dyn Reflect, path: &str) -> Result<&'a dyn PartialReflect, String> {
    if path.is_empty() {
        return Ok(root.as_partial_reflect());
    }
    root.reflect_path(path).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use bevy_reflect::enums::DynamicEnum;
    use bevy_reflect::tuple::DynamicTuple;
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::app::Engine;
    use crate::world::{Camera, ClipLayer};
    use crate::world::{Lobe, Material, Projection, Reflection, Transform};

    fn edited<C: Component>(
        engine: &mut Engine,
        entity: Entity,
        path: &str,
        value: impl PartialReflect,
    ) -> bool {
        engine.world.clear_trackers();
        let mut queue = engine.world.get_resource_or_init::<EditQueue>();
        queue.0.push(Edit {
            entity,
            component: TypeId::of::<C>(),
            path: path.into(),
            value: Box::new(value),
        });
        apply_edits(&mut engine.world);
        let entity = engine.world.entity(entity);
        entity
            .get_ref::<C>()
            .is_some_and(|component| component.is_changed())
    }

    #[test]
    fn a_field_is_changed_and_an_equal_value_is_no_change() {
        let mut engine = Engine::new();
        let entity = engine.world.spawn(Transform::IDENTITY).id();
        let there = DVec3::new(1.0, 2.0, 3.0);
        assert!(edited::<Transform>(
            &mut engine,
            entity,
            ".translation",
            there
        ));
        assert_eq!(
            engine.world.get::<Transform>(entity).unwrap().translation,
            there
        );
        assert!(!edited::<Transform>(
            &mut engine,
            entity,
            ".translation",
            there
        ));
        assert!(edited::<Transform>(&mut engine, entity, ".scale.y", 2.5));
        assert_eq!(engine.world.get::<Transform>(entity).unwrap().scale.y, 2.5);
    }

    #[test]
    fn enums_change_their_variant_and_the_fields_within() {
        let mut engine = Engine::new();
        let entity = engine
            .world
            .spawn((Material::default(), Camera::default()))
            .id();
        let mut color = DynamicTuple::default();
        color.insert(Vec3::splat(0.5));
        let constant = DynamicEnum::new("Constant", color);
        assert!(edited::<Material>(
            &mut engine,
            entity,
            ".reflection",
            constant
        ));
        let mut lobe = DynamicTuple::default();
        lobe.insert(Lobe::default());
        assert!(edited::<Material>(
            &mut engine,
            entity,
            ".phong",
            DynamicEnum::new("Some", lobe)
        ));
        assert!(edited::<Material>(
            &mut engine,
            entity,
            ".phong.0.exponent",
            7.0_f32
        ));
        let material = engine.world.get::<Material>(entity).unwrap();
        assert_eq!(material.reflection, Reflection::Constant(Vec3::splat(0.5)));
        assert_eq!(material.phong.map(|lobe| lobe.exponent), Some(7.0));
        assert!(edited::<Camera>(
            &mut engine,
            entity,
            ".projection.vertical_fov",
            1.0
        ));
        let camera = engine.world.get::<Camera>(entity).unwrap();
        assert_eq!(
            camera.projection,
            Projection::Perspective { vertical_fov: 1.0 }
        );
    }

    #[test]
    fn a_clip_that_is_paused_stands_where_it_is_and_goes_on_from_there() {
        let mut engine = Engine::new();
        engine.world.resource_mut::<Time>().secs = 3.0;
        let layer = ClipLayer {
            start: 0.5,
            speed: 2.0,
            ..ClipLayer::default()
        };
        let player = ClipPlayer {
            layers: vec![layer],
            ..ClipPlayer::default()
        };
        let entity = engine.world.spawn(player).id();
        let path = ".layers[0].paused";
        assert!(edited::<ClipPlayer>(&mut engine, entity, path, true));
        let start =
            |engine: &Engine| engine.world.get::<ClipPlayer>(entity).unwrap().layers[0].start;
        assert_eq!(start(&engine), 6.5);
        engine.world.resource_mut::<Time>().secs = 5.0;
        assert!(edited::<ClipPlayer>(&mut engine, entity, path, false));
        assert_eq!(start(&engine) + 2.0 * 5.0, 6.5);
    }

    #[test]
    fn an_edit_that_cannot_be_is_refused_and_changes_nothing() {
        let mut engine = Engine::new();
        let entity = engine.world.spawn(Transform::IDENTITY).id();
        assert!(!edited::<Transform>(&mut engine, entity, ".nowhere", 1.0));
        engine.world.despawn(entity);
        engine.world.resource_mut::<EditQueue>().0.push(Edit {
            entity,
            component: TypeId::of::<Transform>(),
            path: ".translation".into(),
            value: Box::new(DVec3::ONE),
        });
        apply_edits(&mut engine.world);
        assert!(engine.world.resource::<EditQueue>().0.is_empty());
    }
}
