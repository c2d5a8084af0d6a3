//! The watertight test of [`Shear`] for a ray and four triangles, the most a leaf has but for a few.
//!
//! Decisions are those of the test of one triangle, operation by operation, four at a time; what passes is finished by it.

use std::ops::Range;

use glam::{BVec4A, Mat4, Vec3, Vec4};

use crate::frame::wire::{TriangleRow, VertexRow};
use crate::geom::{Shear, TriangleHit};
use crate::trace::pack::PackedMesh;

/// Triangles that are tested at once.
pub const FOUR: usize = 4;

/// A ray in the space of a mesh.
pub struct Prepared {
    origin: Vec3,
    shear: Shear,
    axes: [usize; 3],
    by: Vec3,
}

/// Edge values and depths of four triangles, and which of them the ray passes between the ends of its range.
pub struct Four {
    /// A bit a triangle.
    pub mask: u32,
    edges: [Vec4; 3],
    depths: [Vec4; 3],
}

impl Prepared {
    /// Of a ray.
    #[inline]
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        let shear = Shear::new(dir);
        let (axes, by) = shear.parts();
        Self {
            origin,
            shear,
            axes,
            by,
        }
    }

    /// Tests up to four triangles that may be hit after `after` and not after `best`.
    #[inline(always)]
    pub fn meet(&self, mesh: &PackedMesh, range: Range<u32>, (after, best): (f32, f32)) -> Four {
        let (first, last) = (range.start as usize, range.end as usize - 1);
        let (second, third) = (last.min(first + 1), last.min(first + 2));
        let triangles = &mesh.triangles[..];
        let rows = [
            &triangles[first],
            &triangles[second],
            &triangles[third],
            &triangles[last],
        ];
        let (ax, ay, az) = self.corners(mesh, rows, 0);
        let (bx, by, bz) = self.corners(mesh, rows, 1);
        let (cx, cy, cz) = self.corners(mesh, rows, 2);
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = Vec4::ZERO;
        let below = u.cmplt(zero) | v.cmplt(zero) | w.cmplt(zero);
        let above = u.cmpgt(zero) | v.cmpgt(zero) | w.cmpgt(zero);
        let missed =
            (below & above) | apart(ax, bx, cx) | apart(ay, by, cy) | (u + v + w).cmpeq(zero);
        let (least, most) = (az.min(bz).min(cz), az.max(bz).max(cz));
        let is_near = least.cmple(Vec4::splat(best)) & most.cmpgt(Vec4::splat(after));
        let count = range.end - range.start;
        Four {
            mask: !missed.bitmask() & is_near.bitmask() & ((1 << count) - 1),
            edges: [u, v, w],
            depths: [az, bz, cz],
        }
    }

    /// One corner of each of four triangles: sheared, and its depth.
    #[inline(always)]
    fn corners(
        &self,
        mesh: &PackedMesh,
        rows: [&TriangleRow; FOUR],
        which: usize,
    ) -> (Vec4, Vec4, Vec4) {
        let [a, b, c, d] = rows;
        let vertices = &mesh.vertices[..];
        let by_axis = Mat4::from_cols(
            row_of(&vertices[a.corners[which] as usize]),
            row_of(&vertices[b.corners[which] as usize]),
            row_of(&vertices[c.corners[which] as usize]),
            row_of(&vertices[d.corners[which] as usize]),
        )
        .transpose();
        let by_axis = [by_axis.x_axis, by_axis.y_axis, by_axis.z_axis];
        let [kx, ky, kz] = self.axes;
        let z = by_axis[kz] - self.origin[kz];
        let x = by_axis[kx] - self.origin[kx] - self.by.x * z;
        let y = by_axis[ky] - self.origin[ky] - self.by.y * z;
        (x, y, z * self.by.z)
    }

    /// The hit of one of four that is in the mask.
    #[inline]
    pub fn hit(&self, four: &Four, which: usize, corners: [Vec3; 3]) -> TriangleHit {
        let ([u, v, w], [a, b, c]) = (&four.edges, &four.depths);
        let edges = [u[which], v[which], w[which]];
        let depths = [a[which], b[which], c[which]];
        self.shear.hit(self.origin, corners, edges, depths)
    }
}

/// Where all corners are on one side of the ray.
#[inline(always)]
fn apart(a: Vec4, b: Vec4, c: Vec4) -> BVec4A {
    let zero = Vec4::ZERO;
    a.min(b).min(c).cmpgt(zero) | a.max(b).max(c).cmplt(zero)
}

/// A vertex and four bytes that are not looked at.
#[inline(always)]
fn row_of(vertex: &VertexRow) -> Vec4 {
    Vec4::from_array(bytemuck::cast(*vertex))
}
