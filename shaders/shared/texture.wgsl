// What: filtered lookups in the memory of texels: bilinear in a level, linear between two.
// Reads: texels. Writes: nothing.
// Twin: engine/src/trace/cpu/texture.rs, which has the sources; engine/src/trace/pack/texels.rs lays the memory out.
#define_import_path orrery::texture

#ifdef TEXELS
#import orrery::types::{TEXELS_SHIFT, WRAP_MIRROR, WRAP_REPEAT}

// Four numbers of 16 bits each, by number: a row of a layer holds a power of two of them, and a layer as many rows.
@group(3) @binding(0) var texels: texture_2d_array<u32>;

// Narrower footprints read the first level.
const NARROWEST: f32 = 1e-30;

// The four numbers at a place of the memory.
fn numbers(place: u32) -> vec4u {
    let mask = (1u << TEXELS_SHIFT) - 1u;
    let at = vec2u(place & mask, (place >> TEXELS_SHIFT) & mask);
    let words = textureLoad(texels, at, place >> (2u * TEXELS_SHIFT), 0).xy;
    return vec4u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu, words.y >> 16u);
}

// The texture that begins at `first`, at `uv`, averaged over about `footprint` of its edge: linear RGB and alpha.
fn sample(first: u32, uv: vec2f, footprint: f32) -> vec4f {
    let head = numbers(first);
    let whole = vec2f(numbers(first + 1u).zw);
    let across = footprint * sqrt(whole.x * whole.y);
    let level = clamp(log2(max(across, NARROWEST)), 0.0, f32(head.x - 1u));
    let fine = floor(level);
    let share = level - fine;
    let at = vec2f(inside(uv.x, head.y), inside(uv.y, head.y));
    let near = bilinear(first + 1u + u32(fine), at, head.y);
    if share == 0.0 {
        return near;
    }
    return near * (1.0 - share) + bilinear(first + 2u + u32(fine), at, head.y) * share;
}

// The place in the picture that a coordinate beyond it shows, from 0 to 1.
fn inside(x: f32, wrap: u32) -> f32 {
    if wrap == WRAP_REPEAT {
        return x - floor(x);
    }
    if wrap == WRAP_MIRROR {
        return 1.0 - abs(x - 2.0 * floor(x * 0.5) - 1.0);
    }
    return clamp(x, 0.0, 1.0);
}

// The four texels around a place in the level with this head.
fn bilinear(head: u32, uv: vec2f, wrap: u32) -> vec4f {
    let level = numbers(head);
    let place = level.x | (level.y << 16u);
    let size = vec2i(level.zw);
    let at = uv * vec2f(size) - 0.5;
    let corner = floor(at);
    let share = at - corner;
    let from_corner = vec2i(corner);
    let left = beside(from_corner.x, size.x, wrap);
    let right = beside(from_corner.x + 1, size.x, wrap);
    let top = place + beside(from_corner.y, size.y, wrap) * level.z;
    let bottom = place + beside(from_corner.y + 1, size.y, wrap) * level.z;
    let upper = texel(top + left) * (1.0 - share.x) + texel(top + right) * share.x;
    let lower = texel(bottom + left) * (1.0 - share.x) + texel(bottom + right) * share.x;
    return upper * (1.0 - share.y) + lower * share.y;
}

// The texel that stands for one at most one beyond the edge.
fn beside(i: i32, count: i32, wrap: u32) -> u32 {
    if wrap != WRAP_REPEAT {
        return u32(clamp(i, 0, count - 1));
    }
    if i < 0 {
        return u32(i + count);
    }
    return u32(select(i, i - count, i >= count));
}

fn texel(place: u32) -> vec4f {
    return vec4f(numbers(place)) * (1.0 / 65535.0);
}
#endif
