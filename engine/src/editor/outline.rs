//! The outlines of things as lines in the world: shapes by their edges and rims, meshes by their boxes, lights and cameras by
//! what they do.

use std::f64::consts::TAU;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DAffine3, DVec3};

use crate::frame::{FrameScene, Instance, Shape};
use crate::world::{Camera, Cone, MeshData, Projection, SpotLight, corners};

/// Corners of a circle.
const ROUND: usize = 48;

/// A line of several corners, in the world.
pub type Line = Vec<DVec3>;

/// Boxes of meshes, each found once.
#[derive(Resource, Debug, Default)]
pub struct Boxes(Vec<(Arc<MeshData>, [DVec3; 2])>);

impl Boxes {
    /// The box of a mesh in its own space; none: it has no vertices.
    fn of(&mut self, mesh: &Arc<MeshData>) -> Option<[DVec3; 2]> {
        if let Some((_, found)) = self.0.iter().find(|(known, _)| Arc::ptr_eq(known, mesh)) {
            return Some(*found);
        }
        let first = *mesh.vertices.first()?;
        let vertices = mesh.vertices.iter();
        let found = vertices.fold([first; 2], |[min, max], &v| [min.min(v), max.max(v)]);
        // Those that are not shown any more would be kept for ever.
        self.0.retain(|(mesh, _)| Arc::strong_count(mesh) > 1);
        self.0.push((Arc::clone(mesh), found));
        Some(found)
    }
}

/// The box of an instance in its own space; none where it has none.
pub fn local_box(scene: &FrameScene, boxes: &mut Boxes, instance: &Instance) -> Option<[DVec3; 2]> {
    Some(match instance.shape {
        Shape::Vacant | Shape::Plane { .. } => return None,
        Shape::Mesh(row) => boxes.of(&scene.meshes.get(row as usize)?.data)?,
        Shape::Sphere { radius } => [DVec3::splat(-radius), DVec3::splat(radius)],
        Shape::Cuboid { min, max } => [min, max],
        Shape::Disc { center, radius, .. } => [center - radius, center + radius],
        Shape::Cone(cone) => {
            let (min, max) = cone.bounds();
            [min, max]
        }
        Shape::Torus { major, minor } => {
            let reach = DVec3::new(major, 0.0, major) + minor;
            [-reach, reach]
        }
    })
}

/// The outline of an instance.
pub fn of_instance(scene: &FrameScene, boxes: &mut Boxes, instance: &Instance) -> Vec<Line> {
    let mut lines = match instance.shape {
        Shape::Vacant => return Vec::new(),
        Shape::Sphere { radius } => {
            let about = |axis| circle(DVec3::ZERO, axis, radius);
            vec![about(DVec3::X), about(DVec3::Y), about(DVec3::Z)]
        }
        Shape::Plane { normal, distance } => {
            let normal_len = normal.length();
            let (n, at) = (normal / normal_len, normal * distance / normal_len.powi(2));
            patch(at, n)
        }
        Shape::Disc {
            center,
            normal,
            radius,
        } => vec![circle(center, normal, radius)],
        Shape::Cone(cone) => of_cone(&cone),
        Shape::Torus { major, minor } => {
            let ring = |y, radius| circle(DVec3::Y * y, DVec3::Y, radius);
            let tube = |axis: DVec3| circle(axis * major, axis.cross(DVec3::Y), minor);
            let mut lines = vec![
                ring(0.0, major + minor),
                ring(0.0, major - minor),
                ring(minor, major),
                ring(-minor, major),
            ];
            lines.extend([DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z].map(tube));
            lines
        }
        Shape::Cuboid { .. } | Shape::Mesh(_) => {
            let found = local_box(scene, boxes, instance);
            found.map_or_else(Vec::new, |[min, max]| edges(min, max))
        }
    };
    place(&mut lines, instance.world_from_local);
    lines
}

/// A spot light's cones (inner and outer) down to where a length of 1 is lit, in its own space.
pub fn of_spot(light: &SpotLight) -> Vec<Line> {
    let cone = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        circle(DVec3::NEG_Z * cos, DVec3::Z, sin)
    };
    let mut lines = vec![cone(light.outer_angle), cone(light.inner_angle)];
    let rim = lines[0].clone();
    lines.extend((0..4).map(|quarter| vec![DVec3::ZERO, rim[quarter * ROUND / 4]]));
    lines
}

/// A camera's pyramid of a depth of 1, with a mark for up, in its own space.
pub fn of_camera(camera: &Camera, aspect: f64) -> Vec<Line> {
    let (half, eye) = match camera.projection {
        Projection::Perspective { vertical_fov } => ((0.5 * vertical_fov).tan(), 0.0),
        Projection::Orthographic { height } => (0.5 * height, 1.0),
    };
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x * half * aspect, y * half, z);
    let frame = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut rim: Line = frame.iter().map(|&(x, y)| corner(x, y, -1.0)).collect();
    rim.push(rim[0]);
    let ray = |&(x, y): &(f64, f64)| vec![corner(x, y, 0.0) * eye, corner(x, y, -1.0)];
    let mut lines: Vec<Line> = frame.iter().map(ray).collect();
    lines.push(rim);
    let up = [(-0.4, 1.08), (0.0, 1.4), (0.4, 1.08), (-0.4, 1.08)];
    lines.push(up.iter().map(|&(x, y)| corner(x, y, -1.0)).collect());
    lines
}

/// Takes lines from a space to the world.
pub fn place(lines: &mut [Line], world_from_local: DAffine3) {
    for point in lines.iter_mut().flatten() {
        *point = world_from_local.transform_point3(*point);
    }
}

/// A circle about an axis of any length, closed.
pub fn circle(center: DVec3, axis: DVec3, radius: f64) -> Line {
    let (u, v) = axis.normalize_or(DVec3::Y).any_orthonormal_pair();
    (0..=ROUND)
        .map(|i| {
            let (sin, cos) = (TAU * (i % ROUND) as f64 / ROUND as f64).sin_cos();
            center + (u * cos + v * sin) * radius
        })
        .collect()
}

/// Lines that show where an unbounded plane lies.
fn patch(at: DVec3, normal: DVec3) -> Vec<Line> {
    let (u, v) = normal.any_orthonormal_pair();
    let line = |from: DVec3, to: DVec3| vec![at + from, at + to];
    let across = (-4..=4).map(|i| f64::from(i) * 1.25);
    across
        .flat_map(|s| {
            [
                line(u * s - v * 5.0, u * s + v * 5.0),
                line(v * s - u * 5.0, v * s + u * 5.0),
            ]
        })
        .collect()
}

fn of_cone(cone: &Cone) -> Vec<Line> {
    let axis = cone.b - cone.a;
    let (low, high) = (
        circle(cone.a, axis, cone.radius_a),
        circle(cone.b, axis, cone.radius_b),
    );
    let side = |i: usize| vec![low[i * ROUND / 4], high[i * ROUND / 4]];
    let mut lines: Vec<Line> = (0..4).map(side).collect();
    lines.extend([low, high]);
    lines
}

/// The twelve edges of a box.
fn edges(min: DVec3, max: DVec3) -> Vec<Line> {
    let corners = corners(min, max);
    let mut lines = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for &b in &corners[i + 1..] {
            // Two corners share an edge where they differ along one axis.
            if (a - b).to_array().iter().filter(|&&d| d != 0.0).count() == 1 {
                lines.push(vec![a, b]);
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_and_a_circle_is_closed() {
        assert_eq!(edges(DVec3::ZERO, DVec3::ONE).len(), 12);
        let ring = circle(DVec3::ONE, DVec3::new(1.0, 2.0, -3.0), 2.0);
        assert_eq!(ring.first(), ring.last());
        for point in ring {
            assert!((point.distance(DVec3::ONE) - 2.0).abs() < 1e-12);
        }
    }
}
