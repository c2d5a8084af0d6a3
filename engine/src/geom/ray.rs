//! A ray prepared for box tests.

use glam::{Vec3, Vec4};

/// Below this a component of a direction is taken for this.
const LEAST: f32 = 1e-30;

/// 1/x with |x| clamped from below at 1e-30, sign kept: finite for every finite x, so that no product in
/// a slab test is 0 * infinity (the role of Embree's `rcp_safe`; the bound is measured on two drivers).
#[inline(always)]
pub fn safe_reciprocal(x: f32) -> f32 {
    if x.abs() < LEAST {
        LEAST.copysign(x).recip()
    } else {
        x.recip()
    }
}

/// [`safe_reciprocal`] of each component, in one division.
#[inline(always)]
fn safe_reciprocals(dir: Vec3) -> Vec3 {
    let dir = Vec4::from((dir, 1.0));
    let least = Vec4::splat(LEAST);
    let clamped = Vec4::select(dir.abs().cmplt(least), least.copysign(dir), dir);
    (Vec4::ONE / clamped).truncate()
}

/// Four ulps of 1: what the far side of a slab is widened by (Ize 2013).
pub const FAR_WIDENING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Origin and reciprocal direction.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// What the least sides of boxes are measured from: the origin, or a little beyond it.
    pub from_least: Vec3,
    /// What their greatest sides are measured from: the origin, or a little before it.
    pub from_greatest: Vec3,
    /// [`safe_reciprocal`] of each component of the direction; the plain one of a bare ray.
    pub inverse: Vec3,
}

impl SlabRay {
    /// From a ray.
    #[inline(always)]
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        Self::with_slack(origin, Vec3::ZERO, dir)
    }

    /// From a ray, with plain reciprocals: infinite along an axis (see [`crate::frame::BoxTest::Bare`]).
    pub fn bare(origin: Vec3, dir: Vec3) -> Self {
        Self {
            from_least: origin,
            from_greatest: origin,
            inverse: dir.recip(),
        }
    }

    /// From a ray whose origin may be off by `slack`: no box is missed that any such origin would meet.
    #[inline(always)]
    pub fn with_slack(origin: Vec3, slack: Vec3, dir: Vec3) -> Self {
        Self {
            from_least: origin + slack,
            from_greatest: origin - slack,
            inverse: safe_reciprocals(dir),
        }
    }
}
