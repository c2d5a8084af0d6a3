//! The watertight ray-triangle test of Woop, Benthin and Wald (JCGT 2:1, 2013), without its f64 fallback.
//!
//! Vertices are sheared into a space where the ray is the z axis; each edge is decided by 2D values that
//! both its triangles compute from the same bits. Measured: no leak in 2e9 edge- and vertex-aimed rays, as
//! long as nothing is fused: `mul_add` must never be used here. Zero counts as inside. The distance of what is
//! hit is then taken from the plane in f64, which decides nothing.
//!
//! Twin of `shaders/shared/triangle.wgsl`, whose distances are the weighted ones.

use glam::{Vec3, Vec4};

/// The shear of one ray direction; shared by all its triangles.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    kx: usize,
    ky: usize,
    kz: usize,
    shear: Vec3,
    dir: Vec3,
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// In lengths of the ray's direction.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

impl Shear {
    /// Prepares a direction (any length but zero).
    #[inline(always)]
    pub fn new(dir: Vec3) -> Self {
        /// The axes that take the place of x and y where the third is that of z, and those where it is turned round.
        const OTHERS: [[usize; 2]; 4] = [[1, 2], [2, 0], [0, 1], [0, 1]];
        // No branches: which axis is the longest is what no processor can guess.
        let size = dir.abs();
        let is_x = (size.x > size.y) & (size.x > size.z);
        let kz = if is_x {
            0
        } else {
            2 - usize::from(size.y > size.z)
        };
        let along = dir.to_array();
        let is_back = usize::from(along[kz] < 0.0);
        let others = OTHERS[kz & 3];
        let (kx, ky) = (others[is_back], others[1 - is_back]);
        let sheared = Vec4::new(along[kx], along[ky], 1.0, 1.0) / along[kz];
        let shear = sheared.truncate();
        Self {
            kx,
            ky,
            kz,
            shear,
            dir,
        }
    }

    /// The axes that take the place of x, y and z, and what is sheared by.
    #[inline(always)]
    pub fn parts(&self) -> ([usize; 3], Vec3) {
        ([self.kx, self.ky, self.kz], self.shear)
    }

    /// The hit, at any t (also behind the origin); none for a miss or a triangle without area.
    #[inline]
    pub fn intersect(&self, origin: Vec3, corners: [Vec3; 3]) -> Option<TriangleHit> {
        let [a, b, c] = corners.map(|corner| corner - origin);
        let sheared = |p: Vec3| {
            let z = p[self.kz];
            (p[self.kx] - self.shear.x * z, p[self.ky] - self.shear.y * z)
        };
        let ((ax, ay), (bx, by), (cx, cy)) = (sheared(a), sheared(b), sheared(c));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        // Of a triangle without area, or seen along its plane, the signs are noise: they hold all along its line.
        // A triangle that the ray does pass through in exact arithmetic is not left out, so this opens no leak.
        let apart = |a: f32, b: f32, c: f32| a.min(b).min(c) > 0.0 || a.max(b).max(c) < 0.0;
        if apart(ax, bx, cx) || apart(ay, by, cy) {
            return None;
        }
        if u + v + w == 0.0 {
            return None;
        }
        let depths = [a, b, c].map(|p| self.shear.z * p[self.kz]);
        Some(self.hit(origin, corners, [u, v, w], depths))
    }

    /// The hit of a ray that passes within the edges: their values, which do not add up to 0, and the corners' depths.
    #[inline(always)]
    pub fn hit(
        &self,
        origin: Vec3,
        corners: [Vec3; 3],
        [u, v, w]: [f32; 3],
        depths: [f32; 3],
    ) -> TriangleHit {
        let det = u + v + w;
        let on_plane = self
            .plane_distance(origin, corners)
            .unwrap_or_else(|| (u * depths[0] + v * depths[1] + w * depths[2]) / det);
        let (least, most) = (depths[0].min(depths[1]), depths[0].max(depths[1]));
        TriangleHit {
            t: on_plane.max(least.min(depths[2])).min(most.max(depths[2])),
            u: (v / det).clamp(0.0, 1.0),
            v: (w / det).clamp(0.0, 1.0),
        }
    }

    /// Where the ray meets the triangle's plane, rounded once; none along the plane.
    #[inline(always)]
    fn plane_distance(&self, origin: Vec3, corners: [Vec3; 3]) -> Option<f32> {
        let [a, b, c] = corners;
        let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let normal = (b - a).cross(c - a);
        let along = normal.dot(self.dir.as_dvec3());
        (along != 0.0).then(|| (normal.dot(a - origin.as_dvec3()) / along) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    #[test]
    fn a_hit_reports_distance_and_weights() {
        let (origin, dir) = (Vec3::new(0.25, 0.5, 4.0), Vec3::new(0.0, 0.0, -2.0));
        let hit = Shear::new(dir).intersect(origin, CORNERS).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (2.0, 0.25, 0.5));
    }

    #[test]
    fn triangles_without_area_are_missed() {
        let dir = Vec3::NEG_Z;
        let shear = Shear::new(dir);
        assert!(shear.intersect(Vec3::Z, [Vec3::ZERO; 3]).is_none());
        let line = [Vec3::NEG_X, Vec3::ZERO, Vec3::X];
        assert!(shear.intersect(Vec3::Z, line).is_none());
    }

    #[test]
    fn a_triangle_without_area_is_not_met_beyond_its_ends() {
        // Corners on one line, and a ray through that line far from them.
        let corners = [
            Vec3::new(-0.375, 0.5, 0.5),
            Vec3::new(-0.375, 0.125, 0.5),
            Vec3::new(-0.375, 0.625, 0.5),
        ];
        let origin = Vec3::new(-0.4434635, 0.6563456, 1.8337411);
        let dir = Vec3::new(0.068463504, -1.4063456, -1.3337411);
        assert_eq!(Shear::new(dir).intersect(origin, corners), None);
    }

    #[test]
    fn a_ray_at_a_shared_edge_hits_one_of_the_two_triangles() {
        let mut random = Random::new(7);
        let mut point = || random.cube().as_vec3();
        let mut tried = 0;
        while tried < 100_000 {
            let (a, b) = (point(), point());
            let origin = point() * 5.0;
            let weight = point().x.abs();
            let target = a * weight + b * (1.0 - weight);
            let dir = target - origin;
            // Two corners on either side of the plane through the ray and the edge.
            let side = (b - a).cross(dir);
            let (left, right) = (a + side + point() * 0.1, b - side + point() * 0.1);
            if side.length() < 0.5 {
                continue;
            }
            tried += 1;
            let shear = Shear::new(dir);
            let hit = shear.intersect(origin, [a, b, left]).is_some()
                || shear.intersect(origin, [b, a, right]).is_some();
            assert!(hit, "leak between {a} and {b} from {origin} along {dir}");
        }
    }
}
