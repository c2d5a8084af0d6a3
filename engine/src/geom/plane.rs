//! Infinite planes.

use glam::Vec3;

/// Distance to the plane n.p = `distance` (n unit); none for a parallel ray.
pub fn intersect_plane(normal: Vec3, distance: f32, origin: Vec3, dir: Vec3) -> Option<f32> {
    let along = normal.dot(dir);
    (along != 0.0).then(|| (distance - normal.dot(origin)) / along)
}
