// What: a pixel's samples: where they lie, and the light along the ray through each.
// Reads: the view and what path reads. Writes: what path writes.
// Twins: engine/src/frame/samples.rs, engine/src/trace/cpu/pixel.rs.
#define_import_path orrery::pixel

#import orrery::types::{PROJECTION_PERSPECTIVE, SAMPLE_COLUMN_A, SAMPLE_COLUMN_B, SAMPLE_COLUMN_C, SAMPLE_COLUMN_D, SAMPLE_COLUMN_E, SAMPLE_COLUMN_F, SAMPLE_COLUMN_G, SAMPLE_COLUMN_H, SAMPLE_FIRST_CELL}
#import orrery::scene::view
#import orrery::path::{Travel, camera_travel, radiance}

// The sum over a pixel's samples of these numbers, from `first` up to but not including `end`.
fn sum_of_samples(x: u32, y: u32, first: u32, end: u32) -> vec3f {
    var sum = vec3f(0.0);
    for (var index = first; index < end; index++) {
        let at = vec2f(f32(x), f32(y)) + sample_offset(index);
        sum += radiance(camera_ray(at.x, at.y));
    }
    return sum;
}

// The place of a sample in its pixel, right and down from the top left corner; exact.
fn sample_offset(index: u32) -> vec2f {
    if index == 0u {
        return vec2f(0.5);
    }
    var cell = SAMPLE_FIRST_CELL;
    cell ^= SAMPLE_COLUMN_A * (index & 1u);
    cell ^= SAMPLE_COLUMN_B * ((index >> 1u) & 1u);
    cell ^= SAMPLE_COLUMN_C * ((index >> 2u) & 1u);
    cell ^= SAMPLE_COLUMN_D * ((index >> 3u) & 1u);
    cell ^= SAMPLE_COLUMN_E * ((index >> 4u) & 1u);
    cell ^= SAMPLE_COLUMN_F * ((index >> 5u) & 1u);
    cell ^= SAMPLE_COLUMN_G * ((index >> 6u) & 1u);
    cell ^= SAMPLE_COLUMN_H * ((index >> 7u) & 1u);
    // Centres of cells of a grid of 256 x 256.
    return (vec2f(f32(cell & 0xffu), f32(cell >> 8u)) + 0.5) * 0.00390625;
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

// A pixel (the mean of its samples, and their number) with the sum of more of them, `end` in all.
fn with_samples(so_far: vec4f, sum: vec3f, end: u32) -> vec4f {
    let added = f32(end) - so_far.w;
    return vec4f(so_far.rgb + (sum - so_far.rgb * added) / f32(end), f32(end));
}
