//! Where a ray may start so that it cannot meet the surface it leaves.
//!
//! Bounds on rounding error after pbrt-v4, 6.8 "Managing Rounding Error": no length out of the air, so
//! the same code serves a scene of millimetres and one of kilometres. What counts is how far a point may be
//! off its surface, along the normal; across it errs without harm.
//!
//! Twin of a part of `shaders/shared/surface.wgsl`.

use glam::Vec3;

use super::AffineRows;

/// Square of the sine of the flattest angle at which a step off a surface is one along the ray.
const FLATTEST: f32 = 1.0 / 64.0;

/// Bound on n roundings in a row: n*eps / (1 - n*eps), eps = 2^-24.
pub const fn gamma(n: u32) -> f32 {
    const EPS: f32 = f32::EPSILON * 0.5;
    (n as f32 * EPS) / (1.0 - n as f32 * EPS)
}

/// How far the `image` of a `point` may be off, per axis: three products and two sums, then the translation
/// and the rounding of that sum.
pub fn affine_error(map: &AffineRows, point: Vec3, image: Vec3) -> Vec3 {
    map.abs_linear(point.abs()) * gamma(3) + image.abs() * gamma(1)
}

/// A step that rises by `height` over the plane of a unit `normal`: along `dir`, which leaves a ray on its
/// line, as far as that is at most eight heights; what a flatter one lacks is made up along the normal.
#[inline]
pub fn step_off(height: f32, normal: Vec3, dir: Vec3) -> Vec3 {
    let along = normal.dot(dir);
    let slide = height * along / (along * along).max(dir.length_squared() * FLATTEST);
    dir * slide + normal * (height - slide * along)
}

/// The point moved off the surface to the side that `dir` leaves by: by its `error` and the rounding of that
/// very sum.
pub fn offset_origin(point: Vec3, normal: Vec3, error: f32, dir: Vec3) -> Vec3 {
    let reach = error + normal.abs().dot(point.abs()) * gamma(1);
    let height = if normal.dot(dir) >= 0.0 {
        reach
    } else {
        -reach
    };
    point + step_off(height, normal, dir)
}
