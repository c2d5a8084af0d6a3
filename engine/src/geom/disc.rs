//! The unit disc about the origin across +Y; a disc's size, place and turn are in its instance's transform.
//!
//! Twin of `shaders/shared/disc.wgsl`.

use glam::Vec3;

/// A direction less steep than this runs along the disc: beyond it, distances would leave f32's range.
const LEAST_STEEPNESS: f32 = 1e-18;

/// Distance to the disc, in lengths of `dir`; none for a miss. A ray within the disc's plane misses it.
pub fn intersect_disc(origin: Vec3, dir: Vec3) -> Option<f32> {
    if dir.y.abs() <= LEAST_STEEPNESS * (dir.x.abs() + dir.z.abs()) {
        return None;
    }
    let t = -origin.y / dir.y;
    let (x, z) = (origin.x + dir.x * t, origin.z + dir.z * t);
    let is_near = x.abs().max(z.abs()) <= 1.0;
    (is_near && x * x + z * z <= 1.0).then_some(t)
}
