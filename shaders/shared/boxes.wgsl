// What: boxes, their growth and their cost.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/aabb.rs.
#define_import_path orrery::boxes

// The largest f32.
const MOST: f32 = 3.4028235e38;

struct Bounds {
    min: vec3f,
    max: vec3f,
}

// Holds nothing.
fn no_bounds() -> Bounds {
    return Bounds(vec3f(MOST), vec3f(-MOST));
}

fn take_in(bounds: Bounds, p: vec3f) -> Bounds {
    return Bounds(min(bounds.min, p), max(bounds.max, p));
}

fn is_empty(bounds: Bounds) -> bool {
    return any(bounds.min > bounds.max);
}

// Half the surface; 0 when empty.
fn half_area(bounds: Bounds) -> f32 {
    if is_empty(bounds) {
        return 0.0;
    }
    let size = bounds.max - bounds.min;
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Every face moves outward by the larger of one ulp and 1e-20 (Ize 2013; the constant serves faces at zero).
fn grown(bounds: Bounds) -> Bounds {
    return Bounds(-upward(-bounds.min), upward(bounds.max));
}

// The next number up is the next pattern of bits. Below the normal numbers, which a device may flush, and
// at zero the constant is the larger step.
fn upward(v: vec3f) -> vec3f {
    let bits = bitcast<vec3u>(v);
    let step = select(vec3u(0xffffffffu), vec3u(1u), v > vec3f(0.0));
    let is_normal = (bits & vec3u(0x7fffffffu)) >= vec3u(0x00800000u);
    let next = bitcast<vec3f>(bits + select(vec3u(0u), step, is_normal));
    return max(next, v + vec3f(1e-20));
}
