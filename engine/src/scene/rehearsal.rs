//! A model file played through before it is shown, so that its picture holds what it will do.
//!
//! Called when a model file has become a world. Cameras of its own that see nothing of it all the while are taken away, up
//! to the first that sees something; where there is none, the picture is framed. Poses are pure functions of the time:
//! what is left behind is overwritten by the first frame, as it would be by any.

mod sight;

use std::ops::ControlFlow;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;

use crate::time::Time;
use crate::world::{
    Camera, ClipPlayer, Cone, Cylinder, Framing, GlobalTransform, GlobalVisibility, KeyFrames,
    Mesh, Meshes, OwnMesh, Sphere, deformed_vertices, derive_own_meshes, play_clips, propagate,
    propagate_alone,
};
use sight::{Sight, Thing};

/// Moments that are looked at, of the longest clip.
const MOMENTS: usize = 32;
/// Fewer where there are more vertices than this to look at in all.
const MOST_VERTICES: usize = 8_000_000;

/// Leaves the picture to the first camera that sees something of the model, else to the [`Framing`] of all that is shown
/// while the longest clip plays. Says which cameras were taken away.
pub fn rehearse(world: &mut World) -> Vec<String> {
    world.init_resource::<Meshes>();
    let now = *world.get_resource_or_init::<Time>();
    let mut play = Play::of(world);
    let blind = blind_cameras(world, &mut play);
    for &camera in &blind {
        world.entity_mut(camera).remove::<Camera>();
    }
    let is_framed = cameras(world).is_empty();
    if is_framed {
        frame(world, &mut play);
    }
    world.insert_resource(now);
    let instead = match is_framed {
        true => "the picture shows all there is",
        false => "the picture is the next one's",
    };
    let name = |camera: &Entity| world.get::<Name>(*camera).map_or("", Name::as_str);
    let told = blind.iter().map(name);
    told.map(|name| format!("its camera `{name}` sees nothing of it; {instead}"))
        .collect()
}

/// Puts the [`Framing`] of all that is shown into the world.
fn frame(world: &mut World, play: &mut Play) {
    let mut framing = Framing::new();
    for i in 0..play.moments.len() {
        play.pose(world, i);
        let _ = each_thing(world, |thing| {
            match thing {
                Thing::Points(points) => framing.add_points(points),
                Thing::Ball(map, radius) => framing.add_ball(map, radius),
                Thing::Box(map, min, max) => framing.add_box(map, min, max),
            }
            ControlFlow::Continue(())
        });
    }
    world.insert_resource(framing);
}

/// The cameras before the first that sees anything at any moment; none where nothing is ever shown.
fn blind_cameras(world: &mut World, play: &mut Play) -> Vec<Entity> {
    play.pose(world, 0);
    let cameras = cameras(world);
    let (mut first, mut is_empty) = (cameras.len(), true);
    for i in 0..play.moments.len() {
        if i > 0 {
            play.pose(world, i);
        }
        let mut eyes = world.query::<(&Camera, &GlobalTransform)>();
        let sight = |&camera| eyes.get(world, camera).ok();
        let sights: Vec<Sight> = cameras.iter().filter_map(sight).map(Sight::of).collect();
        let found = each_thing(world, |thing| {
            is_empty = false;
            let mut before = sights.iter().take(first);
            first = before
                .position(|sight| sight.meets(&thing))
                .unwrap_or(first);
            match first {
                0 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        if found.is_break() {
            break;
        }
    }
    match is_empty {
        true => Vec::new(),
        false => cameras[..first].to_vec(),
    }
}

/// The cameras that are shown now, in the order in which they are chosen from.
fn cameras(world: &mut World) -> Vec<Entity> {
    let mut cameras = world.query_filtered::<(Entity, &GlobalVisibility), With<Camera>>();
    let shown = cameras.iter(world).filter(|(_, shown)| shown.0);
    let mut shown: Vec<Entity> = shown.map(|(entity, _)| entity).collect();
    shown.sort_unstable();
    shown
}

/// A model on its way through its longest clip.
struct Play {
    schedule: Schedule,
    /// Times of the scene, seconds; at least one.
    moments: Vec<f64>,
}

impl Play {
    fn of(world: &mut World) -> Self {
        let mut schedule = Schedule::default();
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.add_systems(
            (
                play_clips,
                propagate_alone::<GlobalTransform>,
                propagate::<GlobalTransform>,
                propagate_alone::<GlobalVisibility>,
                propagate::<GlobalVisibility>,
                derive_own_meshes,
            )
                .chain(),
        );
        let moments = moments(world);
        Self { schedule, moments }
    }

    /// Brings the world to a moment.
    fn pose(&mut self, world: &mut World, moment: usize) {
        world.resource_mut::<Time>().secs = self.moments[moment];
        self.schedule.run(world);
    }
}

/// Times of the scene to look at.
fn moments(world: &mut World) -> Vec<f64> {
    let mut players = world.query::<&ClipPlayer>();
    let clips = players.iter(world).map(ClipPlayer::period);
    let mut longest = clips.fold(0.0, f64::max);
    let mut keyed = world.query::<&KeyFrames>();
    for keys in keyed.iter(world) {
        longest = longest.max(keys.period());
    }
    if !(longest > 0.0 && longest.is_finite()) {
        return vec![0.0];
    }
    let mut shown = world.query::<&Mesh>();
    let meshes = world.resource::<Meshes>();
    let data = shown.iter(world).filter_map(|mesh| meshes.get(mesh.0));
    let vertices: usize = data.map(|data| data.vertices.len()).sum();
    let count = (MOST_VERTICES / vertices.max(1)).clamp(2, MOMENTS);
    let step = longest / count as f64;
    (0..=count).map(|i| step * i as f64).collect()
}

type Placed = (&'static GlobalTransform, &'static GlobalVisibility);

/// Hands out all that is seen now and has an end, until told to break off.
fn each_thing(world: &mut World, mut add: impl FnMut(Thing) -> ControlFlow<()>) -> ControlFlow<()> {
    let mut shown = world.query::<(Placed, &Mesh, Option<&OwnMesh>)>();
    let meshes = world.resource::<Meshes>();
    for ((pose, shown), mesh, own) in shown.iter(world) {
        let id = own.map_or(mesh.0, |own| own.0);
        let row = meshes.rows().get(id.0 as usize);
        if let Some(row) = row.filter(|_| shown.0 && pose.0.is_finite()) {
            let mut points = deformed_vertices(&row.data, row.deformation.as_deref());
            for point in &mut points {
                *point = pose.0.transform_point3(*point);
            }
            add(Thing::Points(points))?;
        }
    }
    let mut spheres = world.query::<(Placed, &Sphere)>();
    for ((pose, shown), sphere) in spheres.iter(world) {
        if shown.0 {
            add(Thing::Ball(pose.0, sphere.radius))?;
        }
    }
    let mut cylinders = world.query::<(Placed, &Cylinder)>();
    let mut cones = world.query::<(Placed, &Cone)>();
    let cylinders = cylinders.iter(world);
    let cylinders = cylinders.map(|(placed, &cylinder)| (placed, Cone::from(cylinder)));
    let cones = cones.iter(world).map(|(placed, &cone)| (placed, cone));
    for ((pose, shown), cone) in cylinders.chain(cones) {
        if shown.0 {
            let (min, max) = cone.bounds();
            add(Thing::Box(pose.0, min, max))?;
        }
    }
    ControlFlow::Continue(())
}
