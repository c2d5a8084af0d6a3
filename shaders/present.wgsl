// Present: scene light to display light, scaled to the window: exposure, tone curve, sRGB.
// Reads: the frame's uniform, the picture (linear f32, 3 or 4 numbers a pixel). Writes: the target.
// Twin: engine/src/present/tone.rs, compared pixel by pixel in the tests.
// Sources: Reinhard et al. 2002, eq. 3; Narkowicz 2015; IEC 61966-2-1.

struct Present {
    picture_size: vec2u,
    target_size: vec2u,
    // 2^exposure
    gain: f32,
    // world::ToneMap in the order of its variants
    tone: u32,
    // numbers a pixel: 4 from the GPU tracer, 3 from the host
    stride: u32,
    // 1: the target stores sRGB numbers as they are; 0: it encodes them itself
    encode: u32,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var<storage, read> picture: array<f32>;

const LUMINANCE = vec3f(0.2126, 0.7152, 0.0722);
const BRIGHTEST = 1.0e6;
const TONE_REINHARD = 1u;
const TONE_FILMIC = 2u;

fn filmic(x: vec3f) -> vec3f {
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

fn display_rgb(pixel: vec3f) -> vec3f {
    let light = min(max(pixel * present.gain, vec3f(0.0)), vec3f(BRIGHTEST));
    var mapped = light;
    if present.tone == TONE_REINHARD {
        mapped = light / (1.0 + dot(light, LUMINANCE));
    } else if present.tone == TONE_FILMIC {
        mapped = filmic(light);
    }
    return clamp(mapped, vec3f(0.0), vec3f(1.0));
}

fn srgb_from_linear(x: vec3f) -> vec3f {
    let curve = 1.055 * pow(max(x, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * x, x <= vec3f(0.0031308));
}

// Display light of one pixel; outside, that of the nearest one inside.
fn shown(at: vec2i) -> vec3f {
    let inside = vec2u(clamp(at, vec2i(0), vec2i(present.picture_size) - 1));
    let i = (inside.y * present.picture_size.x + inside.x) * present.stride;
    return display_rgb(vec3f(picture[i], picture[i + 1u], picture[i + 2u]));
}

// Between pixels: blended after the tone curve, so that one very bright pixel does not bleed.
fn scaled(target_pixel: vec2f) -> vec3f {
    let scale = vec2f(present.picture_size) / vec2f(present.target_size);
    let at = target_pixel * scale - 0.5;
    let corner = vec2i(floor(at));
    let part = at - floor(at);
    let above = mix(shown(corner), shown(corner + vec2i(1, 0)), part.x);
    let below = mix(shown(corner + vec2i(0, 1)), shown(corner + vec2i(1, 1)), part.x);
    return mix(above, below, part.y);
}

// One triangle that covers the target.
@vertex
fn vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let x = f32(i32(corner & 1u) * 4 - 1);
    let y = f32(i32(corner >> 1u) * 4 - 1);
    return vec4f(x, y, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var light: vec3f;
    if all(present.picture_size == present.target_size) {
        light = shown(vec2i(position.xy));
    } else {
        light = scaled(position.xy);
    }
    if present.encode == 1u {
        light = srgb_from_linear(light);
    }
    return vec4f(light, 1.0);
}
