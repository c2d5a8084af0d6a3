// What: a pixel's samples: where they lie, and the light along the ray through each.
// Reads: the view and what path reads. Writes: what path writes.
// Twins: engine/src/frame/samples.rs, engine/src/trace/cpu/pixel.rs.
#define_import_path orrery::pixel

#import orrery::types::{PROJECTION_PERSPECTIVE, SAMPLE_COLUMN_A, SAMPLE_COLUMN_B, SAMPLE_COLUMN_C, SAMPLE_COLUMN_D, SAMPLE_COLUMN_E, SAMPLE_COLUMN_F, SAMPLE_COLUMN_G, SAMPLE_COLUMN_H, SAMPLE_FIRST_CELL}
#import orrery::scene::view
#import orrery::path::{Travel, camera_travel, radiance}
#ifdef CUTOFF
#import orrery::cutoff::fill_purse
#endif

// The light of a pixel's sample of this number. A kernel takes one: in a loop over several, invocations that are done with
// theirs do not wait for each other, and what they trace side by side no longer lies side by side.
fn light_of_sample(x: u32, y: u32, index: u32) -> vec3f {
#ifdef CUTOFF
    fill_purse(index);
#endif
    let at = vec2f(f32(x), f32(y)) + sample_offset(index);
    return radiance(camera_ray(at.x, at.y));
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

// A pixel (the mean of its samples, and their number) with one more of them.
fn with_sample(so_far: vec4f, light: vec3f) -> vec4f {
    let count = so_far.w + 1.0;
    return vec4f(so_far.rgb + (light - so_far.rgb) / count, count);
}
