// What: the numbers of one dispatch that works on trees, and which workgroup this is.
// Reads: stage. Writes: nothing.
// Twin: engine/src/trace/gpu/trees/plan.rs.
#define_import_path orrery::stage

#import orrery::types::StageRow

@group(0) @binding(0) var<uniform> stage: StageRow;

// Workgroups beyond what one dimension holds go on in the second; the last row may be longer than needed.
fn group_index(group: vec3u, groups: vec3u) -> u32 {
    return group.y * groups.x + group.x;
}
