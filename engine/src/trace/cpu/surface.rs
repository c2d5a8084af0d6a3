//! From a hit to the surface there: position with its error bound, normals, material.
//!
//! Positions are moved onto the primitive, never left at origin + t * direction (pbrt-v4, 6.8).
//! Twin of `shaders/shared/surface.wgsl`.

use glam::Vec3;

use super::traverse::{Found, Start};
use crate::frame::wire::{
    InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_MESH, KIND_PLANE, KIND_SPHERE, KIND_TORUS,
    MaterialRow,
};
use crate::frame::{FIXED_OFFSET, Offset};
use crate::geom::{
    SolidPoint, SpherePoint, affine_error, cone_point, cuboid_normal, gamma, offset_origin,
    torus_point, unit_or,
};
use crate::trace::PackedScene;

/// A point on a primitive, seen along a ray.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Relative to the eye.
    pub position: Vec3,
    /// Bound on the position's rounding error, per axis.
    pub error: Vec3,
    /// Face normal, unit, towards the incoming side.
    pub n_geom: Vec3,
    /// Interpolated normal, unit, on the side of `n_geom`; equal to it on flat and analytic shapes.
    pub n_shade: Vec3,
    /// The material's row.
    pub material: &'a MaterialRow,
    /// What it is a point of.
    pub start: Start,
    /// How rays from here are kept off it.
    pub offset: Offset,
}

impl Surface<'_> {
    /// Where a ray along `dir` starts, and what it must not meet.
    pub fn leave_towards(&self, dir: Vec3) -> (Vec3, Start) {
        match self.offset {
            Offset::Bounded => {
                let origin = offset_origin(self.position, self.n_geom, self.error, dir);
                (origin, self.start)
            }
            Offset::Fixed => {
                let aside = FIXED_OFFSET.copysign(self.n_geom.dot(dir));
                (self.position + self.n_geom * aside, Start::FREE)
            }
        }
    }
}

/// Position, its error, face normal and shading normal before they are turned to the viewer.
type Point = (Vec3, Vec3, Vec3, Vec3);

/// Resolves a hit of the ray from `origin` along `dir`.
pub fn resolve<'a>(scene: &'a PackedScene, found: &Found, origin: Vec3, dir: Vec3) -> Surface<'a> {
    let row = &scene.instances()[found.key.id as usize];
    let t = found.key.t;
    let (position, error, normal, shading) = match row.kind {
        KIND_MESH => {
            let local = row.local_from_world.point(origin) + row.local_from_world.vector(dir) * t;
            mesh_point(scene, row, found, local)
        }
        KIND_SPHERE => sphere_point(row, origin + dir * t),
        KIND_PLANE => plane_point(row, origin + dir * t),
        _ => {
            let local = row.local_from_world.point(origin) + row.local_from_world.vector(dir) * t;
            local_point(row, found.key.prim, local)
        }
    };
    // A triangle too thin for a normal looks straight back.
    let normal = unit_or(normal, -dir.normalize());
    let n_geom = if normal.dot(dir) > 0.0 {
        -normal
    } else {
        normal
    };
    let shading = unit_or(shading, n_geom);
    let n_shade = if shading.dot(n_geom) < 0.0 {
        -shading
    } else {
        shading
    };
    Surface {
        position,
        error,
        n_geom,
        n_shade,
        material: &scene.materials[row.material as usize],
        start: Start {
            id: found.key.id,
            prim: found.key.prim,
        },
        offset: scene.kernels.offsets,
    }
}

/// The ray's point moved onto the triangle's plane. Along the plane it errs by the ray's error, which
/// shrinks towards the eye as pixels do; weights of corners would err by the triangle's size instead.
fn mesh_point(scene: &PackedScene, row: &InstanceRow, found: &Found, near: Vec3) -> Point {
    let mesh = scene.mesh(row);
    let triangle = &mesh.triangles[found.triangle as usize];
    let [a, b, c] = mesh.corners(triangle);
    let (ab, ac, from_corner) = (b - a, c - a, near - a);
    let face = ab.cross(ac);
    let normal = unit_or(face, Vec3::ZERO);
    let local = near - normal * normal.dot(from_corner);
    // The face's own rounding tilts it, and a sliver's most: by the error of the cross product over its length.
    let tilt = abs_cross(ab, ac) * (gamma(3) / face.dot(normal).max(f32::MIN_POSITIVE));
    let local_error = from_corner.abs() * gamma(5)
        + local.abs() * gamma(2)
        + Vec3::splat(from_corner.abs().dot(tilt));
    let position = row.world_from_local.point(local);
    let error = affine_error(
        local,
        local_error,
        position,
        &row.world_from_local,
        &row.local_from_world,
    );
    let normal = row.local_from_world.transposed_vector(normal);
    let mut shading = normal;
    if let Some([at_a, at_b, at_c]) = mesh.corner_normals(triangle) {
        let [u, v] = found.uv;
        shading = row
            .local_from_world
            .transposed_vector(at_a * (1.0 - u - v) + at_b * u + at_c * v);
    }
    // A mirrored instance turns both normals alike, and a smooth one follows its face's side.
    (position, error, normal, shading)
}

/// What the products of a cross product add up to without cancelling.
fn abs_cross(a: Vec3, b: Vec3) -> Vec3 {
    let (a, b) = (a.abs(), b.abs());
    Vec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}

fn sphere_point(row: &InstanceRow, near: Vec3) -> Point {
    let SpherePoint {
        position,
        normal,
        error,
    } = row.sphere().project(near);
    (position, error, normal, normal)
}

fn plane_point(row: &InstanceRow, near: Vec3) -> Point {
    let [x, y, z, distance] = row.local_from_world.0[0];
    let normal = Vec3::new(x, y, z);
    let position = near - normal * (normal.dot(near) - distance);
    let error = (position.abs() + normal.abs() * distance.abs()) * gamma(5);
    (position, error, normal, normal)
}

/// A point of a solid in its own space, moved onto it: exactly, but for the roundings of that.
fn local_point(row: &InstanceRow, prim: u32, near: Vec3) -> Point {
    let SolidPoint {
        at: local,
        normal,
        roundings,
    } = match row.kind {
        KIND_CUBOID => {
            let normal = cuboid_normal(prim);
            let on_face = Vec3::select(normal.cmpeq(Vec3::ZERO), near, normal);
            SolidPoint::on(on_face.clamp(Vec3::NEG_ONE, Vec3::ONE), normal)
        }
        KIND_DISC => SolidPoint::on(Vec3::new(near.x, 0.0, near.z), Vec3::Y),
        KIND_CONE => cone_point(near, row.parameter, prim),
        KIND_TORUS => torus_point(near, row.parameter),
        _ => {
            let unit = near.normalize_or(Vec3::Y);
            SolidPoint::on(unit, unit)
        }
    };
    let position = row.world_from_local.point(local);
    let error = affine_error(
        local,
        roundings * gamma(5),
        position,
        &row.world_from_local,
        &row.local_from_world,
    );
    let normal = row.local_from_world.transposed_vector(normal);
    (position, error, normal, normal)
}
