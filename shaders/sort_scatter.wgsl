// What: the third pass of the sort: pairs go where their digit belongs, those of the same digit in the order they had.
// Reads: pairs, counts, totals. Writes: sorted.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::stage::{group_index, stage}
#import orrery::digits::{BLOCK_PAIRS, DIGITS, block_count, digit_of}

@group(0) @binding(1) var<storage, read> pairs: array<vec2u>;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
@group(0) @binding(3) var<storage, read> totals: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted: array<vec2u>;

// Where the next pair of each digit goes.
var<workgroup> places: array<u32, 256>;
// Which of 256 invocations hold a digit: a bit each, eight words a digit, one word of all digits after the other.
var<workgroup> holders: array<atomic<u32>, 2048>;

@compute @workgroup_size(256)
fn sort_scatter(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group_index(group, groups);
    find_places(block, lane);
    for (var turn = 0u; turn < BLOCK_PAIRS; turn += DIGITS) {
        let index = block * BLOCK_PAIRS + turn + lane;
        let is_pair = index < stage.count;
        var pair = vec2u(0u);
        var digit = 0u;
        if is_pair {
            pair = pairs[index];
            digit = digit_of(pair.x);
            atomicOr(&holders[lane / 32u * DIGITS + digit], 1u << (lane % 32u));
        }
        workgroupBarrier();
        if is_pair {
            sorted[places[digit] + holders_before(digit, lane)] = pair;
        }
        workgroupBarrier();
        for (var word = lane; word < 8u * DIGITS; word += DIGITS) {
            places[lane] += countOneBits(atomicLoad(&holders[word]));
            atomicStore(&holders[word], 0u);
        }
        workgroupBarrier();
    }
}

// All pairs of lower digits, and those of the same digit in blocks before.
fn find_places(block: u32, lane: u32) {
    let own = totals[lane];
    places[lane] = own;
    workgroupBarrier();
    // Hillis and Steele 1986.
    for (var reach = 1u; reach < DIGITS; reach *= 2u) {
        var other = 0u;
        if lane >= reach {
            other = places[lane - reach];
        }
        workgroupBarrier();
        places[lane] += other;
        workgroupBarrier();
    }
    var earlier = 0u;
    if block < block_count() {
        earlier = counts[lane * block_count() + block];
    }
    places[lane] = places[lane] - own + earlier;
    workgroupBarrier();
}

fn holders_before(digit: u32, lane: u32) -> u32 {
    var before = 0u;
    for (var word = 0u; word < lane / 32u; word++) {
        before += countOneBits(atomicLoad(&holders[word * DIGITS + digit]));
    }
    let own = atomicLoad(&holders[lane / 32u * DIGITS + digit]);
    return before + countOneBits(own & ((1u << (lane % 32u)) - 1u));
}
