// What: the picture: one invocation a pixel, the next of its samples and everything that follows from it.
// Reads: groups 0 and 1, pixels that have samples already. Writes: pixels and counters.
// Twin: Canvas in engine/src/trace/cpu/canvas.rs.
#import orrery::scene::{pass_row, view}
#import orrery::picture::{add_up, count_rays, pixels}
#import orrery::pixel::{light_of_sample, with_sample}

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
        if first < pass_row.limit {
            pixels[index] = with_sample(so_far, light_of_sample(at.x, y, first));
            count_rays();
        }
    }
    add_up(lane);
}
