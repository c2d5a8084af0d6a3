// What: many meshes in one dispatch: each has a run of workgroups.
// Reads: jobs, stage. Writes: nothing.
// Twin: engine/src/trace/gpu/trees/plan.rs.
#define_import_path orrery::jobs

#import orrery::types::JobRow
#import orrery::stage::stage

@group(0) @binding(1) var<storage, read> jobs: array<JobRow>;

// The job that a workgroup of this dispatch belongs to: the last that begins at or before it.
fn job_of(group: u32) -> u32 {
    var first = stage.first;
    var count = stage.count;
    while count > 1u {
        let half = count / 2u;
        if jobs[first + half].first_group <= group {
            first += half;
            count -= half;
        } else {
            count = half;
        }
    }
    return first;
}
