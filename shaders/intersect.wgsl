// What: answers to rays: one invocation a ray.
// Reads: groups 0 and 1, rays. Writes: hits.
// Twin: answer in engine/src/trace/cpu/mod.rs.
#import orrery::types::{HitRow, NONE, QUERY_ANY, RayRow}
#import orrery::scene::{instances, pass_row}
#import orrery::traverse::{Found, Probe, UNTIL_ANY, UNTIL_NEAREST, key_after, key_before, trace}
#ifdef MESHES
#import orrery::affine::{map_point, map_vector}
#import orrery::scene::triangles
#import orrery::types::KIND_MESH
#endif

@group(2) @binding(0) var<storage, read> rays: array<RayRow>;
@group(2) @binding(1) var<storage, read_write> hits: array<HitRow>;

@compute @workgroup_size(64)
fn intersect(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= pass_row.count {
        return;
    }
    let ray = rays[at.x];
    let any = pass_row.query == QUERY_ANY;
    let until = select(UNTIL_NEAREST, UNTIL_ANY, any);
    let probe = Probe(ray.origin, ray.dir, key_after(ray.t_min), key_before(ray.t_max), NONE, NONE, until);
    let found = trace(probe);
    let is_hit = found.row != NONE;
    var hit = HitRow(found.key.t, found.uv.x, found.uv.y, NONE, NONE, array<u32, 3>());
    if any {
        hit.instance = select(0u, 1u, is_hit);
    } else if is_hit {
        hit.t = refined_t(found, ray);
        hit.instance = found.key.id;
        hit.prim = found.key.prim;
    }
    hits[at.x] = hit;
}

// Square of the cosine below which a ray grazes a triangle: the plane's t is then the less exact of the two.
const GRAZES: f32 = 0.25;

// The distance to a triangle's plane from where the hit was found, added: one Newton step, as positions in pictures are moved
// onto their primitives.
fn refined_t(found: Found, ray: RayRow) -> f32 {
    let t = found.key.t;
#ifdef MESHES
    if instances[found.row].kind == KIND_MESH {
        let rows = instances[found.row].local_from_world;
        let dir = map_vector(rows, ray.dir);
        let a = triangles[found.triangle].a;
        let normal = cross(triangles[found.triangle].b - a, triangles[found.triangle].c - a);
        let height = dot(normal, a - map_point(rows, ray.origin + ray.dir * t));
        let along = dot(normal, dir);
        if along * along > GRAZES * dot(normal, normal) * dot(dir, dir) {
            return clamp(t + height / along, ray.t_min, ray.t_max);
        }
    }
#endif
    return t;
}
