// What: normals of smooth meshes whose vertices moved: the mean of the faces around, weighed by their areas.
// Reads: jobs, data (the two other corners of each face around each vertex), positions. Writes: normals of vertices.
// Twin: engine/src/trace/pack/deform.rs.
#import orrery::types::VertexRow
#import orrery::stage::group_index
#import orrery::jobs::{job_of, jobs}
#import orrery::affine::unit_or

// Positions and normals.
@group(0) @binding(2) var<storage, read_write> vertices: array<VertexRow>;
// Normals at rest. One more number than there are vertices: where the corners of each begin and the last end.
// Pairs of corners.
@group(0) @binding(3) var<storage, read> data: array<u32>;

@compute @workgroup_size(64)
fn normals(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let own_group = group_index(group, groups);
    let job = job_of(own_group);
    let vertex = (own_group - jobs[job].first_group) * 64u + lane;
    if vertex >= jobs[job].count {
        return;
    }
    let first_vertex = jobs[job].first_vertex;
    let p = vertices[first_vertex + vertex].vector;
    var sum = vec3f(0.0);
    let ends = jobs[job].rest + jobs[job].count * 3u + vertex;
    for (var index = data[ends]; index < data[ends + 1u]; index++) {
        let b = vertices[first_vertex + data[jobs[job].first + index * 2u]].vector;
        let c = vertices[first_vertex + data[jobs[job].first + index * 2u + 1u]].vector;
        sum += cross(b - p, c - p);
    }
    // Where faces cancel or have no area, the normal at rest stands.
    var normal = unit_or(sum, vec3f(0.0));
    if all(normal == vec3f(0.0)) {
        let at = jobs[job].rest + vertex * 3u;
        normal = bitcast<vec3f>(vec3u(data[at], data[at + 1u], data[at + 2u]));
    }
    vertices[jobs[job].first_normal + vertex].vector = normal;
}
