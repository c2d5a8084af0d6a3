// What: from a hit to the surface there: position with its error bound, normals, where rays may start.
// Reads: instances, triangles, vertices (normals alone). Writes: nothing.
// Twin: engine/src/trace/cpu/surface.rs and engine/src/geom/offset.rs.
#define_import_path orrery::surface

#import orrery::types::{InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH, KIND_PLANE, KIND_SPHERE, KIND_TORUS, NONE}
#import orrery::scene::{instances, triangles, vertices}
#import orrery::affine::{map_abs_linear, map_point, map_transposed, map_translation, map_vector, unit_or}
#import orrery::traverse::Found
#ifdef SPHERES
#import orrery::sphere::{project_sphere, sphere_frame}
#endif
#ifdef CUBOIDS
#import orrery::cuboid::cuboid_normal
#endif
#ifdef CONES
#import orrery::cone::cone_point
#endif
#ifdef TORI
#import orrery::torus::torus_point
#endif

// gamma(n) = n*eps / (1 - n*eps), eps = 2^-24: a bound on n roundings (pbrt-v4, 6.8).
const GAMMA_ONE: f32 = 5.96046483e-8;
const GAMMA_TWO: f32 = 1.19209304e-7;
const GAMMA_THREE: f32 = 1.78813966e-7;
const GAMMA_FOUR: f32 = 2.38418636e-7;
const GAMMA_FIVE: f32 = 2.98023313e-7;

#ifdef FIXED_OFFSETS
// engine/src/frame/kernels.rs says what it is for.
const FIXED_OFFSET: f32 = 1e-4;
#endif

struct Surface {
    position: vec3f,
    // Bound on the position's rounding error, per axis.
    error: vec3f,
    // Unit, towards the incoming side.
    n_geom: vec3f,
    // Unit, on the side of n_geom.
    n_shade: vec3f,
    material: u32,
    // Instance row and primitive: what rays from here must not meet.
    row: u32,
    prim: u32,
}

// Before the normals are made unit and turned to the viewer.
struct Point {
    position: vec3f,
    error: vec3f,
    normal: vec3f,
    shading: vec3f,
}

// Positions are moved onto the primitive, never left at origin + t * dir (pbrt-v4, 6.8).
fn resolve(found: Found, origin: vec3f, dir: vec3f) -> Surface {
    let kind = instances[found.row].kind;
    let near = origin + dir * found.key.t;
    var at = Point(near, vec3f(0.0), -dir, -dir);
#ifdef MESHES
    if kind == KIND_MESH {
        at = mesh_point(found, local_near(found, origin, dir));
    }
#endif
#ifdef SPHERES
    if kind == KIND_SPHERE {
        at = sphere_point(found.row, near);
    }
    if kind == KIND_ELLIPSOID {
        let unit = unit_or(local_near(found, origin, dir), vec3f(0.0, 1.0, 0.0));
        at = affine_point(found.row, unit, unit, abs(unit));
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
        let local = select(normal, inside, normal == vec3f(0.0));
        at = affine_point(found.row, local, normal, abs(local));
    }
#endif
#ifdef DISCS
    if kind == KIND_DISC {
        let local = local_near(found, origin, dir) * vec3f(1.0, 0.0, 1.0);
        at = affine_point(found.row, local, vec3f(0.0, 1.0, 0.0), abs(local));
    }
#endif
#ifdef CONES
    if kind == KIND_CONE {
        let local = cone_point(local_near(found, origin, dir), instances[found.row].parameter, found.key.prim);
        at = affine_point(found.row, local.at, local.normal, local.roundings);
    }
#endif
#ifdef TORI
    if kind == KIND_TORUS {
        let local = torus_point(local_near(found, origin, dir), instances[found.row].parameter);
        at = affine_point(found.row, local.at, local.normal, local.roundings);
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
    return Surface(at.position, at.error, n_geom, n_shade, instances[found.row].material, found.row, found.key.prim);
}

// Where a ray along `dir` starts: moved along the normal by the error's extent there (pbrt-v4, 6.8.6).
fn origin_towards(surface: Surface, dir: vec3f) -> vec3f {
#ifdef FIXED_OFFSETS
    let reach = FIXED_OFFSET;
#else
    let reach = dot(abs(surface.n_geom), surface.error + abs(surface.position) * GAMMA_ONE);
#endif
    return surface.position + surface.n_geom * select(-reach, reach, dot(surface.n_geom, dir) >= 0.0);
}

// The instance row that a ray from here must not meet.
fn excluded_row(surface: Surface) -> u32 {
#ifdef FIXED_OFFSETS
    return NONE;
#else
    return surface.row;
#endif
}

// What a local point errs by on the way to render space and back: see engine/src/geom/offset.rs.
fn affine_error(row: u32, local: vec3f, local_error: vec3f, world: vec3f) -> vec3f {
    let world_from_local = instances[row].world_from_local;
    let local_from_world = instances[row].local_from_world;
    let forward = map_abs_linear(world_from_local, local_error) + one_way_error(world_from_local, local, world);
    let back = one_way_error(local_from_world, world, local);
    return forward + map_abs_linear(world_from_local, back);
}

fn one_way_error(rows: array<vec4f, 3>, from_point: vec3f, to_point: vec3f) -> vec3f {
    return map_abs_linear(rows, abs(from_point)) * GAMMA_FOUR
        + (abs(map_translation(rows)) + abs(to_point)) * GAMMA_ONE;
}

#ifdef MESHES
// The ray's point moved onto the triangle's plane. Along the plane it errs by the ray's error, which
// shrinks towards the eye as pixels do; weights of corners would err by the triangle's size instead.
fn mesh_point(found: Found, near: vec3f) -> Point {
    let a = triangles[found.triangle].a;
    let ab = triangles[found.triangle].b - a;
    let ac = triangles[found.triangle].c - a;
    let from_corner = near - a;
    let face = cross(ab, ac);
    let face_normal = unit_or(face, vec3f(0.0));
    let local = near - face_normal * dot(face_normal, from_corner);
    // The face's own rounding tilts it, and a sliver's most: by the error of the cross product over its length.
    let tilt = abs_cross(ab, ac) * (GAMMA_THREE / max(dot(face, face_normal), 1.17549435e-38));
    let local_error = abs(from_corner) * GAMMA_FIVE + abs(local) * GAMMA_TWO + vec3f(dot(abs(from_corner), tilt));
    let position = map_point(instances[found.row].world_from_local, local);
    let error = affine_error(found.row, local, local_error, position);
    let local_from_world = instances[found.row].local_from_world;
    let normal = map_transposed(local_from_world, face_normal);
    var shading = normal;
#ifdef SMOOTH_NORMALS
    let first_normal = instances[found.row].first_normal;
    if first_normal != NONE {
        let at = triangles[found.triangle].corners + first_normal;
        let u = found.uv.x;
        let v = found.uv.y;
        let w = 1.0 - u - v;
        let mixed = vertices[at.x].vector * w + vertices[at.y].vector * u + vertices[at.z].vector * v;
        shading = map_transposed(local_from_world, mixed);
    }
#endif
    return Point(position, error, normal, shading);
}
#endif

#ifdef MESHES
// What the products of a cross product add up to without cancelling.
fn abs_cross(a: vec3f, b: vec3f) -> vec3f {
    return abs(a.yzx) * abs(b.zxy) + abs(a.zxy) * abs(b.yzx);
}
#endif

#ifdef SPHERES
fn sphere_point(row: u32, near: vec3f) -> Point {
    let frame = sphere_frame(instances[row].local_from_world[0], instances[row].local_from_world[1]);
    let at = project_sphere(frame, near);
    return Point(at.position, at.error, at.normal, at.normal);
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

// A point of a solid in its own space, moved onto it: exactly, but for the roundings of that.
fn affine_point(row: u32, local: vec3f, local_normal: vec3f, roundings: vec3f) -> Point {
    let position = map_point(instances[row].world_from_local, local);
    let error = affine_error(row, local, roundings * GAMMA_FIVE, position);
    let normal = map_transposed(instances[row].local_from_world, local_normal);
    return Point(position, error, normal, normal);
}
