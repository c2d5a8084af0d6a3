//! A ray through a mesh: against eight boxes at a time, and four triangles.
//!
//! Called by [`super::traverse`] for every ray that goes alone. What a ray meets is what the twin in `shaders/shared/` meets:
//! boxes hold all that is in them, and triangles are decided by the test of [`Shear`], operation by operation, four at a time
//! from rows where they lie by lanes ([`PackedMesh::lanes`]); what passes is finished by it.

use glam::{BVec4A, Vec3, Vec4};

use super::look::Cutout;
use super::query::Until;
use super::simd::{Eight, Simd};
use super::stack::Stack;
use super::traverse::{Search, reach};
use crate::bvh::CHILD_LEAF;
use crate::geom::{FAR_WIDENING, Shear, SlabRay, TriangleHit};
use crate::trace::pack::{Block, Node8, PackedMesh, blocks_of};

/// A mesh as a ray meets it: instance id, mesh, and where its holes are.
pub type Met<'a> = (u32, &'a PackedMesh, Option<&'a Cutout>);

/// A ray in the space of a mesh.
struct Ready<S: Simd> {
    /// Rows of a node: where the ray comes to a slab, and where it leaves it.
    sides: [(usize, usize); 3],
    from: [S::Eight; 3],
    inverse: [S::Eight; 3],
    widening: S::Eight,
    origin: Vec3,
    /// The origin along the axes of the shear.
    from_axes: [f32; 3],
    shear: Shear,
    axes: [usize; 3],
    by: Vec3,
}

impl<S: Simd> Ready<S> {
    #[inline(always)]
    fn new(simd: S, origin: Vec3, dir: Vec3) -> Self {
        let slab = SlabRay::new(origin, dir);
        let shear = Shear::new(dir);
        let (axes, by) = shear.parts();
        let [kx, ky, kz] = axes;
        let [x, y, z] = slab.inverse.to_array();
        Self {
            sides: [side(0, x), side(1, y), side(2, z)],
            from: [
                simd.splat_eight(origin.x),
                simd.splat_eight(origin.y),
                simd.splat_eight(origin.z),
            ],
            inverse: [
                simd.splat_eight(x),
                simd.splat_eight(y),
                simd.splat_eight(z),
            ],
            widening: simd.splat_eight(FAR_WIDENING),
            origin,
            from_axes: [origin[kx], origin[ky], origin[kz]],
            shear,
            axes,
            by,
        }
    }

    /// [`super::enter::enter_boxes`] of eight: where the ray comes to boxes, and a bit mask of those entered.
    #[inline(always)]
    fn enter(&self, simd: S, node: &Node8, (from, to): (S::Eight, S::Eight)) -> (S::Eight, u32) {
        let rows: &[[f32; 8]; 8] = bytemuck::cast_ref(node);
        let [(near_x, far_x), (near_y, far_y), (near_z, far_z)] = self.sides;
        let [from_x, from_y, from_z] = self.from;
        let [by_x, by_y, by_z] = self.inverse;
        let near_x = (simd.load_eight(&rows[near_x & 7]) - from_x) * by_x;
        let near_y = (simd.load_eight(&rows[near_y & 7]) - from_y) * by_y;
        let near_z = (simd.load_eight(&rows[near_z & 7]) - from_z) * by_z;
        let far_x = (simd.load_eight(&rows[far_x & 7]) - from_x) * by_x;
        let far_y = (simd.load_eight(&rows[far_y & 7]) - from_y) * by_y;
        let far_z = (simd.load_eight(&rows[far_z & 7]) - from_z) * by_z;
        let near = near_x.max(near_y).max(near_z.max(from));
        let far = far_x.min(far_y).min(far_z) * self.widening;
        (near, near.le(far.min(to)))
    }

    /// One corner of each of four triangles: sheared, and its depth.
    #[inline(always)]
    fn corner(&self, rows: &[[f32; 4]; 4]) -> (Vec4, Vec4, Vec4) {
        let [kx, ky, kz] = self.axes;
        let [from_x, from_y, from_z] = self.from_axes;
        let z = Vec4::from_array(rows[kz & 3]) - from_z;
        let x = Vec4::from_array(rows[kx & 3]) - from_x - self.by.x * z;
        let y = Vec4::from_array(rows[ky & 3]) - from_y - self.by.y * z;
        (x, y, z * self.by.z)
    }

    /// Offers the hits of four triangles; whether the search is over.
    #[inline(always)]
    fn meet<U: Until>(&self, search: &mut Search<'_, U>, instance: Met, block: &Block) -> bool {
        let (ax, ay, az) = self.corner(&block.rows[0]);
        let (bx, by, bz) = self.corner(&block.rows[1]);
        let (cx, cy, cz) = self.corner(&block.rows[2]);
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = Vec4::ZERO;
        let below = u.cmplt(zero) | v.cmplt(zero) | w.cmplt(zero);
        let above = u.cmpgt(zero) | v.cmpgt(zero) | w.cmpgt(zero);
        let split = (below & above).bitmask();
        if split == 0b1111 {
            return false;
        }
        let missed = apart(ax, bx, cx) | apart(ay, by, cy) | (u + v + w).cmpeq(zero);
        let (after, best) = search.limits();
        let (least, most) = (az.min(bz).min(cz), az.max(bz).max(cz));
        let is_near = least.cmple(Vec4::splat(best)) & most.cmpgt(Vec4::splat(after));
        let mut rest = is_near.bitmask() & !(split | missed.bitmask());
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let hit: TriangleHit = self.shear.hit(
                self.origin,
                block.corners(lane),
                [of(u, lane), of(v, lane), of(w, lane)],
                [of(az, lane), of(bz, lane), of(cz, lane)],
            );
            if search.triangle(instance, (block.place(lane), block.prim(lane)), hit) {
                return true;
            }
        }
        false
    }
}

/// Rows of a node along an axis: where a ray comes to a slab, and where it leaves it.
#[inline(always)]
fn side(axis: usize, inverse: f32) -> (usize, usize) {
    let back = 3 * usize::from(!(inverse > 0.0));
    (axis + back, axis + 3 - back)
}

#[inline(always)]
fn of(four: Vec4, lane: usize) -> f32 {
    four.to_array()[lane & 3]
}

/// Where all corners are on one side of the ray.
#[inline(always)]
fn apart(a: Vec4, b: Vec4, c: Vec4) -> BVec4A {
    let zero = Vec4::ZERO;
    a.min(b).min(c).cmpgt(zero) | a.max(b).max(c).cmplt(zero)
}

/// Visits what a ray may have a hit in, nearest box first if the nearest hit is sought; the ray is the mesh's own, and the
/// mesh has lanes. True: the search is over.
#[inline(always)]
pub fn walk_eights<S: Simd, U: Until>(
    simd: S,
    search: &mut Search<'_, U>,
    instance: Met,
    (origin, dir): (Vec3, Vec3),
    stack: &mut Stack,
) -> bool {
    let lanes = &instance.1.lanes;
    let (nodes, blocks) = (&lanes.nodes[..], &lanes.blocks[..]);
    let ray = Ready::new(simd, origin, dir);
    let base = stack.len;
    let (after, best) = search.limits();
    let from = simd.splat_eight(after);
    let mut to = reach(best);
    let mut next = 0;
    loop {
        if next & CHILD_LEAF == 0 {
            let node = &nodes[next as usize];
            let (near, entered) = ray.enter(simd, node, (from, simd.splat_eight(to)));
            if entered != 0 {
                let mut entries = [0.0; 8];
                let below = stack.len;
                next = if U::IS_NEAREST {
                    near.store(&mut entries);
                    stack.push_nearest_of(&node.children, &entries, entered)
                } else {
                    stack.push_any_of(&node.children, entered)
                };
                stack.ask_for_eights(below, nodes, blocks);
                continue;
            }
        } else {
            let (first, end) = blocks_of(next);
            for block in &blocks[first as usize..end as usize] {
                if ray.meet(search, instance, block) {
                    stack.len = base;
                    return true;
                }
            }
            to = reach(search.limits().1);
        }
        loop {
            if stack.len == base {
                return false;
            }
            let (child, near) = stack.pop();
            if !U::IS_NEAREST || near <= to {
                next = child;
                break;
            }
        }
    }
}
