// What: one level of the trees of meshes whose vertices changed; an invocation a child. Levels go from the deepest up.
// Reads: jobs, corners of triangles, vertices, nodes of the level below. Writes: positions in triangles (each is in one
// leaf, so by one invocation); boxes of nodes; partials: what they cost.
// Twin: Tree::refit in engine/src/bvh.
#import orrery::types::{CHILD_LEAF, CHILD_NONE, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, PlacedTriangleRow, VertexRow}
#import orrery::stage::group_index
#import orrery::jobs::{job_of, jobs}
#import orrery::boxes::{Bounds, grown, half_area, no_bounds, take_in}
#import orrery::fit::{GROUP_NODES, child_slot, node_bounds, put_bounds, write_bounds}

@group(0) @binding(2) var<storage, read_write> triangles: array<PlacedTriangleRow>;
// Positions, and normals elsewhere.
@group(0) @binding(4) var<storage, read> vertices: array<VertexRow>;
@group(0) @binding(5) var<storage, read_write> partials: array<f32>;

var<workgroup> costs: array<f32, 128>;

@compute @workgroup_size(128)
fn refit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = group_index(group, groups);
    let job = job_of(at);
    let own = at - jobs[job].first_group;
    let done = min(own * GROUP_NODES, jobs[job].count);
    let count = min(jobs[job].count - done, GROUP_NODES);
    let first = jobs[job].root + jobs[job].first + done;
    var bounds = no_bounds();
    var cost = 0.0;
    if lane / 4u < count {
        let child = child_slot(first + lane / 4u, lane % 4u);
        var weight = 1.0;
        if child == CHILD_NONE {
            weight = 0.0;
        } else if (child & CHILD_LEAF) == 0u {
            bounds = node_bounds(jobs[job].root + child);
        } else {
            let leaf = ((child & ~CHILD_LEAF) >> LEAF_COUNT_SHIFT) + 1u;
            bounds = place_leaf(job, child & LEAF_FIRST_MASK, leaf);
            weight = f32(leaf);
        }
        cost = weight * half_area(bounds);
    }
    put_bounds(lane, bounds);
    costs[lane] = cost;
    workgroupBarrier();
    write_bounds(lane, first, count);
    add_costs(lane);
    if lane == 0u && count > 0u {
        partials[jobs[job].partial + own] = costs[0];
    }
}

// Puts positions into the triangles of a leaf; its box. Only here boxes grow: the union of grown boxes is the grown union.
fn place_leaf(job: u32, first: u32, count: u32) -> Bounds {
    var bounds = no_bounds();
    let corner = jobs[job].first_vertex;
    let start = jobs[job].first_triangle + first;
    for (var index = start; index < start + count; index++) {
        let corners = triangles[index].corners + vec3u(corner);
        let a = vertices[corners.x].vector;
        let b = vertices[corners.y].vector;
        let c = vertices[corners.z].vector;
        triangles[index].a = a;
        triangles[index].b = b;
        triangles[index].c = c;
        bounds = take_in(take_in(take_in(bounds, a), b), c);
    }
    return grown(bounds);
}

// Always in the same order: the same tree costs the same.
fn add_costs(lane: u32) {
    for (var half = 64u; half > 0u; half /= 2u) {
        if lane < half {
            costs[lane] += costs[lane + half];
        }
        workgroupBarrier();
    }
}
