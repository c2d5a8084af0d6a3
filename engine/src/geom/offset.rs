//! Where a ray may start so that it cannot meet the surface it leaves.
//!
//! Bounds on rounding error after pbrt-v4, 6.8 "Managing Rounding Error": no length out of the air, so
//! the same code serves a scene of millimetres and one of kilometres.

use glam::Vec3;

use super::AffineRows;

/// Bound on n roundings in a row: n*eps / (1 - n*eps), eps = 2^-24.
pub const fn gamma(n: u32) -> f32 {
    const EPS: f32 = f32::EPSILON * 0.5;
    (n as f32 * EPS) / (1.0 - n as f32 * EPS)
}

/// Error of a local point that goes to render space and back: `world_from_local` applied to `local`
/// (itself known to within `local_error`) giving `world`, and the error that `local_from_world` makes of
/// that when the next ray comes back, seen in render space.
///
/// Each way: three products and two sums with rounded entries, gamma(4) of |M| |p|; then the translation,
/// itself rounded, and the rounding of the last sum, which is of the result's size.
pub fn affine_error(
    local: Vec3,
    local_error: Vec3,
    world: Vec3,
    world_from_local: &AffineRows,
    local_from_world: &AffineRows,
) -> Vec3 {
    let one_way = |map: &AffineRows, from: Vec3, to: Vec3| {
        map.abs_linear(from.abs()) * gamma(4) + (map.translation().abs() + to.abs()) * gamma(1)
    };
    let forward =
        world_from_local.abs_linear(local_error) + one_way(world_from_local, local, world);
    let back = world_from_local.abs_linear(one_way(local_from_world, world, local));
    forward + back
}

/// The point moved off the surface to the side that `dir` leaves by: along `normal` by the error's extent
/// there, plus the rounding of that very sum.
pub fn offset_origin(point: Vec3, normal: Vec3, error: Vec3, dir: Vec3) -> Vec3 {
    let reach = normal.abs().dot(error + point.abs() * gamma(1));
    if normal.dot(dir) >= 0.0 {
        point + normal * reach
    } else {
        point - normal * reach
    }
}
