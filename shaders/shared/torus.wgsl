// What: the torus of major radius 1 about the Y axis: roots of a quartic, isolated between the critical points of
// derivatives (Yuksel, "High-Performance Polynomial Root Finding for Graphics", HPG 2022); see the twin.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/torus.rs.
#define_import_path orrery::torus

#import orrery::affine::unit_or

// Stands for zero where a division needs something.
const TINY: f32 = 1e-30;
// Steps for a critical point: it need only part two roots.
const CRITICAL_STEPS: u32 = 12u;
// A Newton step no longer than this is the last one: it leaves about its square.
const CRITICAL_ACCURACY: f32 = 1e-3;
// Steps for a root: as many halvings as a tangent ray has digits.
const ROOT_STEPS: u32 = 24u;
// The same for a root. Less would wait for rounding to agree with itself.
const ROOT_ACCURACY: f32 = 1e-6;
// How far from where it starts a ray inside comes out, at least, in about: well ahead of what a root errs by.
const LEAST_EXIT: f32 = 4e-6;
// No root: before every ray.
const NO_ROOT: f32 = -3e38;

// A line in units of the major radius; `along` is unit.
struct Line {
    at: vec3f,
    along: vec3f,
    minor: f32,
}

// A function of the distance along a line: the surface itself, or where s^2 <= near the polynomial
// a s^3 + b s^2 + c s + d, of which it is a positive multiple there.
struct Curve {
    line: Line,
    polynomial: vec4f,
    near: f32,
}

// A value and its slope.
struct Value {
    value: f32,
    slope: f32,
}

// All distances to the torus in lengths of `dir`, nearest first, NO_ROOT where there is none; one that
// `starts_on` it leaves out where it starts.
fn hit_torus(origin: vec3f, dir: vec3f, minor: f32, starts_on: bool) -> vec4f {
    let inverse_length = 1.0 / max(length(dir), TINY);
    let along = dir * inverse_length;
    let middle = select(-dot(origin, along), 0.0, starts_on);
    let line = Line(origin + along * middle, along, minor);
    var roots: vec4f;
    if starts_on {
        roots = onward_roots(line);
    } else {
        roots = all_roots(line);
    }
    // NO_ROOT times a length would leave f32.
    let is_missed = roots == vec4f(NO_ROOT);
    let places = select(roots, vec4f(0.0), is_missed);
    return select((middle + places) * inverse_length, vec4f(NO_ROOT), is_missed);
}

// The roots of a line that is at its closest approach to the centre at s = 0.
fn all_roots(line: Line) -> vec4f {
    // A little more than the sphere around, so that the line is outside of the torus at both ends.
    let reach = (1.0 + line.minor) * (1.0 + line.minor) * 1.0001;
    let from_center = dot(line.at, line.at);
    let rest = reach - from_center;
    if !(rest > 0.0) {
        return vec4f(NO_ROOT);
    }
    let end = sqrt(rest);
    // Half the quartic's derivative: 2 s^3 + p s + q.
    let level = dot(line.along.xz, line.along.xz);
    let center = from_center + 1.0 - line.minor * line.minor;
    let p = 2.0 * center - 4.0 * level;
    let q = -4.0 * dot(line.at.xz, line.along.xz);
    let derivative = Curve(line, vec4f(2.0, 0.0, p, q), reach);
    let bend = min(sqrt(max(-p / 6.0, 0.0)), end);
    let first = critical(derivative, -end, -bend);
    let second = critical(derivative, -bend, bend);
    let third = critical(derivative, bend, end);
    let surface = Curve(line, vec4f(0.0), -1.0);
    return vec4f(
        root_between(surface, -end, first, ROOT_STEPS, ROOT_ACCURACY),
        root_between(surface, first, second, ROOT_STEPS, ROOT_ACCURACY),
        root_between(surface, second, third, ROOT_STEPS, ROOT_ACCURACY),
        root_between(surface, third, end, ROOT_STEPS, ROOT_ACCURACY),
    );
}

// The roots ahead of a line that starts on the torus, but for that one.
fn onward_roots(line: Line) -> vec4f {
    let o = line.at;
    let d = line.along;
    let from_axis = length(o.xz);
    let approach = dot(o, d);
    let outward = dot(o.xz, d.xz);
    let level = dot(d.xz, d.xz);
    // The quartic over s: s^3 + a s^2 + b s + c, where |o|^2 + 1 - minor^2 = 2 from_axis on the torus.
    let a = 4.0 * approach;
    let b = 4.0 * (approach * approach + from_axis - level);
    let rise = 8.0 * ((from_axis - 1.0) * outward + from_axis * o.y * d.y);
    // A ray that starts outside rises at first, one that starts inside falls, and comes out a little ahead at least: of a
    // grazing one, this may be rounding alone, and a rise at the start would lose the root where it comes out.
    let start = excess(line, 0.0).value;
    let falling = min(rise, -LEAST_EXIT * (max(b, 0.0) + LEAST_EXIT));
    let c = select(select(rise, max(rise, 0.0), start > 0.0), falling, start < 0.0);
    // Near the start the cubic is the more accurate, far from it the surface.
    let onward = Curve(line, vec4f(1.0, a, b, c), line.minor);
    let end = 2.02 * (1.0 + line.minor);
    let bent = bends(a, b, end);
    return vec4f(
        root_between(onward, 0.0, bent.x, ROOT_STEPS, ROOT_ACCURACY),
        root_between(onward, bent.x, bent.y, ROOT_STEPS, ROOT_ACCURACY),
        root_between(onward, bent.y, end, ROOT_STEPS, ROOT_ACCURACY),
        NO_ROOT,
    );
}

// Where s^3 + a s^2 + b s + c bends, within [0, end], in order; both 0 where it does not.
fn bends(a: f32, b: f32, end: f32) -> vec2f {
    let discriminant = a * a - 3.0 * b;
    if !(discriminant > 0.0) {
        return vec2f(0.0);
    }
    let root = sqrt(discriminant);
    let q = select(root - a, -(a + root), a >= 0.0);
    let one = q / 3.0;
    let other = select(b / select(q, TINY, q == 0.0), 0.0, q == 0.0);
    return clamp(vec2f(min(one, other), max(one, other)), vec2f(0.0), vec2f(end));
}

fn critical(curve: Curve, low: f32, high: f32) -> f32 {
    let place = root_between(curve, low, high, CRITICAL_STEPS, CRITICAL_ACCURACY);
    return select(place, high, place == NO_ROOT);
}

// The root of a function that is monotone between two places; NO_ROOT without a change of sign.
fn root_between(curve: Curve, from_place: f32, to_place: f32, steps: u32, accuracy: f32) -> f32 {
    var low = from_place;
    var high = to_place;
    let is_below = value_at(curve, low).value < 0.0;
    if is_below == (value_at(curve, high).value < 0.0) {
        return NO_ROOT;
    }
    var s = 0.5 * (low + high);
    for (var step = 0u; step < steps; step++) {
        let at = value_at(curve, s);
        let stays = (at.value < 0.0) == is_below;
        low = select(low, s, stays);
        high = select(s, high, stays);
        let change = at.value / select(at.slope, TINY, abs(at.slope) < TINY);
        let newton = s - change;
        if abs(change) <= accuracy {
            return newton;
        }
        s = select(0.5 * (low + high), newton, newton > low && newton < high);
    }
    return s;
}

fn value_at(curve: Curve, s: f32) -> Value {
    if s * s <= curve.near {
        let c = curve.polynomial;
        return Value(((c.x * s + c.y) * s + c.z) * s + c.w, (3.0 * c.x * s + 2.0 * c.y) * s + c.z);
    }
    return excess(curve.line, s);
}

// The squared distance to the ring less that of the surface, and its slope.
fn excess(line: Line, s: f32) -> Value {
    let p = line.at + line.along * s;
    let from_axis = length(p.xz);
    let from_ring = from_axis - 1.0;
    let outward = dot(p.xz, line.along.xz) / max(from_axis, TINY);
    return Value(
        from_ring * from_ring + p.y * p.y - line.minor * line.minor,
        2.0 * (from_ring * outward + p.y * line.along.y),
    );
}

struct TorusPoint {
    at: vec3f,
    normal: vec3f,
    // Sizes of the numbers that `at` was rounded from.
    roundings: vec3f,
}

// A point near the torus moved onto it.
fn torus_point(near: vec3f, minor: f32) -> TorusPoint {
    let ring = unit_or(vec3f(near.x, 0.0, near.z), vec3f(1.0, 0.0, 0.0));
    let normal = unit_or(near - ring, ring);
    let tube = normal * minor;
    return TorusPoint(ring + tube, normal, (abs(ring) + abs(tube)) * 2.0);
}
