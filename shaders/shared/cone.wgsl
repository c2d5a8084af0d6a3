// What: the closed cone, truncated or not, of which a cylinder is one: |y| <= 1, its larger radius 1; see the twin.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/cone.rs.
#define_import_path orrery::cone

#import orrery::types::NONE
#import orrery::slab::slab_ray
#import orrery::affine::unit_or

const CONE_SIDE: u32 = 0u;
const CONE_CAP_A: u32 = 1u;
const CONE_CAP_B: u32 = 2u;

// Stands for zero where a division needs something.
const TINY: f32 = 1e-30;
// Beyond everything, in lengths of a solid's own space.
const BEYOND: f32 = 1e18;
// The squared radius of the sphere around the solid, and some more.
const BOUND: f32 = 2.0001;

// What a ray meets: entry and exit, each if it is a hit.
struct ConeHit {
    enters: bool,
    near: f32,
    near_prim: u32,
    leaves: bool,
    far: f32,
    far_prim: u32,
}

// Where a ray is within the infinite nappe of the side.
struct SideSpan {
    hits: bool,
    near: f32,
    far: f32,
}

fn cone_radius(taper: f32, y: f32) -> f32 {
    return (1.0 - abs(taper)) + taper * y;
}

// `start`: the primitive of this solid that the ray starts on, or NONE. Such a ray can only leave it: its entry is
// behind it, and the side it starts on answers with its other root.
fn hit_cone(origin: vec3f, dir: vec3f, taper: f32, start: u32) -> ConeHit {
    let side = side_span(origin, dir, taper, start == CONE_SIDE);
    let ray = slab_ray(origin, dir);
    let at_a = (-1.0 - origin.y) * ray.inverse.y;
    let at_b = (1.0 - origin.y) * ray.inverse.y;
    let upward = ray.inverse.y > 0.0;
    let enter = select(at_b, at_a, upward);
    let leave = select(at_a, at_b, upward);
    let enter_cap = select(CONE_CAP_B, CONE_CAP_A, upward);
    let leave_cap = select(CONE_CAP_A, CONE_CAP_B, upward);
    let near = max(enter, side.near);
    let far = min(leave, side.far);
    let near_prim = select(CONE_SIDE, enter_cap, enter > side.near);
    let far_prim = select(CONE_SIDE, leave_cap, leave < side.far);
    let hits = side.hits && near <= far && !is_outside(origin, taper, start);
    // The root where it starts is exactly 0, which no ray asks for.
    let leaves = hits && (far_prim == CONE_SIDE || far_prim != start);
    return ConeHit(hits && start == NONE, near, near_prim, leaves, far, far_prim);
}

// Whether a ray that starts on a primitive starts beyond it: the solid is convex, so it meets it no more.
fn is_outside(origin: vec3f, taper: f32, prim: u32) -> bool {
    if prim == NONE {
        return false;
    }
    if prim == CONE_SIDE {
        return length(origin.xz) > cone_radius(taper, origin.y);
    }
    return select(origin.y > 1.0, origin.y < -1.0, prim == CONE_CAP_A);
}

fn side_span(origin: vec3f, dir: vec3f, taper: f32, starts_on: bool) -> SideSpan {
    let miss = SideSpan(false, 0.0, 0.0);
    let inverse_length = 1.0 / max(length(dir), TINY);
    let along = dir * inverse_length;
    let middle = select(-dot(origin, along), 0.0, starts_on);
    let at = origin + along * middle;
    if !starts_on && dot(at, at) > BOUND {
        return miss;
    }
    let o = at.xz;
    let d = along.xz;
    let radius = cone_radius(taper, at.y);
    let widening = taper * along.y;
    let slope = length(d);
    let a = (slope - abs(widening)) * (slope + abs(widening));
    let b = radius * widening - dot(o, d);
    let divisor = select(a, TINY, abs(a) < TINY);
    var roots = vec2f(0.0, 2.0 * b / divisor);
    if !starts_on {
        let lateral = length(o * widening - d * radius);
        let across = abs(o.x * d.y - o.y * d.x);
        let discriminant = (lateral - across) * (lateral + across);
        if a > 0.0 && discriminant < 0.0 {
            return miss;
        }
        let root = sqrt(max(discriminant, 0.0));
        let q = select(b - root, b + root, b >= 0.0);
        let distance = length(o);
        let c = (distance - abs(radius)) * (distance + abs(radius));
        if root < 0.5 * abs(b) && abs(a) > 0.1 * slope * slope {
            // The ray all but touches: c is rounding, and neither this difference nor a cancels much.
            roots = vec2f((b + b - q) / divisor, q / divisor);
        } else if abs(q) >= TINY {
            roots = vec2f(c / q, q / divisor);
        } else if abs(a) >= TINY {
            roots = vec2f(b / divisor);
        } else if c <= 0.0 {
            // Along the axis of a cylinder, inside.
            roots = vec2f(-BEYOND, BEYOND);
        } else {
            return miss;
        }
    }
    var near = min(roots.x, roots.y);
    var far = max(roots.x, roots.y);
    // Steeper than the side, a ray is inside of either nappe for ever; else between both roots, on one nappe.
    if a >= 0.0 {
        if radius * divisor + widening * b < 0.0 {
            return miss;
        }
    } else if widening > 0.0 {
        near = far;
        far = BEYOND;
    } else {
        far = near;
        near = -BEYOND;
    }
    return SideSpan(true, (middle + near) * inverse_length, (middle + far) * inverse_length);
}

struct ConePoint {
    at: vec3f,
    normal: vec3f,
    // Sizes of the numbers that `at` was rounded from.
    roundings: vec3f,
}

// A point near the solid moved onto a primitive of it.
fn cone_point(near: vec3f, taper: f32, prim: u32) -> ConePoint {
    let out = unit_or(vec3f(near.x, 0.0, near.z), vec3f(1.0, 0.0, 0.0));
    if prim == CONE_SIDE {
        let y = clamp(near.y, -1.0, 1.0);
        let at = out * cone_radius(taper, y) + vec3f(0.0, y, 0.0);
        // The radius rounds as the larger one does, however small it is here.
        return ConePoint(at, vec3f(out.x, -taper, out.z), abs(out) * 2.0);
    }
    let y = select(1.0, -1.0, prim == CONE_CAP_A);
    let radius = cone_radius(taper, y);
    let inside = select(near.xz, out.xz * radius, length(near.xz) > radius);
    let at = vec3f(inside.x, y, inside.y);
    return ConePoint(at, vec3f(0.0, y, 0.0), abs(at));
}
