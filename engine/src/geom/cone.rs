//! The closed cone, truncated or not, of which a cylinder is one: |y| <= 1 about the Y axis, its radius linear
//! in y, the larger of the radii at its ends 1. Size, place and turn are in the instance's transform.
//!
//! `taper` in [-1/2, 1/2] is half of what the radius gains from y = -1 to y = 1. Primitives: [`CONE_SIDE`],
//! [`CONE_CAP_A`] at y = -1, [`CONE_CAP_B`] at y = 1.
//!
//! A convex solid: where a ray is within the slab of the caps and within the side's nappe, it is inside.
//! So nothing leaks where side and caps meet. The side is x^2 + z^2 = w^2 with the radius w as a third
//! coordinate, and its discriminant is a sum of squares of 2x2 determinants (Lagrange's identity in the form
//! x^2 + z^2 - w^2), which do not depend on how far away the ray starts; it is still moved to its closest approach first (Wald,
//! "Improving Numerical Precision in Intersection Programs", Ray Tracing Gems II, 2021, ch. 34). Roots by the
//! stable quadratic (Haines et al., Ray Tracing Gems, 2019, ch. 7).
//!
//! Twin of `shaders/shared/cone.wgsl`.

use glam::{Vec2, Vec3};

use super::{SolidPoint, safe_reciprocal};

/// The side.
pub const CONE_SIDE: u32 = 0;
/// The cap at y = -1.
pub const CONE_CAP_A: u32 = 1;
/// The cap at y = 1.
pub const CONE_CAP_B: u32 = 2;

/// Stands for zero where a division needs something.
const TINY: f32 = 1e-30;
/// Beyond everything, in lengths of a solid's own space.
const BEYOND: f32 = 1e18;
/// The squared radius of the sphere around the solid, and some more.
const BOUND: f32 = 2.0001;

/// The radius at a height.
pub fn cone_radius(taper: f32, y: f32) -> f32 {
    (1.0 - taper.abs()) + taper * y
}

/// What a ray meets, entry first: `(t, primitive)`, t in lengths of `dir`.
///
/// A ray that starts on the solid's primitive `start` can only leave it: its entry is behind it, and the
/// side it starts on answers with its other root.
pub fn intersect_cone(
    origin: Vec3,
    dir: Vec3,
    taper: f32,
    start: Option<u32>,
) -> [Option<(f32, u32)>; 2] {
    if start.is_some_and(|prim| is_outside(origin, taper, prim)) {
        return [None; 2];
    }
    let Some((side_near, side_far)) = side_span(origin, dir, taper, start == Some(CONE_SIDE))
    else {
        return [None; 2];
    };
    let inverse = safe_reciprocal(dir.y);
    let (at_a, at_b) = ((-1.0 - origin.y) * inverse, (1.0 - origin.y) * inverse);
    let (enter, leave) = if inverse > 0.0 {
        ((at_a, CONE_CAP_A), (at_b, CONE_CAP_B))
    } else {
        ((at_b, CONE_CAP_B), (at_a, CONE_CAP_A))
    };
    let near = if enter.0 > side_near {
        enter
    } else {
        (side_near, CONE_SIDE)
    };
    let far = if leave.0 < side_far {
        leave
    } else {
        (side_far, CONE_SIDE)
    };
    if !(near.0 <= far.0) {
        return [None; 2];
    }
    match start {
        None => [Some(near), Some(far)],
        // The root where it starts is exactly 0, which no ray asks for.
        Some(prim) => [None, (far.1 == CONE_SIDE || far.1 != prim).then_some(far)],
    }
}

/// Whether a ray that starts on a primitive starts beyond it: the solid is convex, so it meets it no more. What the
/// directions say of a grazing ray may be rounding alone.
fn is_outside(origin: Vec3, taper: f32, prim: u32) -> bool {
    match prim {
        CONE_CAP_A => origin.y < -1.0,
        CONE_CAP_B => origin.y > 1.0,
        _ => Vec2::new(origin.x, origin.z).length() > cone_radius(taper, origin.y),
    }
}

/// Where a ray is within the infinite nappe of the side.
fn side_span(origin: Vec3, dir: Vec3, taper: f32, starts_on: bool) -> Option<(f32, f32)> {
    let inverse_length = dir.length().max(TINY).recip();
    let along = dir * inverse_length;
    let middle = if starts_on { 0.0 } else { -origin.dot(along) };
    let from = origin + along * middle;
    if !starts_on && from.length_squared() > BOUND {
        return None;
    }
    let (o, d) = (Vec2::new(from.x, from.z), Vec2::new(along.x, along.z));
    let (radius, widening) = (cone_radius(taper, from.y), taper * along.y);
    let (slope, distance) = (d.length(), o.length());
    let a = (slope - widening.abs()) * (slope + widening.abs());
    let b = radius * widening - o.dot(d);
    let divisor = if a.abs() < TINY { TINY } else { a };
    let (first, second) = if starts_on {
        (0.0, 2.0 * b / divisor)
    } else {
        let lateral = (o * widening - d * radius).length();
        let across = (o.x * d.y - o.y * d.x).abs();
        let discriminant = (lateral - across) * (lateral + across);
        if a > 0.0 && discriminant < 0.0 {
            return None;
        }
        let root = discriminant.max(0.0).sqrt();
        let q = if b >= 0.0 { b + root } else { b - root };
        let c = (distance - radius.abs()) * (distance + radius.abs());
        if root < 0.5 * b.abs() && a.abs() > 0.1 * slope * slope {
            // The ray all but touches: c is rounding, and neither this difference nor a cancels much.
            ((b + b - q) / divisor, q / divisor)
        } else if q.abs() >= TINY {
            (c / q, q / divisor)
        } else if a.abs() >= TINY {
            (b / divisor, b / divisor)
        } else if c <= 0.0 {
            // Along the axis of a cylinder, inside.
            (-BEYOND, BEYOND)
        } else {
            return None;
        }
    };
    let (low, high) = (first.min(second), first.max(second));
    // Steeper than the side, a ray is inside of either nappe for ever; else between both roots, on one nappe.
    let (low, high) = if a >= 0.0 {
        if radius * divisor + widening * b < 0.0 {
            return None;
        }
        (low, high)
    } else if widening > 0.0 {
        (high, BEYOND)
    } else {
        (-BEYOND, low)
    };
    Some((
        (middle + low) * inverse_length,
        (middle + high) * inverse_length,
    ))
}

/// A point near the solid moved onto a primitive of it.
pub fn cone_point(near: Vec3, taper: f32, prim: u32) -> SolidPoint {
    let outward = Vec2::new(near.x, near.z).normalize_or(Vec2::X);
    if prim == CONE_SIDE {
        let y = near.y.clamp(-1.0, 1.0);
        let at = outward * cone_radius(taper, y);
        return SolidPoint {
            at: Vec3::new(at.x, y, at.y),
            normal: Vec3::new(outward.x, -taper, outward.y),
            // The radius rounds as the larger one does, however small it is here.
            roundings: Vec3::new(outward.x, 0.0, outward.y).abs() * 2.0,
        };
    }
    let y = if prim == CONE_CAP_A { -1.0 } else { 1.0 };
    let radius = cone_radius(taper, y);
    let distance = Vec2::new(near.x, near.z).length();
    let at = if distance > radius {
        outward * radius
    } else {
        Vec2::new(near.x, near.z)
    };
    SolidPoint::on(Vec3::new(at.x, y, at.y), Vec3::Y * y)
}
