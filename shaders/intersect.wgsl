// What: answers to rays: one invocation a ray.
// Reads: groups 0 and 1, rays. Writes: hits.
// Twin: answer in engine/src/trace/cpu/mod.rs.
#import orrery::types::{HitRow, NONE, QUERY_ANY, RayRow}
#import orrery::scene::{instances, pass_row}
#import orrery::traverse::{Probe, key_after, key_before, trace}

@group(2) @binding(0) var<storage, read> rays: array<RayRow>;
@group(2) @binding(1) var<storage, read_write> hits: array<HitRow>;

@compute @workgroup_size(64)
fn intersect(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= pass_row.count {
        return;
    }
    let ray = rays[at.x];
    let any = pass_row.query == QUERY_ANY;
    let probe = Probe(ray.origin, ray.dir, key_after(ray.t_min), key_before(ray.t_max), NONE, NONE, any);
    let found = trace(probe);
    let is_hit = found.row != NONE;
    var hit = HitRow(found.key.t, found.uv.x, found.uv.y, NONE, NONE, array<u32, 3>());
    if any {
        hit.instance = select(0u, 1u, is_hit);
    } else if is_hit {
        hit.instance = found.key.id;
        hit.prim = found.key.prim;
    }
    hits[at.x] = hit;
}
