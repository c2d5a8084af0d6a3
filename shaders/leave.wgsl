// What: whether rays come off the surfaces they start on: one invocation a pair of rays.
// Reads: groups 0 and 1, rays. Writes: hits.
// Twin: leave in engine/src/trace/cpu/mod.rs; the frame is engine/src/geom/basis.rs.
#import orrery::types::{HitRow, NONE, RayRow}
#import orrery::scene::{instances, pass_row}
#import orrery::surface::{excluded_row, origin_towards, resolve}
#import orrery::traverse::{Found, Probe, UNTIL_NEAREST, key_after, key_before, trace}

@group(2) @binding(0) var<storage, read> rays: array<RayRow>;
@group(2) @binding(1) var<storage, read_write> hits: array<HitRow>;

// The first ray of a pair arrives; the second leaves from there, in the frame of the surface.
@compute @workgroup_size(64)
fn leave(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= pass_row.count {
        return;
    }
    let first = rays[2u * at.x];
    let arriving = Probe(first.origin, first.dir, key_after(first.t_min), key_before(first.t_max), NONE, NONE, UNTIL_NEAREST);
    let found = trace(arriving);
    hits[2u * at.x] = hit_row(found);
    hits[2u * at.x + 1u] = HitRow(0.0, 0.0, 0.0, NONE, NONE, array<u32, 3>());
    if found.row == NONE {
        return;
    }
    let second = rays[2u * at.x + 1u];
    let surface = resolve(found, first.origin, first.dir);
    let dir = out_of_frame(surface.n_geom, second.dir);
    let leaving = Probe(
        origin_towards(surface, dir), dir, key_after(second.t_min), key_before(second.t_max),
        excluded_row(surface), surface.prim, UNTIL_NEAREST,
    );
    hits[2u * at.x + 1u] = hit_row(trace(leaving));
}

fn hit_row(found: Found) -> HitRow {
    var hit = HitRow(found.key.t, found.uv.x, found.uv.y, NONE, NONE, array<u32, 3>());
    if found.row != NONE {
        hit.instance = found.key.id;
        hit.prim = found.key.prim;
    }
    return hit;
}

// Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 6:1, 2017).
fn out_of_frame(n: vec3f, v: vec3f) -> vec3f {
    let side = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    let tangent = vec3f(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
    let bitangent = vec3f(b, side + n.y * n.y * a, -n.y);
    return tangent * v.x + bitangent * v.y + n * v.z;
}
