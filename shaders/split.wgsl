// What: one level of a tree over boxes in the order of their codes: each node's range becomes up to four; an invocation a node.
// Reads: pairs (sorted), ranges of this level. Writes: children of nodes, ranges and number of nodes of the next level.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#import orrery::types::{CHILD_LEAF, CHILD_NONE}
#import orrery::stage::{group_index, stage}
#import orrery::build::build
#import orrery::fit::{FACE_ROWS, NODE_ROWS, nodes}

@group(0) @binding(1) var<storage, read> pairs: array<vec2u>;
// First and number of a node's boxes in their sorted order, by node.
@group(0) @binding(4) var<storage, read_write> ranges: array<vec2u>;

// What outweighs every cell.
const MUST: u32 = 100u;

var<workgroup> group_nodes: atomic<u32>;
var<workgroup> group_first: u32;

@compute @workgroup_size(64)
fn split(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = group_index(group, groups) * 64u + lane;
    let start = build.level_starts[stage.level];
    let in_level = atomicLoad(&build.level_nodes[stage.level]);
    var parts = array<vec2u, 4>();
    var inner = 0u;
    var place = 0u;
    if index < in_level {
        parts = quarter(range_of(start + index));
        for (var part = 0u; part < 4u; part++) {
            inner += u32(parts[part].y > 1u);
        }
        place = atomicAdd(&group_nodes, inner);
    }
    workgroupBarrier();
    if index == 0u {
        build.level_starts[stage.level + 1u] = start + in_level;
    }
    if lane == 0u {
        let nodes_of_group = atomicLoad(&group_nodes);
        if nodes_of_group > 0u {
            group_first = atomicAdd(&build.level_nodes[stage.level + 1u], nodes_of_group);
        }
    }
    workgroupBarrier();
    if index < in_level {
        write_children(start + index, parts, start + in_level + group_first + place);
    }
}

fn range_of(node: u32) -> vec2u {
    if stage.level == 0u {
        return vec2u(0u, atomicLoad(&build.live));
    }
    return ranges[node];
}

fn write_children(node: u32, parts: array<vec2u, 4>, first_inner: u32) {
    var next = first_inner;
    var children = vec4u(CHILD_NONE);
    for (var part = 0u; part < 4u; part++) {
        let range = parts[part];
        if range.y == 1u {
            children[part] = CHILD_LEAF | pairs[range.x].y;
        } else if range.y > 1u {
            children[part] = next;
            ranges[next] = range;
            next++;
        }
    }
    nodes[(stage.first + node) * NODE_ROWS + FACE_ROWS] = children;
}

// Three cuts, each of the part that matters most. No part may hold more than the levels below have room for,
// whatever the codes: so the depth of a tree is bounded by construction.
fn quarter(whole: vec2u) -> array<vec2u, 4> {
    var parts = array<vec2u, 4>(whole, vec2u(0u), vec2u(0u), vec2u(0u));
    let room = 1u << (2u * (stage.levels - 1u - stage.level));
    // What is left for one half, two parts.
    var most = 2u * room;
    for (var filled = 1u; filled < 4u; filled++) {
        var chosen = 0u;
        var largest = 0u;
        for (var part = 0u; part < filled; part++) {
            let weight = weight_of(parts[part], room);
            if weight > largest {
                largest = weight;
                chosen = part;
            }
        }
        if largest == 0u {
            break;
        }
        let range = parts[chosen];
        let left = cut(range, most);
        parts[chosen] = vec2u(range.x, left);
        parts[filled] = vec2u(range.x + left, range.y - left);
        most = room;
    }
    return parts;
}

// How much a part wants to be cut: not at all if it is one box; above all if it is too large for a child; then
// by the size of the cell it lies in, which is the highest bit in which its codes differ.
fn weight_of(range: vec2u, room: u32) -> u32 {
    if range.y < 2u {
        return 0u;
    }
    if range.y > room {
        return MUST;
    }
    let differing = pairs[range.x].x ^ pairs[range.x + range.y - 1u].x;
    return 33u - countLeadingZeros(differing);
}

// How many boxes lie before the highest bit in which the range's codes differ is set (Karras 2012, section 4);
// equal codes are halved. Seven places are tried at once: loads wait for each other less.
fn cut(range: vec2u, most: u32) -> u32 {
    let least = max(range.y - min(most, range.y - 1u), 1u);
    let differing = pairs[range.x].x ^ pairs[range.x + range.y - 1u].x;
    if differing == 0u {
        return range.y / 2u;
    }
    let bit = 1u << firstLeadingBit(differing);
    // pairs[low] has the bit clear, pairs[low + size] has it set.
    var low = range.x;
    var size = range.y - 1u;
    while size > 1u {
        var clear = 0u;
        for (var eighth = 1u; eighth < 8u; eighth++) {
            let place = low + portion(size, eighth);
            clear += select(1u, 0u, (pairs[place].x & bit) != 0u);
        }
        let next = low + portion(size, clear);
        size = portion(size, clear + 1u) - portion(size, clear);
        low = next;
    }
    return clamp(low + 1u - range.x, least, range.y - least);
}

// Eighths of a size, rounded up to whole ones but for the whole: never overflows.
fn portion(size: u32, eighths: u32) -> u32 {
    return size / 8u * eighths + (size % 8u * eighths + 7u) / 8u;
}
