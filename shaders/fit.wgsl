// What: the boxes of one level of a tree over boxes; an invocation a child. Levels go from the deepest up.
// Reads: boxes, build, nodes of the level below. Writes: boxes of nodes.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::types::{BoxRow, CHILD_LEAF, CHILD_NONE, LEAF_FIRST_MASK}
#import orrery::stage::{group_index, stage}
#import orrery::build::build
#import orrery::boxes::{Bounds, grown, no_bounds}
#import orrery::fit::{GROUP_NODES, child_slot, node_bounds, put_bounds, write_bounds}

@group(0) @binding(1) var<storage, read> boxes: array<BoxRow>;

@compute @workgroup_size(128)
fn fit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let in_level = atomicLoad(&build.level_nodes[stage.level]);
    let done = min(group_index(group, groups) * GROUP_NODES, in_level);
    let count = min(in_level - done, GROUP_NODES);
    let first = stage.first + build.level_starts[stage.level] + done;
    var bounds = no_bounds();
    if lane / 4u < count {
        let child = child_slot(first + lane / 4u, lane % 4u);
        if child != CHILD_NONE {
            if (child & CHILD_LEAF) == 0u {
                bounds = node_bounds(stage.first + child);
            } else {
                let row = boxes[child & LEAF_FIRST_MASK];
                bounds = grown(Bounds(row.min, row.max));
            }
        }
    }
    put_bounds(lane, bounds);
    workgroupBarrier();
    write_bounds(lane, first, count);
}
