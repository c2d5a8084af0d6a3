// What: from a hit to the surface there: position with its error bound, normals, where rays may start.
// Reads: instances, triangles, vertices (normals alone). Writes: nothing.
// Twin: engine/src/trace/cpu/surface.rs and engine/src/geom/offset.rs.
#define_import_path orrery::surface

#import orrery::types::{InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH, KIND_PLANE, KIND_SPHERE, KIND_TORUS, NONE}
#import orrery::scene::{instances, materials, triangles, vertices}
#import orrery::affine::{map_abs_linear, map_point, map_transposed, map_vector, unit_or}
#import orrery::traverse::Found
#ifdef SPHERES
#import orrery::sphere::{sphere_frame, sphere_height}
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
const GAMMA_THREE: f32 = 1.78813966e-7;
const GAMMA_FIVE: f32 = 2.98023313e-7;
const GAMMA_SIX: f32 = 3.57627997e-7;
// Square of the sine of the flattest angle at which a step off a surface is one along the ray.
const FLATTEST: f32 = 0.015625;

#ifdef FIXED_OFFSETS
// engine/src/frame/kernels.rs says what it is for.
const FIXED_OFFSET: f32 = 1e-4;
#endif

struct Surface {
    position: vec3f,
    // Bound on how far the position is off the primitive, as rays find it.
    error: f32,
    // Unit, towards the incoming side.
    n_geom: vec3f,
    // Unit, on the side of n_geom.
    n_shade: vec3f,
    material: u32,
#ifdef TINTED
    // Linear RGB, in place of the material's.
    color: vec3f,
#endif
#ifdef FOOTPRINTS
    // Of the ray's cone here.
    width: f32,
#endif
#ifdef CURVED
    // From here to the curved surface that triangles stand for, if they do.
    lift: vec3f,
    is_curved: bool,
#endif
    // Instance row and primitive: what rays from here must not meet.
    row: u32,
    prim: u32,
}

// How a point lies to the primitive it is near, in render space.
struct Above {
    // Along the normal.
    height: f32,
    // What the height errs by, here and where a ray comes back.
    error: f32,
    // Of the face, outward and unit; zero where a triangle is too thin for one.
    normal: vec3f,
    // Of any length.
    shading: vec3f,
}

// Positions are moved onto the primitive (pbrt-v4, 6.8), and along the ray as far as that is short: there they
// stay on the ray's line, and what t lacked is in them. Heights alone are taken to local spaces.
fn resolve(found: Found, origin: vec3f, dir: vec3f) -> Surface {
    let kind = instances[found.row].kind;
    let near = origin + dir * found.key.t;
    let local = map_point(instances[found.row].local_from_world, near);
    var above = Above(0.0, 0.0, -dir, -dir);
#ifdef MESHES
    if kind == KIND_MESH {
        above = above_triangle(found, near, local);
    }
#endif
#ifdef SPHERES
    if kind == KIND_SPHERE {
        let rows = instances[found.row].local_from_world;
        let over = sphere_height(sphere_frame(rows[0], rows[1]), near);
        above = Above(over.height, over.error, over.normal, over.normal);
    }
    if kind == KIND_ELLIPSOID {
        let unit = unit_or(local, vec3f(0.0, 1.0, 0.0));
        above = above_solid(found.row, near, local, unit, unit, abs(unit));
    }
#endif
#ifdef PLANES
    if kind == KIND_PLANE {
        let plane = instances[found.row].local_from_world[0];
        let error = dot(abs(plane.xyz), abs(near)) * GAMMA_SIX;
        above = Above(dot(plane.xyz, near) - plane.w, error, plane.xyz, plane.xyz);
    }
#endif
#ifdef CUBOIDS
    if kind == KIND_CUBOID {
        let normal = cuboid_normal(found.key.prim);
        let at = select(normal, clamp(local, vec3f(-1.0), vec3f(1.0)), normal == vec3f(0.0));
        above = above_solid(found.row, near, local, at, normal, abs(at));
    }
#endif
#ifdef DISCS
    if kind == KIND_DISC {
        let at = local * vec3f(1.0, 0.0, 1.0);
        above = above_solid(found.row, near, local, at, vec3f(0.0, 1.0, 0.0), abs(at));
    }
#endif
#ifdef CONES
    if kind == KIND_CONE {
        let point = cone_point(local, instances[found.row].parameter, found.key.prim);
        above = above_solid(found.row, near, local, point.at, point.normal, point.roundings);
    }
#endif
#ifdef TORI
    if kind == KIND_TORUS {
        let point = torus_point(local, instances[found.row].parameter);
        above = above_solid(found.row, near, local, point.at, point.normal, point.roundings);
    }
#endif
    let position = near - step_off(above.height, above.normal, dir);
    // A triangle too thin for a normal looks straight back.
    let normal = unit_or(above.normal, -unit_or(dir, vec3f(0.0, 0.0, 1.0)));
    let n_geom = select(normal, -normal, dot(normal, dir) > 0.0);
    var n_shade = n_geom;
#ifdef SMOOTH_NORMALS
    let shading = unit_or(above.shading, n_geom);
    n_shade = select(shading, -shading, dot(shading, n_geom) < 0.0);
#endif
    var surface: Surface;
    surface.position = position;
    surface.error = above.error;
    surface.n_geom = n_geom;
    surface.n_shade = n_shade;
    surface.material = instances[found.row].material;
#ifdef TINTED
    surface.color = materials[surface.material].color;
#endif
#ifdef CURVED
    surface.is_curved = kind == KIND_MESH && instances[found.row].parameter != 0.0 && instances[found.row].first_normal != NONE;
    if surface.is_curved {
        surface.lift = lift(found, n_geom);
    }
#endif
    surface.row = found.row;
    surface.prim = found.key.prim;
    return surface;
}

#ifdef CURVED
// From a point of a triangle to the surface that its vertices' normals tell of: the point moved onto the plane of each
// vertex that it is below, and the means of those.
fn lift(found: Found, n_geom: vec3f) -> vec3f {
    let a = triangles[found.triangle].a;
    let b = triangles[found.triangle].b;
    let c = triangles[found.triangle].c;
    let u = found.uv.x;
    let v = found.uv.y;
    let w = 1.0 - u - v;
    let at = a * w + b * u + c * v;
    let outward = map_transposed(instances[found.row].local_from_world, cross(b - a, c - a));
    let side = select(1.0, -1.0, dot(n_geom, outward) < 0.0);
    let on = triangles[found.triangle].corners + instances[found.row].first_normal;
    let above_a = lift_over(at - a, vertices[on.x].vector * side) * w;
    let above_b = lift_over(at - b, vertices[on.y].vector * side) * u;
    let above_c = lift_over(at - c, vertices[on.z].vector * side) * v;
    return map_vector(instances[found.row].world_from_local, above_a + above_b + above_c);
}

// What brings a point below the plane of a unit normal onto it.
fn lift_over(from_corner: vec3f, normal: vec3f) -> vec3f {
    return normal * -min(dot(from_corner, normal), 0.0);
}
#endif

// Where a ray along `dir` starts: off the surface by the error and the rounding of that very sum.
fn origin_towards(surface: Surface, dir: vec3f) -> vec3f {
    let outward = dot(surface.n_geom, dir) >= 0.0;
#ifdef FIXED_OFFSETS
    return surface.position + surface.n_geom * select(-FIXED_OFFSET, FIXED_OFFSET, outward);
#else
    let reach = surface.error + dot(abs(surface.n_geom), abs(surface.position)) * GAMMA_ONE;
    return surface.position + step_off(select(-reach, reach, outward), surface.n_geom, dir);
#endif
}

// A step that rises by `height` over the plane of a unit normal: see engine/src/geom/offset.rs.
fn step_off(height: f32, normal: vec3f, dir: vec3f) -> vec3f {
    let along = dot(normal, dir);
    let slide = height * along / max(along * along, dot(dir, dir) * FLATTEST);
    return dir * slide + normal * (height - slide * along);
}

// The instance row that a ray from here must not meet.
fn excluded_row(surface: Surface) -> u32 {
#ifdef FIXED_OFFSETS
    return NONE;
#else
    return surface.row;
#endif
}

// The height of a point over a plane of unit normal in a row's local space, brought to render space. Only what
// the map errs by along the normal counts, there and back.
fn above_local(row: u32, near: vec3f, local: vec3f, height: f32, error: f32, normal: vec3f) -> Above {
    let rows = instances[row].local_from_world;
    let gradient = map_transposed(rows, normal);
    let outward = unit_or(gradient, vec3f(0.0));
    let steepness = dot(outward, gradient);
    let scale = select(0.0, 1.0 / max(steepness, 1.17549435e-38), steepness > 0.0);
    let mapped = map_abs_linear(rows, abs(near)) * GAMMA_THREE + abs(local) * GAMMA_ONE;
    return Above(height * scale, (error + 2.0 * dot(abs(normal), mapped)) * scale, outward, outward);
}

// Over a solid's point in its own space, which is on the solid but for its roundings; the normal is of any length.
fn above_solid(row: u32, near: vec3f, local: vec3f, at: vec3f, any_normal: vec3f, roundings: vec3f) -> Above {
    let normal = unit_or(any_normal, vec3f(0.0, 1.0, 0.0));
    let error = dot(abs(normal), roundings) * GAMMA_FIVE;
    return above_local(row, near, local, dot(normal, local - at), error, normal);
}

#ifdef MESHES
fn above_triangle(found: Found, near: vec3f, local: vec3f) -> Above {
    let a = triangles[found.triangle].a;
    let ab = triangles[found.triangle].b - a;
    let ac = triangles[found.triangle].c - a;
    let from_corner = local - a;
    let face = cross(ab, ac);
    let normal = unit_or(face, vec3f(0.0));
    // The face's own rounding tilts it, and a sliver's most: by the error of the cross product over its length.
    let tilt = abs_cross(ab, ac) * (GAMMA_THREE / max(dot(face, normal), 1.17549435e-38));
    let spread = abs(from_corner) * 2.0 + abs(ab) + abs(ac);
    let error = dot(abs(normal), spread) * GAMMA_FIVE + 2.0 * dot(abs(from_corner), tilt);
    var above = above_local(found.row, near, local, dot(normal, from_corner), error, normal);
#ifdef SMOOTH_NORMALS
    let first_normal = instances[found.row].first_normal;
    if first_normal != NONE {
        let at = triangles[found.triangle].corners + first_normal;
        let u = found.uv.x;
        let v = found.uv.y;
        let w = 1.0 - u - v;
        let mixed = vertices[at.x].vector * w + vertices[at.y].vector * u + vertices[at.z].vector * v;
        above.shading = map_transposed(instances[found.row].local_from_world, mixed);
    }
#endif
    return above;
}

// What the products of a cross product add up to without cancelling.
fn abs_cross(a: vec3f, b: vec3f) -> vec3f {
    return abs(a.yzx) * abs(b.zxy) + abs(a.zxy) * abs(b.yzx);
}
#endif
