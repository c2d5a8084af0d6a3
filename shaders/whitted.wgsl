// What: the picture: one invocation a pixel, all its samples and everything that follows from them.
// Reads: groups 0 and 1. Writes: pixels (linear RGB, alpha 1) and counters.
// Twin: engine/src/trace/cpu/mod.rs.
#import orrery::types::CounterRow
#import orrery::scene::{pass_row, view}
#import orrery::pixel::sum_of_samples
#import orrery::counters as tally

@group(2) @binding(0) var<storage, read_write> pixels: array<vec4f>;
@group(2) @binding(1) var<storage, read_write> counters: CounterRow;

var<workgroup> group_primary: atomic<u32>;
var<workgroup> group_reflected: atomic<u32>;
var<workgroup> group_refracted: atomic<u32>;
var<workgroup> group_shadow: atomic<u32>;

// A band of rows from pass_row.first on, pass_row.count of them.
@compute @workgroup_size(8, 8)
fn whitted(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) lane: u32) {
    if at.x < view.width && at.y < pass_row.count {
        let y = at.y + pass_row.first;
        let sum = sum_of_samples(at.x, y, 0u, view.samples);
        pixels[y * view.width + at.x] = vec4f(sum / f32(view.samples), 1.0);
        count_rays();
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&counters.primary_rays, atomicLoad(&group_primary));
        atomicAdd(&counters.reflected_rays, atomicLoad(&group_reflected));
        atomicAdd(&counters.refracted_rays, atomicLoad(&group_refracted));
        atomicAdd(&counters.shadow_rays, atomicLoad(&group_shadow));
    }
}

// Overflows are rare: they go straight to the sum.
fn count_rays() {
    atomicAdd(&group_primary, view.samples);
    atomicAdd(&group_reflected, tally::reflected_rays);
    atomicAdd(&group_refracted, tally::refracted_rays);
    atomicAdd(&group_shadow, tally::shadow_rays);
    if tally::media_overflows > 0u {
        atomicAdd(&counters.media_overflows, tally::media_overflows);
    }
    if tally::straight_overflows > 0u {
        atomicAdd(&counters.straight_overflows, tally::straight_overflows);
    }
#ifdef CUTOFF
    if tally::dropped_rays > 0u {
        atomicAdd(&counters.dropped_rays, tally::dropped_rays);
    }
#endif
}
