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

// A point moved onto a sphere.
struct SpherePoint {
    position: vec3f,
    normal: vec3f,
    // How far the position may be off the surface, and a ray from there find it, per axis.
    error: vec3f,
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

// Along the normal there by the point's height above the sphere.
fn project_sphere(sphere: SphereFrame, near: vec3f) -> SpherePoint {
    let from_base = near - sphere.base;
    let from_center = from_base - sphere.center;
    let distance = max(length(from_center), 1.17549435e-38);
    let normal = from_center / distance;
    let span = distance + sphere.radius;
    // Twice gamma(6): the power's own roundings, here and when a ray comes back.
    let products = dot(abs(from_base), abs(from_center) + abs(sphere.center));
    let height_error = 7.1525596e-7 * products / span;
    let position = near - normal * (power_of(sphere, from_base, from_center) / span);
    return SpherePoint(position, normal, abs(from_base) * 1.19209304e-7 + abs(normal) * height_error);
}
