// What: the media a ray is inside of, and the index ratios that follow.
// Reads: instances, materials. Writes: nothing.
// Twin: engine/src/trace/cpu/media.rs.
#define_import_path orrery::media

#import orrery::types::{MEDIA_CAPACITY, NONE}
#import orrery::scene::{instances, materials}

// Instance rows, the innermost first, NONE where there is none. Two vectors rather than an array: shifting
// needs no index, so the list can stay in registers.
struct Media {
    near: vec4u,
    far: vec4u,
}

const_assert MEDIA_CAPACITY == 8u;

// The list on the other side of a boundary; `overflows`: a medium did not fit and was left out.
struct Crossed {
    media: Media,
    overflows: bool,
}

fn no_media() -> Media {
    return Media(vec4u(NONE), vec4u(NONE));
}

fn is_inside(media: Media, row: u32) -> bool {
    return any(media.near == vec4u(row)) || any(media.far == vec4u(row));
}

// Index of refraction of a medium; air is outside of all.
fn ior_of(row: u32) -> f32 {
    if row == NONE {
        return 1.0;
    }
    return materials[instances[row].material].ior;
}

// Index here over index there at the boundary of a medium. Leaving one that is not the innermost changes
// nothing.
fn index_ratio(media: Media, row: u32, ior: f32) -> f32 {
    if media.near.x == row {
        return ior / ior_of(media.near.y);
    }
    if is_inside(media, row) {
        return 1.0;
    }
    return ior_of(media.near.x) / ior;
}

#ifdef ABSORPTION
// Beyond this, nothing is left of light.
const FAINTEST: f32 = 87.0;
// Lengths beyond this are as this one.
const LONGEST: f32 = 1e18;

// What is left of light after a length within the innermost medium (Beer and Lambert).
fn left_after(media: Media, length: f32) -> vec3f {
    if media.near.x == NONE {
        return vec3f(1.0);
    }
    let absorption = materials[instances[media.near.x].material].absorption;
    return exp(-min(absorption * clamp(length, 0.0, LONGEST), vec3f(FAINTEST)));
}
#endif

fn cross_boundary(media: Media, row: u32) -> Crossed {
    if is_inside(media, row) {
        return Crossed(without(media, row), false);
    }
    if media.far.w != NONE {
        return Crossed(media, true);
    }
    return Crossed(Media(vec4u(row, media.near.xyz), vec4u(media.near.w, media.far.xyz)), false);
}

// Those before the row stay, those after it move up.
fn without(media: Media, row: u32) -> Media {
    let near_x = media.near.x != row;
    let near_y = near_x && media.near.y != row;
    let near_z = near_y && media.near.z != row;
    let near_w = near_z && media.near.w != row;
    let far_x = near_w && media.far.x != row;
    let far_y = far_x && media.far.y != row;
    let far_z = far_y && media.far.z != row;
    let near = vec4u(media.near.yzw, media.far.x);
    let far = vec4u(media.far.yzw, NONE);
    return Media(
        select(near, media.near, vec4<bool>(near_x, near_y, near_z, near_w)),
        select(far, media.far, vec4<bool>(far_x, far_y, far_z, false)),
    );
}
