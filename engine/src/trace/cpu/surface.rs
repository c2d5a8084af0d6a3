//! From a hit to the surface there: position with its error bound, normals, material.
//!
//! Positions are moved onto the primitive (pbrt-v4, 6.8), and along the ray as far as that is short: there
//! they stay on the ray's line, and what t lacked is in them. Heights alone are taken to local spaces.
//! Twin of `shaders/shared/surface.wgsl`.

use glam::Vec3;

use super::query::{Found, Start};
use crate::frame::wire::{
    InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_MESH, KIND_PLANE, KIND_SPHERE, KIND_TORUS,
    MaterialRow,
};
use crate::frame::{FIXED_OFFSET, Offset};
use crate::geom::{
    SolidPoint, SphereHeight, affine_error, cone_point, cuboid_normal, gamma, offset_origin,
    step_off, torus_point, unit_or,
};
use crate::trace::PackedScene;

/// A point on a primitive, seen along a ray.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Relative to the eye.
    pub position: Vec3,
    /// Bound on how far the position is off the primitive, as rays find it.
    pub error: f32,
    /// Face normal, unit, towards the incoming side.
    pub n_geom: Vec3,
    /// Interpolated normal, unit, on the side of `n_geom`; equal to it on flat and analytic shapes.
    pub n_shade: Vec3,
    /// The material's row.
    pub material: &'a MaterialRow,
    /// Linear RGB, in place of the material's.
    pub color: Vec3,
    /// Of the ray's cone here.
    pub width: f32,
    /// From here to the curved surface that triangles stand for; none: they stand for themselves.
    pub lift: Option<Vec3>,
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

/// How a point lies to the primitive it is near, in render space.
struct Above {
    /// Along the normal.
    height: f32,
    /// What the height errs by, here and where a ray comes back.
    error: f32,
    /// Of the face, outward and unit; zero where a triangle is too thin for one.
    normal: Vec3,
    /// Of any length.
    shading: Vec3,
}

/// Resolves a hit of the ray from `origin` along `dir`.
pub fn resolve<'a>(scene: &'a PackedScene, found: &Found, origin: Vec3, dir: Vec3) -> Surface<'a> {
    let row = &scene.instances()[found.key.id as usize];
    let near = origin + dir * found.key.t;
    let above = match row.kind {
        KIND_MESH => above_triangle(scene, row, found, near),
        KIND_SPHERE => above_sphere(row, near),
        KIND_PLANE => above_plane(row, near),
        _ => above_solid(row, found.key.prim, near),
    };
    let position = near - step_off(above.height, above.normal, dir);
    // A triangle too thin for a normal looks straight back.
    let normal = unit_or(above.normal, -dir.normalize());
    let n_geom = if normal.dot(dir) > 0.0 {
        -normal
    } else {
        normal
    };
    let shading = unit_or(above.shading, n_geom);
    let n_shade = if shading.dot(n_geom) < 0.0 {
        -shading
    } else {
        shading
    };
    let material = &scene.materials[row.material as usize];
    Surface {
        position,
        error: above.error,
        n_geom,
        n_shade,
        material,
        color: material.color.into(),
        width: 0.0,
        lift: lift(scene, row, found, n_geom),
        start: Start {
            id: found.key.id,
            prim: found.key.prim,
        },
        offset: scene.kernels.offsets,
    }
}

/// From a point of a triangle to the surface that its vertices' normals tell of: the point moved onto the plane of each
/// vertex that it is below, and the means of those (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021, ch. 4).
fn lift(scene: &PackedScene, row: &InstanceRow, found: &Found, n_geom: Vec3) -> Option<Vec3> {
    if !scene.has_curved || row.kind != KIND_MESH || row.parameter == 0.0 {
        return None;
    }
    let mesh = scene.mesh(row);
    let triangle = &mesh.triangles[found.triangle as usize];
    let normals = mesh.corner_normals(triangle)?;
    let corners = mesh.corners(triangle);
    let [a, b, c] = corners;
    let [u, v] = found.uv;
    let weights = [1.0 - u - v, u, v];
    let at = a * weights[0] + b * u + c * v;
    let outward = row.local_from_world.transposed_vector((b - a).cross(c - a));
    let side = if n_geom.dot(outward) < 0.0 { -1.0 } else { 1.0 };
    let mut local = Vec3::ZERO;
    for ((corner, normal), weight) in corners.into_iter().zip(normals).zip(weights) {
        let below = (at - corner).dot(normal * side).min(0.0);
        local -= normal * (side * below * weight);
    }
    Some(row.world_from_local.vector(local))
}

/// The height of a point over a plane of unit `normal` in a row's local space, brought to render space. Only what
/// the map errs by along the normal counts, there and back.
fn above_local(
    row: &InstanceRow,
    (near, local): (Vec3, Vec3),
    height: f32,
    error: f32,
    normal: Vec3,
) -> Above {
    let map = &row.local_from_world;
    let gradient = map.transposed_vector(normal);
    let unit = unit_or(gradient, Vec3::ZERO);
    let steepness = unit.dot(gradient);
    let length = if steepness > 0.0 {
        1.0 / steepness
    } else {
        0.0
    };
    let mapped = affine_error(map, near, local);
    Above {
        height: height * length,
        error: (error + 2.0 * normal.abs().dot(mapped)) * length,
        normal: unit,
        shading: unit,
    }
}

fn above_triangle(scene: &PackedScene, row: &InstanceRow, found: &Found, near: Vec3) -> Above {
    let mesh = scene.mesh(row);
    let triangle = &mesh.triangles[found.triangle as usize];
    let [a, b, c] = mesh.corners(triangle);
    let local = row.local_from_world.point(near);
    let (ab, ac, from_corner) = (b - a, c - a, local - a);
    let face = ab.cross(ac);
    let normal = unit_or(face, Vec3::ZERO);
    let height = normal.dot(from_corner);
    // The face's own rounding tilts it, and a sliver's most: by the error of the cross product over its length.
    let tilt = abs_cross(ab, ac) * (gamma(3) / face.dot(normal).max(f32::MIN_POSITIVE));
    let spread = from_corner.abs() * 2.0 + ab.abs() + ac.abs();
    let error = normal.abs().dot(spread) * gamma(5) + 2.0 * from_corner.abs().dot(tilt);
    let mut above = above_local(row, (near, local), height, error, normal);
    if let Some([at_a, at_b, at_c]) = mesh.corner_normals(triangle) {
        let [u, v] = found.uv;
        // A mirrored instance turns both normals alike, and a smooth one follows its face's side.
        above.shading = row
            .local_from_world
            .transposed_vector(at_a * (1.0 - u - v) + at_b * u + at_c * v);
    }
    above
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

fn above_sphere(row: &InstanceRow, near: Vec3) -> Above {
    let SphereHeight {
        height,
        error,
        normal,
    } = row.sphere().height(near);
    Above {
        height,
        error,
        normal,
        shading: normal,
    }
}

fn above_plane(row: &InstanceRow, near: Vec3) -> Above {
    let plane = row.plane();
    let normal = plane.normal.as_vec3();
    Above {
        height: plane.height(near),
        error: normal.abs().dot(near.abs()) * gamma(6),
        normal,
        shading: normal,
    }
}

/// Over a solid's point in its own space: that is on the solid but for its roundings.
fn above_solid(row: &InstanceRow, prim: u32, near: Vec3) -> Above {
    let local = row.local_from_world.point(near);
    let SolidPoint {
        at,
        normal,
        roundings,
    } = match row.kind {
        KIND_CUBOID => {
            let normal = cuboid_normal(prim);
            let on_face = Vec3::select(normal.cmpeq(Vec3::ZERO), local, normal);
            SolidPoint::on(on_face.clamp(Vec3::NEG_ONE, Vec3::ONE), normal)
        }
        KIND_DISC => SolidPoint::on(Vec3::new(local.x, 0.0, local.z), Vec3::Y),
        KIND_CONE => cone_point(local, row.parameter, prim),
        KIND_TORUS => torus_point(local, row.parameter),
        _ => {
            let unit = local.normalize_or(Vec3::Y);
            SolidPoint::on(unit, unit)
        }
    };
    let normal = unit_or(normal, Vec3::Y);
    let error = normal.abs().dot(roundings) * gamma(5);
    above_local(row, (near, local), normal.dot(local - at), error, normal)
}
