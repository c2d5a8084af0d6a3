//! A ray against the four boxes, or spheres, of a node: where it enters each, and which it enters at all.
//!
//! Twin of `shaders/shared/slab.wgsl`, where a plane's distance is one fused product and what that errs by is in the ray.

use glam::{Vec3, Vec4};

use crate::bvh::{CHILD_NONE, Node4};
use crate::geom::{FAR_WIDENING, SlabRay};

/// 2^-19: what the test of a sphere errs by, of the distance to its centre.
const SPHERE_SLACK: f32 = 1.0 / 524_288.0;
/// Times a number, what leads to the one next to it (see [`crate::bvh::Extent::grown`]).
const NEXT: f32 = f32::EPSILON / 2.0 * (1.0 + f32::EPSILON);

/// Distances and a bit mask of the boxes entered between `from` and `to`. Empty slots may be in it.
#[inline]
pub fn enter_boxes(node: &Node4, slab: &SlabRay, (from, to): (f32, f32)) -> (Vec4, u32) {
    let rows: &[[f32; 4]; 7] = bytemuck::cast_ref(node);
    let axis = |axis: usize| {
        let inverse = slab.inverse[axis];
        let (least, greatest) = (slab.from_least[axis], slab.from_greatest[axis]);
        let (near, far, from_near, from_far) = if inverse > 0.0 {
            (axis, axis + 3, least, greatest)
        } else {
            (axis + 3, axis, greatest, least)
        };
        (
            (Vec4::from(rows[near]) - from_near) * inverse,
            (Vec4::from(rows[far]) - from_far) * inverse,
        )
    };
    let (near_x, far_x) = axis(0);
    let (near_y, far_y) = axis(1);
    let (near_z, far_z) = axis(2);
    let near = near_x.max(near_y).max(near_z.max(Vec4::splat(from)));
    let far = far_x.min(far_y).min(far_z) * FAR_WIDENING;
    (near, near.cmple(far.min(Vec4::splat(to))).bitmask())
}

/// The same by the slab test as it is written down, on the boxes that [`crate::geom::Aabb::grown`] made of
/// the ones it is asked about: their growth is taken off again, exactly above 1e-13 and at zero.
#[inline]
pub fn enter_bare_boxes(node: &Node4, slab: &SlabRay, (from, to): (f32, f32)) -> (Vec4, u32) {
    let inward = |side: &[f32; 4]| (Vec4::from(*side).abs() * NEXT).max(Vec4::splat(1e-20));
    let axis = |min: &[f32; 4], max: &[f32; 4], axis: usize| {
        let (origin, inverse) = (slab.from_least[axis], slab.inverse[axis]);
        let low = (Vec4::from(*min) + inward(min) - origin) * inverse;
        let high = (Vec4::from(*max) - inward(max) - origin) * inverse;
        (low.min(high), low.max(high))
    };
    let (near_x, far_x) = axis(&node.min_x, &node.max_x, 0);
    let (near_y, far_y) = axis(&node.min_y, &node.max_y, 1);
    let (near_z, far_z) = axis(&node.min_z, &node.max_z, 2);
    let near = near_x.max(near_y).max(near_z.max(Vec4::splat(from)));
    let far = far_x.min(far_y).min(far_z.min(Vec4::splat(to)));
    // Sides that are the wrong way round are turned here: what is not there would be entered.
    let there = (0..4).filter(|&slot| node.children[slot] != CHILD_NONE);
    let there = there.fold(0, |mask, slot| mask | 1 << slot);
    (near, near.cmple(far).bitmask() & there)
}

/// The same of spheres: centre in `min_x`, `min_y`, `min_z`, radius in `max_x`.
#[inline]
pub fn enter_spheres(node: &Node4, origin: Vec3, dir: Vec3, (from, to): (f32, f32)) -> (Vec4, u32) {
    let [x, y, z] = [
        Vec4::splat(origin.x) - Vec4::from(node.min_x),
        Vec4::splat(origin.y) - Vec4::from(node.min_y),
        Vec4::splat(origin.z) - Vec4::from(node.min_z),
    ];
    let a = dir.length_squared().max(1e-30);
    let middle = (x * dir.x + y * dir.y + z * dir.z) / -a;
    let rest = [x + middle * dir.x, y + middle * dir.y, z + middle * dir.z];
    let root = |v: Vec4| Vec4::from(v.to_array().map(f32::sqrt));
    let slack = root(x * x + y * y + z * z) * SPHERE_SLACK;
    let radius = Vec4::from(node.max_x) + slack;
    let inside = radius * radius - rest.into_iter().map(|r| r * r).sum::<Vec4>();
    let half = (root(inside.max(Vec4::ZERO)) + slack) / a.sqrt();
    let near = (middle - half).max(Vec4::splat(from));
    let entered = near.cmple((middle + half).min(Vec4::splat(to)));
    let entered = entered.bitmask() & inside.cmpge(Vec4::ZERO).bitmask();
    (near, entered)
}
