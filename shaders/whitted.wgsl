// What: the picture: one invocation a pixel, all its samples and everything that follows from them.
// Reads: groups 0 and 1. Writes: pixels (linear RGB, alpha 1) and counters.
// Twin: pixel_color and camera_ray in engine/src/trace/cpu/mod.rs.
#import orrery::types::{CounterRow, PROJECTION_PERSPECTIVE}
#import orrery::scene::{pass_row, view}
#import orrery::path::{Travel, camera_travel, radiance}
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
        pixels[y * view.width + at.x] = vec4f(pixel_color(at.x, y), 1.0);
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

// The mean over the pixel's grid of samples.
fn pixel_color(x: u32, y: u32) -> vec3f {
    let n = view.samples_per_axis;
    var sum = vec3f(0.0);
    for (var index = 0u; index < n * n; index++) {
        let px = f32(x) + (f32(index % n) + 0.5) / f32(n);
        let py = f32(y) + (f32(index / n) + 0.5) / f32(n);
        sum += radiance(camera_ray(px, py));
    }
    return sum / f32(n * n);
}

// The ray through a point of the picture, in pixels from its top left corner.
fn camera_ray(px: f32, py: f32) -> Travel {
    // Half pixels from the middle: whole numbers, exact in f32, at the centres of pixels.
    let across = 2.0 * px - f32(view.width);
    let upward = f32(view.height) - 2.0 * py;
    let aside = view.right_step * across + view.up_step * upward;
    if view.projection == PROJECTION_PERSPECTIVE {
        return camera_travel(vec3f(0.0), normalize(view.forward + aside));
    }
    return camera_travel(aside, view.forward);
}

// Overflows are rare: they go straight to the sum.
fn count_rays() {
    atomicAdd(&group_primary, view.samples_per_axis * view.samples_per_axis);
    atomicAdd(&group_reflected, tally::reflected_rays);
    atomicAdd(&group_refracted, tally::refracted_rays);
    atomicAdd(&group_shadow, tally::shadow_rays);
    if tally::media_overflows > 0u {
        atomicAdd(&counters.media_overflows, tally::media_overflows);
    }
    if tally::straight_overflows > 0u {
        atomicAdd(&counters.straight_overflows, tally::straight_overflows);
    }
}
