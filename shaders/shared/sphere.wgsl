// What: the ray-sphere test that stays accurate for far, for small and for huge spheres.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/sphere.rs, which says why.
#define_import_path orrery::sphere

// A sphere as rays see it whose origins are relative to the eye.
struct SphereFrame {
    // Relative to the eye: the eye itself, or the centre.
    base: vec3f,
    radius: f32,
    // Relative to the base.
    center: vec3f,
    // Of the base: its squared distance to the centre less the squared radius.
    power: f32,
}

struct SphereRoots {
    hits: bool,
    near: f32,
    far: f32,
}

// How a point lies to a sphere.
struct SphereHeight {
    // Outside it: how far, along the normal.
    height: f32,
    // What the height errs by, here and where a ray comes back.
    error: f32,
    // Outward, unit.
    normal: vec3f,
}

// The sphere of an instance's first two rows.
fn sphere_frame(base_radius: vec4f, center_power: vec4f) -> SphereFrame {
    return SphereFrame(base_radius.xyz, base_radius.w, center_power.xyz, center_power.w);
}

// The unit sphere about the origin.
fn unit_sphere() -> SphereFrame {
    return SphereFrame(vec3f(0.0), 1.0, vec3f(0.0), -1.0);
}

// The power of a point, relative to the base and to the centre.
fn power_of(sphere: SphereFrame, from_base: vec3f, from_center: vec3f) -> f32 {
    return dot(from_base, from_center - sphere.center) + sphere.power;
}

// A ray that starts on the sphere has no other root outside, and 2b/a inside.
fn hit_sphere(sphere: SphereFrame, origin: vec3f, dir: vec3f, starts_on: bool) -> SphereRoots {
    let from_base = origin - sphere.base;
    let from_center = from_base - sphere.center;
    let power = power_of(sphere, from_base, from_center);
    let a = dot(dir, dir);
    let b = -dot(from_center, dir);
    if starts_on {
        let other = 2.0 * b / a;
        return SphereRoots(power <= 0.0, other, other);
    }
    let squared = sphere.radius * sphere.radius;
    var discriminant = b * b - a * power;
    if b * b > a * squared {
        let remainder = fma(dir, vec3f(b / a), from_center);
        let along = dot(remainder, dir);
        discriminant = (squared - dot(remainder, remainder)) * a + along * along;
    }
    if !(discriminant >= 0.0) {
        return SphereRoots(false, 0.0, 0.0);
    }
    let root = sqrt(discriminant);
    let q = select(b - root, b + root, b >= 0.0);
    if q == 0.0 {
        return SphereRoots(false, 0.0, 0.0);
    }
    let first = power / q;
    let second = q / a;
    return SphereRoots(true, select(second, first, b >= 0.0), select(first, second, b >= 0.0));
}

// The height of a point near the sphere.
fn sphere_height(sphere: SphereFrame, near: vec3f) -> SphereHeight {
    let from_base = near - sphere.base;
    let from_center = from_base - sphere.center;
    let distance = max(length(from_center), 1.17549435e-38);
    let normal = from_center / distance;
    let span = distance + sphere.radius;
    // The twin's bound, doubled: what it takes from f64 is rounded here.
    let products = dot(abs(from_base), abs(from_center) + abs(sphere.center));
    let error = 1.4305119e-6 * products / span + 2.3841858e-7 * dot(abs(normal), abs(near));
    return SphereHeight(power_of(sphere, from_base, from_center) / span, error, normal);
}
