// What: what a ray through the root of a refitted tree costs, by the surface area heuristic; a workgroup a tree.
// Reads: jobs, nodes, partials of refit.wgsl. Writes: costs.
// Twin: Tree::cost in engine/src/bvh.
#import orrery::stage::{group_index, stage}
#import orrery::jobs::jobs
#import orrery::boxes::half_area
#import orrery::fit::node_bounds

@group(0) @binding(2) var<storage, read> partials: array<f32>;
@group(0) @binding(4) var<storage, read_write> costs: array<f32>;

var<workgroup> sums: array<f32, 256>;

@compute @workgroup_size(256)
fn cost(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = group_index(group, groups);
    let job = stage.first + min(at, stage.count - 1u);
    var sum = 0.0;
    for (var index = lane; index < jobs[job].count; index += 256u) {
        sum += partials[jobs[job].partial + index];
    }
    sums[lane] = sum;
    workgroupBarrier();
    for (var half = 128u; half > 0u; half /= 2u) {
        if lane < half {
            sums[lane] += sums[lane + half];
        }
        workgroupBarrier();
    }
    if lane == 0u && at < stage.count {
        // A root without area (all in one line) costs what its parts weigh: nothing.
        costs[at] = sums[0] / max(half_area(node_bounds(jobs[job].root)), 1e-30);
    }
}
