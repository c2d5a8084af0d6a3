//! The ray-triangle test of Möller and Trumbore (Journal of Graphics Tools 2:1, 1997), both sides, as printed:
//! what [`super::Shear`] is measured against. Neighbours round their shared edge differently, so it leaks.
//!
//! Twin of `shaders/shared/triangle.wgsl` where UNSHARED_EDGES is defined.

use glam::Vec3;

use super::TriangleHit;

/// The hit, at any t (also behind the origin); none for a miss or a triangle without area.
#[inline]
pub fn intersect_triangle_unshared(
    origin: Vec3,
    dir: Vec3,
    [a, b, c]: [Vec3; 3],
) -> Option<TriangleHit> {
    let (ab, ac) = (b - a, c - a);
    let p = dir.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let inverse = 1.0 / det;
    let from_corner = origin - a;
    let u = from_corner.dot(p) * inverse;
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = from_corner.cross(ab);
    let v = dir.dot(q) * inverse;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = ac.dot(q) * inverse;
    Some(TriangleHit { t, u, v })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hit_reports_distance_and_weights() {
        let (origin, dir) = (Vec3::new(0.25, 0.5, 4.0), Vec3::new(0.0, 0.0, -2.0));
        let hit = intersect_triangle_unshared(origin, dir, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        let hit = hit.unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (2.0, 0.25, 0.5));
    }

    #[test]
    fn triangles_without_area_are_missed() {
        let line = [Vec3::NEG_X, Vec3::ZERO, Vec3::X];
        assert!(intersect_triangle_unshared(Vec3::Z, Vec3::NEG_Z, line).is_none());
    }
}
