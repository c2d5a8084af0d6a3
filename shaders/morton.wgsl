// What: where each box is on a curve through space that keeps neighbours together (Morton 1966), 10 bits an axis.
// Reads: boxes, build. Writes: pairs of code and row; build: the root's level.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::types::{BoxRow, NONE}
#import orrery::stage::{group_index, stage}
#import orrery::build::{build, centre, is_vacant, unordered}

@group(0) @binding(1) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(3) var<storage, read_write> pairs: array<vec2u>;

@compute @workgroup_size(256)
fn morton(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = group_index(group, groups) * 256u + lane;
    if index == 0u {
        atomicStore(&build.level_nodes[0], 1u);
    }
    if index >= stage.count {
        return;
    }
    let row = boxes[index];
    // Vacant rows come last.
    pairs[index] = vec2u(select(code(centre(row)), NONE, is_vacant(row)), index);
}

// All axes by the same measure, so that cells are cubes and a flat scene is not cut along its thin side.
fn code(c: vec3f) -> u32 {
    var low = vec3f(0.0);
    var size = 0.0;
    for (var axis = 0u; axis < 3u; axis++) {
        low[axis] = -unordered(atomicLoad(&build.least[axis]));
        size = max(size, unordered(atomicLoad(&build.greatest[axis])) - low[axis]);
    }
    let share = clamp((c - low) / max(size, 1e-30), vec3f(0.0), vec3f(1.0));
    let cell = min(vec3u(share * 1024.0), vec3u(1023u));
    return spread(cell.x) << 2u | spread(cell.y) << 1u | spread(cell.z);
}

// Two zeros behind each of ten bits (Karras 2012, "Thinking Parallel").
fn spread(x: u32) -> u32 {
    var v = (x * 0x00010001u) & 0xff0000ffu;
    v = (v * 0x00000101u) & 0x0f00f00fu;
    v = (v * 0x00000011u) & 0xc30c30c3u;
    return (v * 0x00000005u) & 0x49249249u;
}
