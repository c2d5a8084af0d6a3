// What: the box around the centres of all boxes, and how many boxes there are; an invocation a box.
// Reads: boxes. Writes: build, as whole numbers whose order is that of the f32, so that no answer depends on who came first.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::types::BoxRow
#import orrery::stage::{group_index, stage}
#import orrery::build::{build, centre, is_vacant, ordered}

@group(0) @binding(1) var<storage, read> boxes: array<BoxRow>;

var<workgroup> live: atomic<u32>;
var<workgroup> greatest: array<atomic<u32>, 3>;
// Of the negated centres.
var<workgroup> least: array<atomic<u32>, 3>;

@compute @workgroup_size(256)
fn span(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = group_index(group, groups) * 256u + lane;
    if index < stage.count {
        let row = boxes[index];
        if !is_vacant(row) {
            let c = centre(row);
            atomicAdd(&live, 1u);
            for (var axis = 0u; axis < 3u; axis++) {
                atomicMax(&greatest[axis], ordered(c[axis]));
                atomicMax(&least[axis], ordered(-c[axis]));
            }
        }
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&build.live, atomicLoad(&live));
    }
    if lane < 3u {
        atomicMax(&build.greatest[lane], atomicLoad(&greatest[lane]));
        atomicMax(&build.least[lane], atomicLoad(&least[lane]));
    }
}
