// What: the next sample of the pixels that edges.wgsl listed, one invocation a pixel. Listed, they fill
// their workgroups, however few of the picture they are; their order does not show.
// Reads: groups 0 and 1, the list. Writes: pixels and counters.
// Twin: Canvas in engine/src/trace/cpu/canvas.rs.
#import orrery::scene::{pass_row, view}
#import orrery::picture::{add_up, count_rays, pixels, report}
#import orrery::pixel::{light_of_sample, with_sample}

// Entries of the list from pass_row.first on, at most pass_row.count of them.
@compute @workgroup_size(64)
fn antialias(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = pass_row.first + at.x;
    if at.x < pass_row.count && entry < atomicLoad(&report.counters.edge_pixels) {
        let index = report.edges[entry];
        let so_far = pixels[index];
        let first = u32(so_far.w);
        let light = light_of_sample(index % view.width, index / view.width, first);
        pixels[index] = with_sample(so_far, light);
        count_rays();
    }
    add_up(lane);
}
