// What: from a hit to the surface there: position with its error bound, normals, where rays may start.
// Reads: instances, triangles, normals. Writes: nothing.
// Twin: engine/src/trace/cpu/surface.rs and engine/src/geom/offset.rs.
#define_import_path orrery::surface

#import orrery::types::{InstanceRow, KIND_CUBOID, KIND_ELLIPSOID, KIND_MESH, KIND_PLANE, KIND_SPHERE, NONE}
#import orrery::scene::{instances, normals, triangles}
#import orrery::affine::{map_abs_affine, map_abs_linear, map_point, map_transposed, map_vector, unit_or}
#import orrery::traverse::Found
#ifdef CUBOIDS
#import orrery::cuboid::cuboid_normal
#endif

// gamma(n) = n*eps / (1 - n*eps), eps = 2^-24: a bound on n roundings (pbrt-v4, 6.8).
const GAMMA_TWO: f32 = 1.19209304e-7;
const GAMMA_THREE: f32 = 1.78813966e-7;
const GAMMA_FOUR: f32 = 2.38418636e-7;
const GAMMA_FIVE: f32 = 2.98023313e-7;
const GAMMA_SEVEN: f32 = 4.17232688e-7;

struct Surface {
    position: vec3f,
    // Bound on the position's rounding error, per axis.
    error: vec3f,
    // Unit, towards the incoming side.
    n_geom: vec3f,
    // Unit, on the side of n_geom.
    n_shade: vec3f,
    material: u32,
    id: u32,
    prim: u32,
}

// Before the normals are made unit and turned to the viewer.
struct Point {
    position: vec3f,
    error: vec3f,
    normal: vec3f,
    shading: vec3f,
}

// Positions come from the primitive, never from origin + t * dir (ACCURACY row 6).
fn resolve(found: Found, origin: vec3f, dir: vec3f) -> Surface {
    let kind = instances[found.row].kind;
    let near = origin + dir * found.key.t;
    var at = Point(near, vec3f(0.0), -dir, -dir);
#ifdef MESHES
    if kind == KIND_MESH {
        at = mesh_point(found);
    }
#endif
#ifdef SPHERES
    if kind == KIND_SPHERE {
        at = sphere_point(instances[found.row].local_from_world[0], near);
    }
    if kind == KIND_ELLIPSOID {
        let unit = unit_or(local_near(found, origin, dir), vec3f(0.0, 1.0, 0.0));
        at = affine_point(found.row, unit, unit);
    }
#endif
#ifdef PLANES
    if kind == KIND_PLANE {
        at = plane_point(instances[found.row].local_from_world[0], near);
    }
#endif
#ifdef CUBOIDS
    if kind == KIND_CUBOID {
        let normal = cuboid_normal(found.key.prim);
        let inside = clamp(local_near(found, origin, dir), vec3f(-1.0), vec3f(1.0));
        at = affine_point(found.row, select(normal, inside, normal == vec3f(0.0)), normal);
    }
#endif
    // A triangle too thin for a normal looks straight back.
    let normal = unit_or(at.normal, -unit_or(dir, vec3f(0.0, 0.0, 1.0)));
    let n_geom = select(normal, -normal, dot(normal, dir) > 0.0);
    var n_shade = n_geom;
#ifdef SMOOTH_NORMALS
    let shading = unit_or(at.shading, n_geom);
    n_shade = select(shading, -shading, dot(shading, n_geom) < 0.0);
#endif
    return Surface(at.position, at.error, n_geom, n_shade, instances[found.row].material, found.key.id, found.key.prim);
}

// Where a ray along `dir` starts: moved along the normal by the error's extent there (pbrt-v4, 6.8.6).
fn origin_towards(surface: Surface, dir: vec3f) -> vec3f {
    let reach = dot(abs(surface.n_geom), surface.error + abs(surface.position) * GAMMA_TWO);
    return surface.position + surface.n_geom * select(-reach, reach, dot(surface.n_geom, dir) >= 0.0);
}

// What a local point errs by on the way to render space and back.
fn affine_error(row: u32, local: vec3f, local_error: vec3f, world: vec3f) -> vec3f {
    let world_from_local = instances[row].world_from_local;
    let forward = map_abs_linear(world_from_local, local_error * (1.0 + GAMMA_THREE))
        + map_abs_affine(world_from_local, abs(local)) * GAMMA_FOUR;
    let back = map_abs_affine(instances[row].local_from_world, abs(world)) * GAMMA_FOUR;
    return forward + map_abs_linear(world_from_local, back);
}

#ifdef MESHES
fn mesh_point(found: Found) -> Point {
    let triangle = triangles[found.triangle];
    let u = found.uv.x;
    let v = found.uv.y;
    let w = 1.0 - u - v;
    let local = triangle.a * w + triangle.b * u + triangle.c * v;
    let local_error = (abs(triangle.a) * abs(w) + abs(triangle.b) * u + abs(triangle.c) * v) * GAMMA_SEVEN;
    let position = map_point(instances[found.row].world_from_local, local);
    let error = affine_error(found.row, local, local_error, position);
    let local_from_world = instances[found.row].local_from_world;
    let normal = map_transposed(local_from_world, cross(triangle.b - triangle.a, triangle.c - triangle.a));
    var shading = normal;
#ifdef SMOOTH_NORMALS
    if triangle.normals != NONE {
        let mixed = normals[triangle.normals].normal * w + normals[triangle.normals + 1u].normal * u
            + normals[triangle.normals + 2u].normal * v;
        shading = map_transposed(local_from_world, mixed);
    }
#endif
    return Point(position, error, normal, shading);
}
#endif

#ifdef SPHERES
fn sphere_point(sphere: vec4f, near: vec3f) -> Point {
    let normal = unit_or(near - sphere.xyz, vec3f(0.0, 1.0, 0.0));
    let error = (abs(sphere.xyz) + abs(normal) * sphere.w) * GAMMA_FIVE;
    return Point(sphere.xyz + normal * sphere.w, error, normal, normal);
}
#endif

#ifdef PLANES
fn plane_point(plane: vec4f, near: vec3f) -> Point {
    let position = near - plane.xyz * (dot(plane.xyz, near) - plane.w);
    let error = (abs(position) + abs(plane.xyz) * abs(plane.w)) * GAMMA_FIVE;
    return Point(position, error, plane.xyz, plane.xyz);
}
#endif

// The hit in local space, roughly.
fn local_near(found: Found, origin: vec3f, dir: vec3f) -> vec3f {
    let rows = instances[found.row].local_from_world;
    return map_point(rows, origin) + map_vector(rows, dir) * found.key.t;
}

// A point that lies exactly on the unit sphere or box.
fn affine_point(row: u32, local: vec3f, local_normal: vec3f) -> Point {
    let position = map_point(instances[row].world_from_local, local);
    let error = affine_error(row, local, abs(local) * GAMMA_FIVE, position);
    let normal = map_transposed(instances[row].local_from_world, local_normal);
    return Point(position, error, normal, normal);
}
