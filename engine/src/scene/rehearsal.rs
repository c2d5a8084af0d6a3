//! A model file played through before it is shown, so that a camera can hold all that it will do.
//!
//! Called when a model file has become a world and brings no camera. Poses are pure functions of the time: what is left
//! behind is overwritten by the first frame, as it would be by any.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_ecs::system::SystemParam;

use crate::time::Time;
use crate::world::{
    Camera, ClipPlayer, Cone, Cylinder, Framing, GlobalTransform, GlobalVisibility, KeyFrames,
    Mesh, Meshes, OwnMesh, Sphere, Visibility, deformed_vertices, derive_own_meshes, play_clips,
    propagate, propagate_alone,
};

/// Moments that are looked at, of the longest clip.
const MOMENTS: usize = 32;
/// Fewer where there are more vertices than this to look at in all.
const MOST_VERTICES: usize = 8_000_000;

/// Leaves the [`Framing`] of all that is shown while the longest clip plays; none where there is a camera.
pub fn rehearse(world: &mut World) {
    let mut cameras = world.query_filtered::<&Visibility, With<Camera>>();
    if cameras.iter(world).any(|camera| camera.shown) {
        return;
    }
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
            look,
        )
            .chain(),
    );
    world.init_resource::<Meshes>();
    world.insert_resource(Framing::new());
    let now = *world.get_resource_or_init::<Time>();
    for secs in moments(world) {
        world.resource_mut::<Time>().secs = secs;
        schedule.run(world);
    }
    world.insert_resource(now);
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

/// What can be seen and has an end.
#[derive(SystemParam)]
struct Shapes<'w, 's> {
    meshes: Query<'w, 's, (Placed, &'static Mesh, Option<&'static OwnMesh>)>,
    spheres: Query<'w, 's, (Placed, &'static Sphere)>,
    cylinders: Query<'w, 's, (Placed, &'static Cylinder)>,
    cones: Query<'w, 's, (Placed, &'static Cone)>,
}

type Placed = (&'static GlobalTransform, &'static GlobalVisibility);

/// Adds all that is seen now.
fn look(shapes: Shapes, meshes: Res<Meshes>, mut framing: ResMut<Framing>) {
    for ((pose, shown), mesh, own) in &shapes.meshes {
        let id = own.map_or(mesh.0, |own| own.0);
        let row = meshes.rows().get(id.0 as usize);
        if let Some(row) = row.filter(|_| shown.0 && pose.0.is_finite()) {
            let vertices = deformed_vertices(&row.data, row.deformation.as_deref());
            framing.add_points(vertices.into_iter().map(|p| pose.0.transform_point3(p)));
        }
    }
    for ((pose, shown), sphere) in &shapes.spheres {
        if shown.0 {
            framing.add_ball(pose.0, sphere.radius);
        }
    }
    let cylinders = shapes.cylinders.iter();
    let cylinders = cylinders.map(|(placed, &cylinder)| (placed, Cone::from(cylinder)));
    let cones = shapes.cones.iter().map(|(placed, &cone)| (placed, cone));
    for ((pose, shown), cone) in cylinders.chain(cones) {
        if shown.0 {
            let (min, max) = cone.bounds();
            framing.add_box(pose.0, min, max);
        }
    }
}
