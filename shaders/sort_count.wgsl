// What: the first of three passes that sort pairs by one digit: how often each digit is in each block.
// Reads: pairs. Writes: counts, digit by digit.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::stage::{group_index, stage}
#import orrery::digits::{BLOCK_PAIRS, DIGITS, block_count, digit_of}

@group(0) @binding(1) var<storage, read> pairs: array<vec2u>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

var<workgroup> tally: array<atomic<u32>, 256>;

@compute @workgroup_size(256)
fn sort_count(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group_index(group, groups);
    let end = min((block + 1u) * BLOCK_PAIRS, stage.count);
    for (var index = block * BLOCK_PAIRS + lane; index < end; index += DIGITS) {
        atomicAdd(&tally[digit_of(pairs[index].x)], 1u);
    }
    workgroupBarrier();
    if block < block_count() {
        counts[lane * block_count() + block] = atomicLoad(&tally[lane]);
    }
}
