// What: the background along a direction: a colour by height, times a panorama.
// Reads: the view, texels. Writes: nothing.
// Twin: engine/src/trace/cpu/sky.rs.
#define_import_path orrery::sky

#import orrery::scene::view
#ifdef PANORAMA
#import orrery::texture::numbers
#import orrery::trig::angle_of
#import orrery::types::NONE

const PER_TURN: f32 = 0.15915494;
#endif

// The background along a unit direction.
fn sky(dir: vec3f) -> vec3f {
    let height = min(abs(dir.y), 1.0);
    let end = select(view.ground, view.zenith, dir.y > 0.0);
    let color = view.background * (1.0 - height) + end * height;
#ifdef PANORAMA
    if view.panorama != NONE {
        return color * panorama(dir);
    }
#endif
    return color;
}

#ifdef PANORAMA
// The four texels around a direction: the picture goes round, and ends at the poles.
fn panorama(dir: vec3f) -> vec3f {
    let head = numbers(view.panorama + 1u);
    let place = head.x | (head.y << 16u);
    let size = vec2i(head.zw);
    let around = 0.5 + angle_of(dir.x, -dir.z) * PER_TURN + view.panorama_turn;
    let down = 0.5 - angle_of(dir.y, length(dir.xz)) * (2.0 * PER_TURN);
    let at = vec2f(around - floor(around), down) * vec2f(size) - 0.5;
    let corner = floor(at);
    let share = at - corner;
    let column = vec2i(corner);
    let left = u32(select(column.x, column.x + size.x, column.x < 0));
    let right = u32(select(column.x + 1, column.x + 1 - size.x, column.x + 1 >= size.x));
    let top = place + u32(clamp(column.y, 0, size.y - 1)) * head.z;
    let bottom = place + u32(clamp(column.y + 1, 0, size.y - 1)) * head.z;
    let upper = radiance(top + left) * (1.0 - share.x) + radiance(top + right) * share.x;
    let lower = radiance(bottom + left) * (1.0 - share.x) + radiance(bottom + right) * share.x;
    return upper * (1.0 - share.y) + lower * share.y;
}

// Three numbers and their exponent.
fn radiance(place: u32) -> vec3f {
    let texel = numbers(place);
    return vec3f(texel.xyz) * (1.0 / 65535.0) * bitcast<f32>(texel.w << 23u);
}
#endif
