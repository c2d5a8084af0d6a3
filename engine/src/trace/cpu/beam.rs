//! Boxes against many rays at once: against bounds on their origins and directions.
//!
//! The arithmetic is that of [`super::enter`] on the bounds' ends. Rounding keeps order, so where the bounds miss a box, so
//! does every ray: what a beam enters holds all that its rays enter ("interval arithmetic" in Boulos, Wald and Shirley,
//! "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006).

use glam::{Vec3, Vec4};

use super::simd::{Floats, LANES, Row, Simd};
use crate::bvh::Node4;
use crate::geom::{FAR_WIDENING, safe_reciprocal};

/// Sixteen-ray groups of a packet.
pub const GROUPS: usize = 4;

/// Stands for a plane that is as far as can be, before or behind.
const BEYOND: f32 = 1e37;

/// Bounds on the rays of a group.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// The greatest of where least sides of boxes are measured from.
    from_least: Vec3,
    /// The least of where greatest sides are measured from.
    from_greatest: Vec3,
    /// Of reciprocals of directions.
    inverse: (Vec3, Vec3),
}

impl Bounds {
    /// Of no ray: what is around it and others is around the others. A beam of it alone is to be asked nothing.
    pub const NOTHING: Self = Self {
        from_least: Vec3::MIN,
        from_greatest: Vec3::MAX,
        inverse: (Vec3::MAX, Vec3::MIN),
    };

    /// Of sixteen rays whose origins are off by at most `slack`.
    #[inline(always)]
    pub fn of<S: Simd>(simd: S, origin: &[Row; 3], slack: Vec3, dir: &[Row; 3]) -> Self {
        let mut bounds = Self {
            from_least: Vec3::ZERO,
            from_greatest: Vec3::ZERO,
            inverse: (Vec3::ZERO, Vec3::ZERO),
        };
        for axis in 0..3 {
            let mut inverse = [0.0; LANES];
            for (inverse, &dir) in inverse.iter_mut().zip(&dir[axis]) {
                *inverse = safe_reciprocal(dir);
            }
            let inverse = simd.load(&inverse);
            let origin = simd.load(&origin[axis]);
            let slack = simd.splat(slack[axis]);
            bounds.from_least[axis] = (origin + slack).greatest();
            bounds.from_greatest[axis] = (origin - slack).least();
            bounds.inverse.0[axis] = inverse.least();
            bounds.inverse.1[axis] = inverse.greatest();
        }
        bounds
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self {
            from_least: self.from_least.max(other.from_least),
            from_greatest: self.from_greatest.min(other.from_greatest),
            inverse: (
                self.inverse.0.min(other.inverse.0),
                self.inverse.1.max(other.inverse.1),
            ),
        }
    }
}

/// Bounds on all groups of a packet, and on each.
pub struct Beam {
    /// Rows of a node: where rays come to a slab, and where they leave it.
    rows: [(usize, usize); 3],
    /// What these are measured from.
    from: [(f32, f32); 3],
    inverse: [(f32, f32); 3],
    groups_from: [(Vec4, Vec4); 3],
    groups_inverse: [(Vec4, Vec4); 3],
    /// No axis along which some rays go forth and some back.
    pub is_one_way: bool,
}

impl Beam {
    /// Around groups.
    #[inline(always)]
    pub fn new(groups: &[Bounds; GROUPS]) -> Self {
        let all = groups[1..].iter().fold(groups[0], |a, b| a.union(*b));
        let mut beam = Self {
            rows: [(0, 3), (1, 4), (2, 5)],
            from: [(BEYOND, -BEYOND); 3],
            inverse: [(1.0, 1.0); 3],
            groups_from: [(Vec4::splat(BEYOND), Vec4::splat(-BEYOND)); 3],
            groups_inverse: [(Vec4::ONE, Vec4::ONE); 3],
            is_one_way: true,
        };
        for axis in 0..3 {
            let inverse = (all.inverse.0[axis], all.inverse.1[axis]);
            let is_forth = inverse.0 > 0.0;
            if !is_forth && inverse.1 > 0.0 {
                // Nothing is known along this axis.
                beam.is_one_way = false;
                continue;
            }
            let [a, b, c, d] = groups;
            let each =
                |f: fn(&Bounds) -> Vec3| Vec4::new(f(a)[axis], f(b)[axis], f(c)[axis], f(d)[axis]);
            let least = each(|b| b.from_least);
            let greatest = each(|b| b.from_greatest);
            beam.inverse[axis] = inverse;
            beam.groups_inverse[axis] = (each(|b| b.inverse.0), each(|b| b.inverse.1));
            (beam.from[axis], beam.groups_from[axis]) = if is_forth {
                (
                    (all.from_least[axis], all.from_greatest[axis]),
                    (least, greatest),
                )
            } else {
                beam.rows[axis] = (3 + axis, axis);
                (
                    (all.from_greatest[axis], all.from_least[axis]),
                    (greatest, least),
                )
            };
        }
        beam
    }

    /// Distances and a bit mask of the boxes that some ray may enter between `from` and `to`. Empty slots may be in it.
    #[inline(always)]
    pub fn enter(&self, node: &Node4, (from, to): (f32, f32)) -> (Vec4, u32) {
        let rows = sides(node);
        let (mut near, mut far) = (Vec4::splat(from), Vec4::splat(f32::INFINITY));
        for axis in 0..3 {
            let (row_near, row_far) = self.rows[axis];
            let (least, greatest) = self.inverse[axis];
            let to_near = Vec4::from(rows[row_near]) - self.from[axis].0;
            let to_far = Vec4::from(rows[row_far]) - self.from[axis].1;
            near = near.max((to_near * least).min(to_near * greatest));
            far = far.min((to_far * least).max(to_far * greatest));
        }
        let far = (far * FAR_WIDENING).min(Vec4::splat(to));
        (near, near.cmple(far).bitmask())
    }

    /// Bit mask of the groups of which some ray may enter the box in a slot of a node between `from` and `to`.
    #[inline(always)]
    pub fn groups_entering(&self, node: &Node4, slot: usize, from: f32, to: Vec4) -> u32 {
        let rows = sides(node);
        let (mut near, mut far) = (Vec4::splat(from), Vec4::splat(f32::INFINITY));
        for axis in 0..3 {
            let (row_near, row_far) = self.rows[axis];
            let (least, greatest) = self.groups_inverse[axis];
            let to_near = Vec4::splat(rows[row_near][slot]) - self.groups_from[axis].0;
            let to_far = Vec4::splat(rows[row_far][slot]) - self.groups_from[axis].1;
            near = near.max((to_near * least).min(to_near * greatest));
            far = far.min((to_far * least).max(to_far * greatest));
        }
        near.cmple((far * FAR_WIDENING).min(to)).bitmask()
    }
}

/// The rows of a node, those of least sides first.
#[inline(always)]
fn sides(node: &Node4) -> &[[f32; 4]; 7] {
    bytemuck::cast_ref(node)
}
