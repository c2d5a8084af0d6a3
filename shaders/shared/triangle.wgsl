// What: the watertight ray-triangle test (Woop, Benthin, Wald, JCGT 2:1, 2013), without f64.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/triangle.rs, and engine/src/geom/moller_trumbore.rs.
#define_import_path orrery::triangle

#ifdef UNSHARED_EDGES
// The direction, which is all this test needs of a ray beside its origin.
struct Shear {
    dir: vec3f,
}
#else
// The shear of one ray direction; shared by all its triangles.
struct Shear {
    // Longest axis of the direction.
    axis: u32,
    shear: vec3f,
}
#endif

struct TriangleHit {
    hits: bool,
    t: f32,
    u: f32,
    v: f32,
}

#ifdef UNSHARED_EDGES
fn make_shear(dir: vec3f) -> Shear {
    return Shear(dir);
}

// Möller and Trumbore (1997), as printed: neighbours round their shared edge differently, so it leaks.
fn hit_triangle(ray: Shear, origin: vec3f, corner_a: vec3f, corner_b: vec3f, corner_c: vec3f) -> TriangleHit {
    let miss = TriangleHit(false, 0.0, 0.0, 0.0);
    let ab = corner_b - corner_a;
    let ac = corner_c - corner_a;
    let p = cross(ray.dir, ac);
    let det = dot(ab, p);
    if det == 0.0 {
        return miss;
    }
    let inverse = 1.0 / det;
    let from_corner = origin - corner_a;
    let u = dot(from_corner, p) * inverse;
    if u < 0.0 || u > 1.0 {
        return miss;
    }
    let q = cross(from_corner, ab);
    let v = dot(ray.dir, q) * inverse;
    if v < 0.0 || u + v > 1.0 {
        return miss;
    }
    return TriangleHit(true, dot(ac, q) * inverse, u, v);
}
#else
fn make_shear(dir: vec3f) -> Shear {
    let size = abs(dir);
    var axis = 2u;
    if size.x > size.y && size.x > size.z {
        axis = 0u;
    } else if size.y > size.z {
        axis = 1u;
    }
    let d = permute(dir, axis);
    return Shear(axis, vec3f(d.x / d.z, d.y / d.z, 1.0 / d.z));
}

// The longest axis last, in the cyclic order. A direction that goes down it sees triangles turned round, and both sides of them
// are hit alike.
fn permute(p: vec3f, axis: u32) -> vec3f {
    return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u);
}

// Whether all three lie on one side of the ray.
fn apart(p: vec3f) -> bool {
    return min(p.x, min(p.y, p.z)) > 0.0 || max(p.x, max(p.y, p.z)) < 0.0;
}

// Each edge is decided by comparing two rounded products of values that both its triangles compute from
// the same bits; a difference of products might be fused, differently on the two sides. Zero is inside.
fn hit_triangle(ray: Shear, origin: vec3f, corner_a: vec3f, corner_b: vec3f, corner_c: vec3f) -> TriangleHit {
    let a = permute(corner_a - origin, ray.axis);
    let b = permute(corner_b - origin, ray.axis);
    let c = permute(corner_c - origin, ray.axis);
    let x = fma(vec3f(-ray.shear.x), vec3f(a.z, b.z, c.z), vec3f(a.x, b.x, c.x));
    let y = fma(vec3f(-ray.shear.y), vec3f(a.z, b.z, c.z), vec3f(a.y, b.y, c.y));
    let plus = x.zxy * y.yzx;
    let minus = y.zxy * x.yzx;
    let front = all(plus >= minus);
    if !front && !all(plus <= minus) {
        return TriangleHit(false, 0.0, 0.0, 0.0);
    }
    // Of a triangle without area the signs above are noise: they hold all along its line. Asked of those few that passed; see the twin.
    if apart(x) || apart(y) {
        return TriangleHit(false, 0.0, 0.0, 0.0);
    }
    let difference = plus - minus;
    let weights = select(min(difference, vec3f(0.0)), max(difference, vec3f(0.0)), front);
    let det = weights.x + weights.y + weights.z;
    if det == 0.0 {
        return TriangleHit(false, 0.0, 0.0, 0.0);
    }
    let t = dot(weights, ray.shear.z * vec3f(a.z, b.z, c.z)) / det;
    return TriangleHit(true, t, clamp(weights.y / det, 0.0, 1.0), clamp(weights.z / det, 0.0, 1.0));
}
#endif
