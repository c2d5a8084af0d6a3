// What: nodes whose boxes are computed, an invocation a child: 32 nodes a workgroup of 128.
// Reads and writes: nodes, as rows of 16 bytes (see Node4): invocations may not share one.
// Twin: engine/src/bvh/tree.rs.
#define_import_path orrery::fit

#import orrery::boxes::Bounds

@group(0) @binding(3) var<storage, read_write> nodes: array<vec4u>;

const NODE_ROWS: u32 = 7u;
const GROUP_NODES: u32 = 32u;
// Rows of boxes before the row of children.
const FACE_ROWS: u32 = 6u;

// Numbers of the group's nodes in the order of memory, so that they are written as whole rows.
var<workgroup> faces: array<u32, 768>;

fn child_slot(node: u32, slot: u32) -> u32 {
    return nodes[node * NODE_ROWS + FACE_ROWS][slot];
}

// The union of a node's boxes; the inverted ones of slots without a child add nothing.
fn node_bounds(node: u32) -> Bounds {
    let row = node * NODE_ROWS;
    return Bounds(
        vec3f(least(nodes[row]), least(nodes[row + 1u]), least(nodes[row + 2u])),
        vec3f(greatest(nodes[row + 3u]), greatest(nodes[row + 4u]), greatest(nodes[row + 5u])),
    );
}

fn least(row: vec4u) -> f32 {
    let v = bitcast<vec4f>(row);
    return min(min(v.x, v.y), min(v.z, v.w));
}

fn greatest(row: vec4u) -> f32 {
    let v = bitcast<vec4f>(row);
    return max(max(v.x, v.y), max(v.z, v.w));
}

// Keeps the box of an invocation's child.
fn put_bounds(lane: u32, bounds: Bounds) {
    let at = lane / 4u * 24u + lane % 4u;
    let low = bitcast<vec3u>(bounds.min);
    let high = bitcast<vec3u>(bounds.max);
    faces[at] = low.x;
    faces[at + 4u] = low.y;
    faces[at + 8u] = low.z;
    faces[at + 12u] = high.x;
    faces[at + 16u] = high.y;
    faces[at + 20u] = high.z;
}

// Writes the boxes of the group's nodes; call it behind a barrier.
fn write_bounds(lane: u32, first_node: u32, count: u32) {
    for (var row = lane; row < count * FACE_ROWS; row += 4u * GROUP_NODES) {
        let from_row = row * 4u;
        let node = first_node + row / FACE_ROWS;
        nodes[node * NODE_ROWS + row % FACE_ROWS] =
            vec4u(faces[from_row], faces[from_row + 1u], faces[from_row + 2u], faces[from_row + 3u]);
    }
}
