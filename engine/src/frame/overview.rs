//! The view of a world without a camera: all that is bounded, from the front right and a little above.
//!
//! Called by extraction. It follows what moves, unless a [`Framing`] says what is to be shown; a scene that wants a still
//! picture names a camera.

use glam::DVec3;

use super::extract::view_of;
use super::{FrameScene, Instance, Shape, View};
use crate::world::{Camera, Framing, deformed_vertices};

/// A default camera's view of all shapes but planes, or of what is to be shown instead.
pub fn overview(scene: &FrameScene, shown: Option<&Framing>, aspect: f64) -> View {
    let pose = match shown {
        Some(framing) => framing.pose(aspect),
        None => {
            let mut framing = Framing::of_aspect(aspect);
            for instance in scene.instances.iter() {
                add(scene, instance, &mut framing);
            }
            framing.pose(aspect)
        }
    };
    view_of(&Camera::default(), pose.affine(), aspect)
}

/// Adds an instance, or a box around it.
fn add(scene: &FrameScene, instance: &Instance, framing: &mut Framing) {
    let map = instance.world_from_local;
    let (min, max) = match instance.shape {
        Shape::Vacant | Shape::Plane { .. } => return,
        Shape::Sphere { radius } => return framing.add_ball(map, radius),
        Shape::Mesh(row) => {
            let Some(row) = scene.meshes.get(row as usize) else {
                return;
            };
            let vertices = deformed_vertices(&row.data, row.deformation.as_deref());
            let placed = vertices.into_iter().map(|p| map.transform_point3(p));
            return framing.add_points(placed);
        }
        Shape::Cuboid { min, max } => (min, max),
        Shape::Disc { center, radius, .. } => (center - radius, center + radius),
        Shape::Cone(cone) => cone.bounds(),
        Shape::Torus { major, minor } => {
            let reach = DVec3::new(major, 0.0, major) + minor;
            (-reach, reach)
        }
    };
    framing.add_box(map, min, max);
}
