//! The timeline at work: once a frame, in `FrameSet::Animate`, it writes the fields it keys.
//!
//! A pose is a pure function of [`Time::secs`]: no state is carried from frame to frame, so frame N is the
//! same however it was reached, and after a loop it is the same bit for bit. The order within a frame:
//! tracks, then positions of paths, then what paths look at, each after the movers above it or its target.
//! A frame at the same time as the last writes nothing, so that a paused scene can be edited.

mod curve;
mod look;

pub use curve::Curve;
pub(super) use look::sorted;

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::fields::{self, Field, FieldError, Value};
use super::schema;
use super::spawn::Imported;
use crate::time::Time;
use crate::world::Transform;
use look::Look;

/// What moves by itself; empty: nothing does.
#[derive(Resource, Default, Debug)]
pub struct Timeline {
    /// As it was read, for saving.
    pub source: schema::Timeline,
    tracks: Vec<TrackPlayer>,
    paths: Vec<PathPlayer>,
    /// Paths that look at something, in an order in which each finds its world position settled.
    looks: Vec<Look>,
    /// Bits of the time last written; none: not yet.
    played: Option<u64>,
}

#[derive(Debug)]
struct TrackPlayer {
    entity: Entity,
    field: &'static Field,
    curve: Curve,
}

#[derive(Debug)]
struct PathPlayer {
    entity: Entity,
    curve: Curve,
}

/// Entities by id, as tracks name them.
#[derive(Default, Debug)]
pub(super) struct Ids {
    pub entities: HashMap<String, Entity>,
    pub materials: HashMap<String, Entity>,
}

impl Timeline {
    /// Compiles a checked timeline to fields and curves; a target that is not there is left out.
    pub(super) fn compile(source: schema::Timeline, ids: &Ids, world: &World) -> Self {
        let tracks = source.tracks.iter().filter_map(|track| {
            let field = fields::find(&track.field.value).ok()?;
            let entity = *ids.table(field).get(&track.target.value)?;
            Some(TrackPlayer {
                entity: holder(world, field, entity),
                field,
                curve: Curve::new(&track.keys, track.repeat)?,
            })
        });
        let paths = source.paths.iter().filter_map(|path| {
            Some(PathPlayer {
                entity: *ids.entities.get(&path.target.value)?,
                curve: Curve::new(&path.keys, path.repeat)?,
            })
        });
        Self {
            tracks: tracks.collect(),
            paths: paths.collect(),
            looks: look::ordered(&source.paths, ids, world),
            source,
            played: None,
        }
    }
}

impl Timeline {
    /// The timeline without what is about entities and components that are gone: what a scene file may have.
    pub(super) fn of_what_is_there(&self, world: &World, ids: &Ids) -> schema::Timeline {
        let mut source = self.source.clone();
        source.tracks.retain(|track| {
            fields::find(&track.field.value).is_ok_and(|field| {
                let entity = ids.table(field).get(&track.target.value);
                entity.is_some_and(|&entity| field.is_on(world, holder(world, field, entity)))
            })
        });
        let is_there = |id: &str| ids.entities.contains_key(id);
        source.paths.retain(|path| is_there(&path.target.value));
        for path in &mut source.paths {
            if let Some(schema::LookAt::Entity(id)) = &path.look_at
                && !is_there(&id.value)
            {
                path.look_at = None;
            }
        }
        source
    }
}

impl Ids {
    /// Where the ids of a field's entities are.
    fn table(&self, field: &Field) -> &HashMap<String, Entity> {
        if field.is_material() {
            &self.materials
        } else {
            &self.entities
        }
    }
}

/// The entity that has a field of an id's entity: what deforms a model of one part is where the part is, which may be below.
fn holder(world: &World, field: &Field, entity: Entity) -> Entity {
    if !field.path.starts_with("deform.") {
        return entity;
    }
    let mut below = vec![entity];
    while let Some(next) = below.pop() {
        if field.get(world, next).is_some() {
            return next;
        }
        let children = world
            .get::<Children>(next)
            .map_or(&[][..], |children| children);
        // What the scene names below it has ids of its own.
        let imported = |child: &Entity| world.get::<Imported>(*child).is_some();
        below.extend(children.iter().copied().filter(imported));
    }
    entity
}

/// Time of the last key of all.
pub(super) fn last_key(timeline: &schema::Timeline) -> f64 {
    let tracks = timeline.tracks.iter().map(|track| &track.keys);
    let paths = timeline.paths.iter().map(|path| &path.keys);
    tracks
        .chain(paths)
        .filter_map(|keys| keys.last())
        .fold(0.0, |last, key| last.max(key.time))
}

/// Writes the fields of this frame's time; a system of [`crate::schedule::FrameSet::Animate`].
pub fn play_timeline(world: &mut World) {
    let secs = world.resource::<Time>().secs;
    let timeline = world.resource::<Timeline>();
    if timeline.played == Some(secs.to_bits()) || timeline.source == schema::Timeline::default() {
        return;
    }
    world.resource_scope(|world, mut timeline: Mut<Timeline>| {
        timeline.played = Some(secs.to_bits());
        pose(world, &timeline, secs);
    });
}

/// Puts the world into the pose of a time.
fn pose(world: &mut World, timeline: &Timeline, secs: f64) {
    let secs = match timeline.source.length {
        Some(length) => secs.rem_euclid(length),
        None => secs,
    };
    for track in &timeline.tracks {
        write(world, track.field, track.entity, &track.curve, secs);
    }
    for path in &timeline.paths {
        write(world, fields::position(), path.entity, &path.curve, secs);
    }
    for look in &timeline.looks {
        look.turn(world);
    }
}

/// Writes a curve's value at a time. Where it overshoots what the field may hold, the nearer key, which
/// was checked at load, stands in: to keep what is there would let the pose depend on the frame before.
fn write(world: &mut World, field: &Field, entity: Entity, curve: &Curve, secs: f64) {
    // An entity that lost the component, or is gone, is left alone.
    if let Err(FieldError::BadValue { .. }) = field.set(world, entity, &curve.at(secs)) {
        let _ = field.set(world, entity, &curve.nearer_key(secs));
    }
}

/// The value of a rotation field from a pose.
fn set_rotation(world: &mut World, entity: Entity, pose: &Transform) {
    if let Ok(field) = fields::find("transform.rotation") {
        let _ = field.set(world, entity, &Value::Rotation(pose.rotation));
    }
}

/// World position of an entity's origin from this frame's transforms.
fn world_position(world: &World, entity: Entity) -> DVec3 {
    look::global(world, entity).translation
}

#[cfg(test)]
mod tests;
