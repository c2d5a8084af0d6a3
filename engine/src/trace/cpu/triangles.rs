//! The watertight test of [`Shear`] for sixteen rays and a triangle.
//!
//! Decisions and roundings are those of the test of one ray, operation by operation; only its rare case, a ray along a
//! triangle's plane, is left to it.

use std::marker::PhantomData;
use std::ops::Range;

use glam::Vec3;

use super::group::Group;
use super::look::Cutout;
use super::query::{Key, Until};
use super::simd::{Floats, LANES, Mask, Row, Simd, Wide, lanes};
use crate::frame::wire::{InstanceRow, TriangleRow};
use crate::geom::Shear;
use crate::trace::PackedScene;
use crate::trace::pack::PackedMesh;

/// A group's rays in the space of a mesh.
#[repr(align(64))]
pub struct Local {
    /// Starts, by axis.
    pub origin: [Row; 3],
    /// Directions, by axis.
    pub dir: [Row; 3],
    /// [`Shear`]'s, of each lane.
    shear: [Row; 3],
    /// Where all rays start.
    shared: Option<Vec3>,
}

impl Local {
    /// Nothing yet.
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        dir: [[0.0; LANES]; 3],
        shear: [[0.0; LANES]; 3],
        shared: None,
    };

    /// Takes a group to the space of an instance; the axes of the shears if they are the same for all rays.
    #[inline(always)]
    pub fn enter<S: Simd>(
        &mut self,
        simd: S,
        group: &Group,
        row: &InstanceRow,
    ) -> Option<[usize; 3]> {
        let ([ox, oy, oz], [dx, dy, dz]) = (three(simd, &group.origin), three(simd, &group.dir));
        for (axis, [x, y, z, t]) in row.local_from_world.0.into_iter().enumerate() {
            let (x, y) = (simd.splat(x), simd.splat(y));
            let (z, t) = (simd.splat(z), simd.splat(t));
            // In the order of `Vec3::dot`.
            (x * ox + y * oy + z * oz + t).store(&mut self.origin[axis]);
            (x * dx + y * dy + z * dz).store(&mut self.dir[axis]);
        }
        let first = Vec3::new(self.origin[0][0], self.origin[1][0], self.origin[2][0]);
        let [x, y, z] = three(simd, &self.origin);
        let same =
            x.eq(simd.splat(first.x)) & y.eq(simd.splat(first.y)) & z.eq(simd.splat(first.z));
        self.shared = if same == Mask::MAX { Some(first) } else { None };
        let axes = self.axes(simd)?;
        let [kx, ky, kz] = axes;
        let (dx, dy) = (simd.load(&self.dir[kx]), simd.load(&self.dir[ky]));
        let dz = simd.load(&self.dir[kz]);
        (dx / dz).store(&mut self.shear[0]);
        (dy / dz).store(&mut self.shear[1]);
        (simd.splat(1.0) / dz).store(&mut self.shear[2]);
        Some(axes)
    }

    /// Which axes take the place of x, y and z, if that is the same for all rays.
    #[inline(always)]
    fn axes<S: Simd>(&self, simd: S) -> Option<[usize; 3]> {
        let zero = simd.splat(0.0);
        let [x, y, z] = three(simd, &self.dir);
        let (x, y, z) = (x.max(zero - x), y.max(zero - y), z.max(zero - z));
        let is_x = y.lt(x) & z.lt(x);
        let is_y = z.lt(y) & !is_x;
        let axis = match (is_x, is_y) {
            (Mask::MAX, _) => 0,
            (0, Mask::MAX) => 1,
            (0, 0) => 2,
            _ => return None,
        };
        let (next, after) = ((axis + 1) % 3, (axis + 2) % 3);
        match simd.load(&self.dir[axis]).lt(zero) {
            0 => Some([next, after, axis]),
            Mask::MAX => Some([after, next, axis]),
            _ => None,
        }
    }

    /// From where rays start to a corner, along an axis.
    #[inline(always)]
    fn to<S: Simd>(&self, simd: S, corner: Vec3, axis: usize) -> S::Floats {
        match self.shared {
            Some(origin) => simd.splat(corner[axis] - origin[axis]),
            None => simd.splat(corner[axis]) - simd.load(&self.origin[axis]),
        }
    }

    fn ray(&self, lane: usize) -> (Vec3, Vec3) {
        let of = |rows: &[Row; 3]| Vec3::from(rows.each_ref().map(|row| row[lane]));
        (of(&self.origin), of(&self.dir))
    }
}

/// A mesh's triangles as a packet meets them.
pub struct Fan<'a, U> {
    purpose: PhantomData<U>,
    scene: &'a PackedScene,
    mesh: &'a PackedMesh,
    id: u32,
    cutout: Option<Cutout>,
    axes: [usize; 3],
}

/// Sixteen hits of a triangle.
struct Hits<F> {
    t: F,
    u: F,
    v: F,
}

impl<'a, U: Until> Fan<'a, U> {
    /// Of an instance, for rays with these axes of shear.
    pub fn new(
        scene: &'a PackedScene,
        mesh: &'a PackedMesh,
        id: u32,
        row: &InstanceRow,
        axes: [usize; 3],
    ) -> Self {
        Self {
            purpose: PhantomData,
            scene,
            mesh,
            id,
            cutout: Cutout::of(scene, row),
            axes,
        }
    }

    /// Offers the hits of some triangles; whether any was taken.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        simd: S,
        group: &mut Group,
        local: &Local,
        triangles: Range<u32>,
    ) -> bool {
        let mut is_any = false;
        for place in triangles {
            let triangle = &self.mesh.triangles[place as usize];
            let corners = self.mesh.corners(triangle);
            let Some((mask, hits)) = self.intersect(simd, group, local, corners) else {
                continue;
            };
            is_any |= self.offer(simd, group, (place, triangle), mask, hits);
        }
        is_any
    }

    /// The lanes that meet a triangle ahead of the best so far, and maybe others at the same distance.
    #[inline(always)]
    fn intersect<S: Simd>(
        &self,
        simd: S,
        group: &Group,
        local: &Local,
        corners: [Vec3; 3],
    ) -> Option<(Mask, Hits<S::Floats>)> {
        let [kx, ky, kz] = self.axes;
        let zero = simd.splat(0.0);
        let [shear_x, shear_y, shear_z] = three(simd, &local.shear);
        let [a, b, c] = corners;
        let (az, bz, cz) = (
            local.to(simd, a, kz),
            local.to(simd, b, kz),
            local.to(simd, c, kz),
        );
        let (ax, ay) = (
            local.to(simd, a, kx) - shear_x * az,
            local.to(simd, a, ky) - shear_y * az,
        );
        let (bx, by) = (
            local.to(simd, b, kx) - shear_x * bz,
            local.to(simd, b, ky) - shear_y * bz,
        );
        let (cx, cy) = (
            local.to(simd, c, kx) - shear_x * cz,
            local.to(simd, c, ky) - shear_y * cz,
        );
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let below = u.lt(zero) | v.lt(zero) | w.lt(zero);
        let above = zero.lt(u) | zero.lt(v) | zero.lt(w);
        let mut mask = group.active & !(below & above);
        if mask == 0 {
            return None;
        }
        let det = u + v + w;
        mask &= !(apart(simd, ax, bx, cx) | apart(simd, ay, by, cy) | det.eq(zero));
        let (da, db, dc) = (shear_z * az, shear_z * bz, shear_z * cz);
        let (least, most) = (da.min(db).min(dc), da.max(db).max(dc));
        let best = simd.load(&group.t);
        let after = simd.load(&group.after);
        mask &= least.le(best) & after.lt(most);
        if mask == 0 {
            return None;
        }
        let (plane, unknown) = plane_distance(simd, local, corners);
        let one = simd.splat(1.0);
        let mut hits = Hits {
            t: plane.max(least).min(most),
            u: one.min(zero.max(v / det)),
            v: one.min(zero.max(w / det)),
        };
        if unknown & mask != 0 {
            mask = alone(simd, local, corners, unknown & mask, mask, &mut hits);
        }
        mask &= hits.t.le(best) & after.lt(hits.t);
        (mask != 0).then_some((mask, hits))
    }

    /// Takes the hits that come before the best so far.
    #[inline(always)]
    fn offer<S: Simd>(
        &self,
        simd: S,
        group: &mut Group,
        (place, triangle): (u32, &TriangleRow),
        mut mask: Mask,
        hits: Hits<S::Floats>,
    ) -> bool {
        let prim = triangle.prim;
        if group.has_starts {
            let starts_on = simd.equal_bits(&group.start_id, self.id)
                & simd.equal_bits(&group.start_prim, prim);
            mask &= !starts_on;
        }
        let ties = hits.t.eq(simd.load(&group.t)) & mask;
        for lane in lanes(ties) {
            let best = group.key(lane);
            if (self.id, prim) >= (best.id, best.prim) {
                mask &= !(1 << lane);
            }
        }
        if let Some(cutout) = &self.cutout {
            let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
            hits.u.store(&mut u);
            hits.v.store(&mut v);
            for lane in lanes(mask) {
                let weights = [u[lane], v[lane]];
                if cutout.is_hole(self.scene, self.mesh, triangle, weights) {
                    mask &= !(1 << lane);
                }
            }
        }
        if mask == 0 {
            return false;
        }
        hits.t.store_where(mask, &mut group.t);
        hits.u.store_where(mask, &mut group.uv[0]);
        hits.v.store_where(mask, &mut group.uv[1]);
        simd.splat(f32::from_bits(self.id))
            .store_where(mask, &mut group.id);
        simd.splat(f32::from_bits(prim))
            .store_where(mask, &mut group.prim);
        simd.splat(f32::from_bits(place))
            .store_where(mask, &mut group.triangle);
        group.hit |= mask;
        let key = Key {
            t: 0.0,
            id: self.id,
            prim,
        };
        if U::ends(self.scene, key) {
            group.active &= !mask;
        }
        true
    }
}

/// Lanes in which all corners are on one side of the ray.
#[inline(always)]
fn apart<S: Simd>(simd: S, a: S::Floats, b: S::Floats, c: S::Floats) -> Mask {
    let zero = simd.splat(0.0);
    zero.lt(a.min(b).min(c)) | a.max(b).max(c).lt(zero)
}

#[inline(always)]
fn three<S: Simd>(simd: S, rows: &[Row; 3]) -> [S::Floats; 3] {
    [
        simd.load(&rows[0]),
        simd.load(&rows[1]),
        simd.load(&rows[2]),
    ]
}

/// Distances to a triangle's plane, rounded once, and the lanes along the plane.
#[inline(always)]
fn plane_distance<S: Simd>(simd: S, local: &Local, corners: [Vec3; 3]) -> (S::Floats, Mask) {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a);
    let (nx, ny) = (simd.splat_wide(normal.x), simd.splat_wide(normal.y));
    let nz = simd.splat_wide(normal.z);
    let [dx, dy, dz] = three(simd, &local.dir);
    let along = nx * dx.wide() + ny * dy.wide() + nz * dz.wide();
    let height = match local.shared {
        Some(origin) => simd.splat_wide(normal.dot(a - origin.as_dvec3())),
        None => {
            let [x, y, z] = three(simd, &local.origin);
            let (x, y) = (
                simd.splat_wide(a.x) - x.wide(),
                simd.splat_wide(a.y) - y.wide(),
            );
            nx * x + ny * y + nz * (simd.splat_wide(a.z) - z.wide())
        }
    };
    ((height / along).narrow(), along.is_zero())
}

/// Replaces the hits of some lanes by those of the test of one ray; the lanes of `mask` that have one.
#[inline(always)]
fn alone<S: Simd>(
    simd: S,
    local: &Local,
    corners: [Vec3; 3],
    which: Mask,
    mut mask: Mask,
    hits: &mut Hits<S::Floats>,
) -> Mask {
    let mut rows = [[0.0; LANES]; 3];
    hits.t.store(&mut rows[0]);
    hits.u.store(&mut rows[1]);
    hits.v.store(&mut rows[2]);
    for lane in lanes(which) {
        let (origin, dir) = local.ray(lane);
        match Shear::new(dir).intersect(origin, corners) {
            Some(hit) => {
                for (row, x) in rows.iter_mut().zip([hit.t, hit.u, hit.v]) {
                    row[lane] = x;
                }
            }
            None => mask &= !(1 << lane),
        }
    }
    let [t, u, v] = three(simd, &rows);
    *hits = Hits { t, u, v };
    mask
}
