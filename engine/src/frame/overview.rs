//! The view of a world without a camera: all that is bounded, from the front right and a little above.
//!
//! Called by extraction. It follows what moves; a scene that wants a still picture names a camera.

use glam::{DAffine3, DVec3};

use super::extract::view_of;
use super::{FrameScene, Instance, Shape, View};
use crate::world::{Camera, Cone, Projection, Transform};

/// From the middle of the scene towards the eye.
const TOWARDS_EYE: DVec3 = DVec3::new(0.5, 0.4, 1.0);

/// A default camera's view that holds the sphere about the bounds of all shapes but planes.
pub fn overview(scene: &FrameScene, aspect: f64) -> View {
    let (min, max) = scene
        .instances
        .iter()
        .filter_map(|instance| bounds(scene, instance))
        .fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(min, max), (low, high)| (min.min(low), max.max(high)),
        );
    let (centre, radius) = if min.is_finite() && max.is_finite() {
        ((min + max) * 0.5, (max - min).length() * 0.5)
    } else {
        (DVec3::ZERO, 1.0)
    };
    let camera = Camera::default();
    let half_height = match camera.projection {
        Projection::Perspective { vertical_fov } => (0.5 * vertical_fov).tan(),
        Projection::Orthographic { height } => 0.5 * height,
    };
    // The cone of the narrower side touches the sphere.
    let half_angle = (half_height * aspect.min(1.0)).atan();
    let away = radius.max(1e-3) / half_angle.sin();
    let eye = centre + TOWARDS_EYE.normalize() * away;
    let pose = Transform::looking_at(eye, centre, DVec3::Y);
    view_of(&camera, pose.affine(), aspect)
}

/// Bounds in the world, not the tightest; none for what has none.
fn bounds(scene: &FrameScene, instance: &Instance) -> Option<(DVec3, DVec3)> {
    let (min, max) = match instance.shape {
        Shape::Vacant | Shape::Plane { .. } => return None,
        Shape::Sphere { radius } => (DVec3::splat(-radius), DVec3::splat(radius)),
        Shape::Cuboid { min, max } => (min, max),
        Shape::Disc { center, radius, .. } => (center - radius, center + radius),
        Shape::Cone(Cone {
            a,
            radius_a,
            b,
            radius_b,
            ..
        }) => (
            (a - radius_a).min(b - radius_b),
            (a + radius_a).max(b + radius_b),
        ),
        Shape::Torus { major, minor } => {
            let reach = DVec3::new(major, 0.0, major) + minor;
            (-reach, reach)
        }
        Shape::Mesh(row) => {
            let vertices = &scene.meshes.get(row as usize)?.data.vertices;
            let first = *vertices.first()?;
            vertices.iter().fold((first, first), |(min, max), &vertex| {
                (min.min(vertex), max.max(vertex))
            })
        }
    };
    let DAffine3 {
        matrix3,
        translation,
    } = instance.world_from_local;
    let centre = matrix3 * ((min + max) * 0.5) + translation;
    let half = matrix3.abs() * ((max - min) * 0.5);
    Some((centre - half, centre + half))
}
