// What: the ray-sphere test that stays accurate for far and for small spheres.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/sphere.rs.
#define_import_path orrery::sphere

struct SphereRoots {
    hits: bool,
    near: f32,
    far: f32,
}

// Haines, Günther, Akenine-Möller, Ray Tracing Gems (2019), ch. 7: discriminant from the perpendicular
// remainder, roots by the stable quadratic. A ray that starts on the sphere has its other root at 2b/a.
fn hit_sphere(from_center: vec3f, dir: vec3f, radius: f32, starts_on: bool) -> SphereRoots {
    let a = dot(dir, dir);
    let b = -dot(from_center, dir);
    if starts_on {
        let other = 2.0 * b / a;
        return SphereRoots(true, other, other);
    }
    let remainder = from_center + dir * (b / a);
    let discriminant = radius * radius - dot(remainder, remainder);
    if !(discriminant >= 0.0) {
        return SphereRoots(false, 0.0, 0.0);
    }
    let distance = length(from_center);
    let c = (distance - radius) * (distance + radius);
    let root = sqrt(discriminant * a);
    let q = select(b - root, b + root, b >= 0.0);
    if q == 0.0 {
        return SphereRoots(false, 0.0, 0.0);
    }
    let first = c / q;
    let second = q / a;
    return SphereRoots(true, select(second, first, b >= 0.0), select(first, second, b >= 0.0));
}
