// What: the picture: one invocation a pixel, the next few of its samples and everything that follows from them.
// Reads: groups 0 and 1, pixels that have samples already. Writes: pixels and counters.
// Twin: Canvas in engine/src/trace/cpu/canvas.rs.
#import orrery::scene::{pass_row, view}
#import orrery::picture::{add_up, count_rays, pixels}
#import orrery::pixel::{sum_of_samples, with_samples}

// A band of rows from pass_row.first on, pass_row.count of them.
@compute @workgroup_size(8, 8)
fn whitted(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) lane: u32) {
    if at.x < view.width && at.y < pass_row.count {
        let y = at.y + pass_row.first;
        let index = y * view.width + at.x;
        var so_far = vec4f(0.0);
        if pass_row.goes_on == 1u {
            so_far = pixels[index];
        }
        let first = u32(so_far.w);
        let end = min(first + pass_row.samples, pass_row.limit);
        if first < end {
            let sum = sum_of_samples(at.x, y, first, end);
            pixels[index] = with_samples(so_far, sum, end);
            count_rays(end - first);
        }
    }
    add_up(lane);
}
