// What: the second pass of the sort: for each block, how many pairs of the same digit lie in blocks before it; a workgroup a digit.
// Reads and writes: counts. Writes: totals of the digits.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::digits::{DIGITS, block_count}

@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> totals: array<u32>;

var<workgroup> sums: array<u32, 256>;

@compute @workgroup_size(256)
fn sort_scan(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let blocks = block_count();
    let row = group.x * blocks;
    var before = 0u;
    for (var first = 0u; first < blocks; first += DIGITS) {
        let block = first + lane;
        var own = 0u;
        if block < blocks {
            own = counts[row + block];
        }
        sums[lane] = own;
        workgroupBarrier();
        // Hillis and Steele 1986.
        for (var reach = 1u; reach < DIGITS; reach *= 2u) {
            var other = 0u;
            if lane >= reach {
                other = sums[lane - reach];
            }
            workgroupBarrier();
            sums[lane] += other;
            workgroupBarrier();
        }
        if block < blocks {
            counts[row + block] = before + sums[lane] - own;
        }
        before += workgroupUniformLoad(&sums[DIGITS - 1u]);
    }
    if lane == 0u {
        totals[group.x] = before;
    }
}
