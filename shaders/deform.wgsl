// What: deformed positions of vertices; an invocation a vertex, which goes through the mesh's steps in order.
// Reads: jobs, data (at rest), steps and params (of the frame). Writes: positions of vertices.
// Twin: engine/src/trace/pack/deform.rs.
#import orrery::types::{STEP_KEYS, STEP_MORPH, STEP_SKIN, STEP_TWIST, STEP_WAVE, StepRow, VertexRow}
#import orrery::stage::group_index
#import orrery::jobs::{job_of, jobs}
#import orrery::trig::sin_cos

// Positions, and normals elsewhere.
@group(0) @binding(2) var<storage, read_write> vertices: array<VertexRow>;
// Numbers and bits of numbers: positions at rest, poses, targets, joints and their weights.
@group(0) @binding(3) var<storage, read> data: array<u32>;
@group(0) @binding(4) var<storage, read> steps: array<StepRow>;
@group(0) @binding(5) var<storage, read> params: array<vec4f>;

@compute @workgroup_size(64)
fn deform(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = group_index(group, groups);
    let job = job_of(at);
    let vertex = (at - jobs[job].first_group) * 64u + lane;
    if vertex >= jobs[job].count {
        return;
    }
    var p = vector(jobs[job].rest, vertex);
    let first = jobs[job].first;
    for (var index = first; index < first + jobs[job].step_count; index++) {
        p = taken(steps[index], vertex, p);
    }
    vertices[jobs[job].first_vertex + vertex].vector = p;
}

// One step.
fn taken(step: StepRow, vertex: u32, p: vec3f) -> vec3f {
    switch step.kind {
        case STEP_KEYS: {
            let share = params[step.params].x;
            return vector(step.from_set, vertex) * (1.0 - share) + vector(step.to_set, vertex) * share;
        }
        case STEP_MORPH: {
            return morphed(step, vertex, p);
        }
        case STEP_SKIN: {
            return skinned(step, vertex, p);
        }
        case STEP_WAVE: {
            let wave = params[step.params];
            return p + params[step.params + 1u].xyz * sin_cos(dot(wave.xyz, p) - wave.w).x;
        }
        case STEP_TWIST: {
            return twisted(step, p);
        }
        default: {
            return p;
        }
    }
}

// The weighted offsets of the targets that have a weight: a row each of weight and where the target's data begin.
fn morphed(step: StepRow, vertex: u32, p: vec3f) -> vec3f {
    var sum = p;
    for (var index = step.params; index < step.params + step.count; index++) {
        let target_row = params[index];
        sum += vector(bitcast<u32>(target_row.y), vertex) * target_row.x;
    }
    return sum;
}

// Linear blend skinning: up to four joints, three rows of params each.
fn skinned(step: StepRow, vertex: u32, p: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var index = 0u; index < 4u; index++) {
        let weight = bitcast<f32>(data[step.to_set + vertex * 4u + index]);
        if weight != 0.0 {
            let joint = step.params + 3u * data[step.from_set + vertex * 4u + index];
            let at = vec4f(p, 1.0);
            sum += vec3f(dot(params[joint], at), dot(params[joint + 1u], at), dot(params[joint + 2u], at)) * weight;
        }
    }
    return sum;
}

// Rodrigues' rotation about a line, by an angle that grows along it.
fn twisted(step: StepRow, p: vec3f) -> vec3f {
    let origin = params[step.params];
    let axis = params[step.params + 1u];
    let out = p - origin.xyz;
    let along = dot(out, axis.xyz);
    let turn = sin_cos(origin.w * along + axis.w);
    return origin.xyz + (out * turn.y + cross(axis.xyz, out) * turn.x + axis.xyz * (along * (1.0 - turn.y)));
}

fn vector(first: u32, vertex: u32) -> vec3f {
    let at = first + vertex * 3u;
    return bitcast<vec3f>(vec3u(data[at], data[at + 1u], data[at + 2u]));
}
