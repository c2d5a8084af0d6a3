// What: the list of pixels whose contrast with one of the eight around them is more than view.edge_contrast.
// Reads: group 0, pixels. Writes: the list and how long it is.
// Twin: engine/src/trace/cpu/edges.rs, which has the sources.
#import orrery::scene::view
#import orrery::picture::{pixels, report}

// Light below which differences count as they are.
const DARK: f32 = 0.1;

@compute @workgroup_size(8, 8)
fn edges(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= view.width || at.y >= view.height {
        return;
    }
    let index = at.y * view.width + at.x;
    let here = pixels[index].rgb;
    let last = vec2u(view.width, view.height) - 1u;
    let low = max(at.xy, vec2u(1u)) - 1u;
    let high = min(at.xy + 1u, last);
    var most = 0.0;
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            most = max(most, contrast(here, pixels[y * view.width + x].rgb));
        }
    }
    if most > view.edge_contrast {
        report.edges[atomicAdd(&report.counters.edge_pixels, 1u)] = index;
    }
}

// The largest of the channels' differences, each over the greater of the two.
fn contrast(a: vec3f, b: vec3f) -> f32 {
    let relative = abs(a - b) / (max(abs(a), abs(b)) + DARK);
    return max(relative.x, max(relative.y, relative.z));
}
