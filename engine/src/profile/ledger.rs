//! Why something was brought to the tracer: which components changed on which entities, which system wrote them, and what
//! that made of the tracer's buffers.
//!
//! bevy_ecs stamps every write with the tick of the system that wrote it. Ticks rise from system to system, and each knows the
//! tick of its last run: a write's tick falls into one system's run, and that one wrote it. Nothing is traced for this while
//! frames run; the ledger looks once, after the frame, and only while somebody wants it: it then asks every component of every
//! entity, which is tens of nanoseconds each.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use bevy_ecs::change_detection::Tick;
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use super::layer::short_name;
use crate::trace::{ActiveTracer, Upload};

/// Entities named of a change; of more, only how many.
pub const MOST_NAMED: usize = 8;

/// Components of the world that reach a tracer, and the buffers they reach, by the names of [`Upload`].
const REACH: [(&str, &[&str]); 27] = [
    ("Transform", &["instances", "nodes", "lights", "view"]),
    ("Shear", &["instances", "nodes"]),
    ("Visibility", &["instances", "nodes", "lights"]),
    ("Camera", &["view"]),
    ("PointLight", &["lights"]),
    ("DirectionalLight", &["lights"]),
    ("SpotLight", &["lights"]),
    ("Material", &["materials", "textures"]),
    ("Surface", &["instances"]),
    ("Mesh", &["instances", "nodes", "triangles", "vertices"]),
    ("OwnMesh", &["instances", "nodes", "triangles", "vertices"]),
    ("Structure", &["instances", "nodes"]),
    ("Sphere", &["instances", "nodes"]),
    ("Plane", &["instances", "nodes"]),
    ("Cuboid", &["instances", "nodes"]),
    ("Disc", &["instances", "nodes"]),
    ("Cylinder", &["instances", "nodes"]),
    ("Cone", &["instances", "nodes"]),
    ("Torus", &["instances", "nodes"]),
    ("Polygon", &["instances", "nodes"]),
    ("Wave", DEFORMED),
    ("Twist", DEFORMED),
    ("KeyFrames", DEFORMED),
    ("Morph", DEFORMED),
    ("Skin", DEFORMED),
    ("ClipPlayer", &["instances", "nodes"]),
    ("PoseFiles", DEFORMED),
];
const DEFORMED: &[&str] = &["nodes", "triangles", "vertices", "deformations"];

/// Writes of one system to one kind of component in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The component, module paths left out.
    pub component: Arc<str>,
    /// Who wrote; none: what is not a system, between two frames.
    pub system: Option<Arc<str>>,
    /// The first few of them.
    pub entities: Vec<Entity>,
    /// On how many entities.
    pub count: usize,
    /// Buffers it reaches.
    pub buffers: &'static [&'static str],
}

/// What changed in the last frame, and what was written for it.
#[derive(Resource, Debug, Default)]
pub struct Ledger {
    /// Somebody wants it; else nothing is looked at.
    pub wanted: bool,
    /// Those of most entities first.
    pub changes: Vec<Change>,
    /// Bytes by buffer, in the tracer's order, those of 0 left out.
    pub uploads: Vec<Upload>,
    /// What keeping it took, microseconds.
    pub micros: f64,
    /// Writes after this are of the next frame.
    since: Option<Tick>,
}

impl Ledger {
    /// Changes that reach a buffer; a tracer on the host has one of all rows.
    pub fn reasons(&self, buffer: &str) -> impl Iterator<Item = &Change> {
        let reaches = move |change: &&Change| buffer == "rows" || change.buffers.contains(&buffer);
        self.changes.iter().filter(reaches)
    }

    /// Changes that reach no buffer that was written: what they came to is what was there.
    pub fn idle(&self) -> impl Iterator<Item = &Change> {
        let buffers = || self.uploads.iter().map(|upload| upload.buffer);
        let reaches = move |change: &Change| {
            buffers().any(|buffer| buffer == "rows" || change.buffers.contains(&buffer))
        };
        self.changes.iter().filter(move |change| !reaches(change))
    }
}

/// Notes the frame that a schedule has just run; writes up to the tick `before` came before it.
pub fn note(world: &mut World, schedule: &Schedule, before: Tick) {
    let end = world.change_tick();
    let Some(mut ledger) = world.remove_resource::<Ledger>() else {
        return;
    };
    if ledger.wanted {
        let start = Instant::now();
        if let Some(since) = ledger.since {
            let runs = runs(schedule, before, end);
            ledger.changes = changes(world, since, end, &runs);
        }
        let tracer = world.get_resource::<ActiveTracer>();
        let tracer = tracer.and_then(|tracer| tracer.0.as_ref());
        ledger.uploads = tracer.map_or_else(Vec::new, |tracer| tracer.uploads());
        ledger.uploads.retain(|upload| upload.bytes > 0);
        ledger.micros = start.elapsed().as_secs_f64() * 1e6;
    }
    // What is written from here on bears this tick or a later one.
    ledger.since = ledger.wanted.then(|| Tick::new(end.get().wrapping_sub(1)));
    world.insert_resource(ledger);
}

/// Ends of runs in order, each with who ran; the first is what came before the frame.
fn runs(schedule: &Schedule, before: Tick, end: Tick) -> Vec<(u32, Option<Arc<str>>)> {
    // Ages rather than ticks, which wrap around.
    let age = |tick: Tick| end.get().wrapping_sub(tick.get());
    let mut runs = vec![(age(before), None)];
    if let Ok(systems) = schedule.systems() {
        let newer = systems.filter(|(_, system)| age(system.get_last_run()) < age(before));
        runs.extend(newer.map(|(_, system)| {
            let name = short_name(&system.name().to_string());
            (age(system.get_last_run()), Some(Arc::from(name)))
        }));
    }
    // The oldest first.
    runs.sort_by_key(|(age, _)| std::cmp::Reverse(*age));
    runs
}

/// Who wrote at a tick of that age: the first whose run ended no earlier.
fn writer(runs: &[(u32, Option<Arc<str>>)], age: u32) -> Option<Arc<str>> {
    let place = runs.partition_point(|(end, _)| *end > age);
    runs.get(place).or(runs.last())?.1.clone()
}

fn changes(world: &World, since: Tick, end: Tick, runs: &[(u32, Option<Arc<str>>)]) -> Vec<Change> {
    let reach = |id: ComponentId| {
        let name = short_name(&world.components().get_name(id)?.to_string());
        let (_, buffers) = REACH.iter().find(|(component, _)| *component == name)?;
        Some((id, Arc::<str>::from(name), *buffers))
    };
    let mut found: BTreeMap<(Arc<str>, Option<Arc<str>>), Change> = BTreeMap::new();
    for archetype in world.archetypes().iter() {
        let ids = archetype.components().iter().copied();
        let known: Vec<_> = ids.filter_map(reach).collect();
        if known.is_empty() {
            continue;
        }
        for entity in archetype.entities() {
            let entity = entity.id();
            let Ok(row) = world.get_entity(entity) else {
                continue;
            };
            for (id, component, buffers) in &known {
                let Some(ticks) = row.get_change_ticks_by_id(*id) else {
                    continue;
                };
                if !ticks.changed.is_newer_than(since, end) {
                    continue;
                }
                let age = end.get().wrapping_sub(ticks.changed.get());
                let system = writer(runs, age);
                let change = found
                    .entry((Arc::clone(component), system.clone()))
                    .or_insert_with(|| Change {
                        component: Arc::clone(component),
                        system,
                        entities: Vec::new(),
                        count: 0,
                        buffers,
                    });
                change.count += 1;
                if change.entities.len() < MOST_NAMED {
                    change.entities.push(entity);
                }
            }
        }
    }
    let mut changes: Vec<Change> = found.into_values().collect();
    changes.sort_by_key(|change| std::cmp::Reverse(change.count));
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::Engine;
    use crate::schedule::FrameSet;
    use crate::world::{Sphere, Transform};

    fn mover(mut things: Query<&mut Transform, With<Sphere>>, time: Res<crate::time::Time>) {
        if time.frame == 4 {
            for mut thing in things.iter_mut().take(2) {
                thing.translation.x += 1.0;
            }
        }
    }

    /// Exclusive, so that its writes bear other ticks than its run begins with.
    fn grower(world: &mut World) {
        let mut spheres = world.query::<(Entity, &Sphere)>();
        let first = spheres.iter(world).map(|(entity, _)| entity).next();
        if world.resource::<crate::time::Time>().frame == 4
            && let Some(mut sphere) = first.and_then(|first| world.get_mut::<Sphere>(first))
        {
            sphere.radius += 1.0;
        }
    }

    fn idle(_: Query<&Transform>) {}

    #[test]
    fn each_change_is_laid_to_the_system_that_wrote_it() {
        let mut engine = Engine::new();
        engine.add_plugin(crate::profile::plugin);
        engine.add_systems(FrameSet::Simulate, (idle, mover, grower).chain());
        let things: Vec<Entity> = (0..3)
            .map(|_| {
                let parts = (Transform::default(), Sphere { radius: 1.0 });
                engine.world.spawn(parts).id()
            })
            .collect();
        engine.world.resource_mut::<Ledger>().wanted = true;
        let mut seen = Vec::new();
        for frame in 1..=6 {
            engine.frame();
            if frame == 4 {
                // Written by nobody of the schedule: it belongs to the next frame.
                let mut thing = engine.world.get_mut::<Transform>(things[2]).unwrap();
                thing.translation.y = 5.0;
            }
            let ledger = engine.world.resource::<Ledger>();
            let changes = ledger.changes.iter().map(|change| {
                let system = change.system.as_deref().map(str::to_owned);
                (frame, change.component.to_string(), system, change.count)
            });
            seen.extend(changes);
        }
        let found = |frame, component: &str, system: Option<&str>, count| {
            let wanted = (
                frame,
                component.to_owned(),
                system.map(str::to_owned),
                count,
            );
            seen.iter().filter(|change| **change == wanted).count() == 1
        };
        assert!(found(4, "Transform", Some("mover"), 2), "{seen:?}");
        assert!(found(4, "Sphere", Some("grower"), 1), "{seen:?}");
        assert!(found(5, "Transform", None, 1), "{seen:?}");
        assert!(
            seen.iter().all(|change| [4, 5].contains(&change.0)),
            "{seen:?}"
        );
    }
}
