//! A shape in the world as a row in render space, and its box there.

use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::PackedMesh;
use crate::frame::wire::{
    InstanceRow, KIND_CUBOID, KIND_ELLIPSOID, KIND_MESH, KIND_PLANE, KIND_SPHERE,
};
use crate::frame::{Instance, Shape};
use crate::geom::{Aabb, AffineRows};

/// Both unit shapes fit into it.
const UNIT_BOX: Aabb = Aabb {
    min: Vec3::NEG_ONE,
    max: Vec3::ONE,
};

/// The row of an instance seen from `eye`, and its box; planes have an empty one. None if it draws nothing.
pub(super) fn instance_row<'a>(
    instance: &Instance,
    eye: DVec3,
    mesh: impl Fn(u32) -> &'a PackedMesh,
) -> Option<(InstanceRow, Aabb)> {
    let mut render_from_local = instance.world_from_local;
    render_from_local.translation -= eye;
    let (mut row, bounds) = match instance.shape {
        Shape::Vacant => return None,
        Shape::Mesh(id) => mesh_row(&render_from_local, mesh(id))?,
        Shape::Sphere { radius } => sphere_row(&render_from_local, radius),
        Shape::Cuboid { min, max } => {
            let (half, center) = ((max - min) * 0.5, (max + min) * 0.5);
            let unit = DAffine3::from_scale_rotation_translation(half, DQuat::IDENTITY, center);
            affine_row(KIND_CUBOID, render_from_local * unit, UNIT_BOX)
        }
        Shape::Plane { normal, distance } => {
            let mut row = InstanceRow {
                kind: KIND_PLANE,
                ..Default::default()
            };
            row.local_from_world.0[0] = render_plane(&render_from_local, normal, distance);
            (row, Aabb::EMPTY)
        }
    };
    row.material = instance.material;
    // Extraction keeps such things out; a scene made by hand may still hold one.
    let drawable = bounds.min.is_finite() && bounds.max.is_finite();
    drawable.then_some((row, bounds))
}

/// A shape that is tested in a local space of its own.
fn affine_row(kind: u32, render_from_unit: DAffine3, local: Aabb) -> (InstanceRow, Aabb) {
    let unit_from_render = render_from_unit.inverse();
    let row = InstanceRow {
        kind,
        world_from_local: AffineRows::new(render_from_unit),
        local_from_world: AffineRows::new(unit_from_render),
        ..Default::default()
    };
    let condition = frobenius(&render_from_unit) * frobenius(&unit_from_render);
    (row, render_box(&render_from_unit, &local, condition))
}

fn mesh_row(render_from_local: &DAffine3, mesh: &PackedMesh) -> Option<(InstanceRow, Aabb)> {
    if mesh.tree.nodes.is_empty() {
        return None;
    }
    let recentre = DAffine3::from_translation(mesh.source.origin);
    let (mut row, bounds) = affine_row(KIND_MESH, *render_from_local * recentre, mesh.bounds);
    row.root = mesh.root;
    row.first_triangle = mesh.first_triangle;
    Some((row, bounds))
}

/// A sphere stays one in render space unless its transform squeezes it.
fn sphere_row(render_from_local: &DAffine3, radius: f64) -> (InstanceRow, Aabb) {
    let Some(scale) = uniform_scale(render_from_local) else {
        let unit = DAffine3::from_scale(DVec3::splat(radius));
        return affine_row(KIND_ELLIPSOID, *render_from_local * unit, UNIT_BOX);
    };
    let mut row = InstanceRow {
        kind: KIND_SPHERE,
        ..Default::default()
    };
    let center = render_from_local.translation.as_vec3();
    let radius = (radius * scale) as f32;
    row.local_from_world.0[0] = center.extend(radius).to_array();
    (row, padded(center - radius, center + radius, 4.0))
}

/// The scale of a map that is nothing but scale, rotation and translation, to f64 accuracy.
fn uniform_scale(map: &DAffine3) -> Option<f64> {
    let m = map.matrix3;
    let scale = m.x_axis.length();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * scale;
    let uniform = close(m.y_axis.length(), scale)
        && close(m.z_axis.length(), scale)
        && close(m.x_axis.dot(m.y_axis) / scale, 0.0)
        && close(m.y_axis.dot(m.z_axis) / scale, 0.0)
        && close(m.z_axis.dot(m.x_axis) / scale, 0.0);
    uniform.then_some(scale)
}

fn frobenius(map: &DAffine3) -> f64 {
    let m = map.matrix3;
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

/// The render-space box of a local box, widened by what the intersector's f32 transform may err by:
/// a few roundings of |M^-1| (|M| |p|), hence the condition number.
fn render_box(render_from_local: &DAffine3, local: &Aabb, condition: f64) -> Aabb {
    let (min, max) = (local.min.as_dvec3(), local.max.as_dvec3());
    let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let m = render_from_local.matrix3;
    let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    let center = render_from_local.transform_point3(center);
    padded(
        (center - reach).as_vec3(),
        (center + reach).as_vec3(),
        2.0 * condition as f32,
    )
}

/// A box widened by `ulps` of its largest coordinate.
fn padded(min: Vec3, max: Vec3, ulps: f32) -> Aabb {
    let pad = min.abs().max(max.abs()).max_element() * f32::EPSILON * ulps;
    Aabb {
        min: min - pad,
        max: max + pad,
    }
}

/// Unit normal and distance of a transformed plane relative to the eye.
fn render_plane(render_from_local: &DAffine3, normal: DVec3, distance: f64) -> [f32; 4] {
    let point = render_from_local.transform_point3(normal * (distance / normal.length_squared()));
    let n = (render_from_local.matrix3.inverse().transpose() * normal).normalize();
    [n.x as f32, n.y as f32, n.z as f32, n.dot(point) as f32]
}
