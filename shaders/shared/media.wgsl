// What: the media a ray is inside of, and the index ratios that follow (ACCURACY B.5).
// Reads: nothing. Writes: nothing.
// Twin: engine/src/trace/cpu/media.rs.
#define_import_path orrery::media

#import orrery::types::{MEDIA_CAPACITY, NONE}

// In order of entry. Fixed size; what does not fit is counted.
struct Media {
    ids: array<u32, MEDIA_CAPACITY>,
    iors: array<f32, MEDIA_CAPACITY>,
    count: u32,
}

// The list on the other side of a boundary; `overflows`: a medium did not fit and was left out.
struct Crossed {
    media: Media,
    overflows: bool,
}

fn place_of(media: Media, id: u32) -> u32 {
    for (var place = 0u; place < media.count; place++) {
        if media.ids[place] == id {
            return place;
        }
    }
    return NONE;
}

// Index `depth` media up from the innermost, which is 1; air is outside of all.
fn ior_at(media: Media, depth: u32) -> f32 {
    if media.count < depth {
        return 1.0;
    }
    return media.iors[media.count - depth];
}

// Index here over index there at the boundary of a medium. Leaving one that is not the innermost changes
// nothing.
fn index_ratio(media: Media, id: u32, ior: f32) -> f32 {
    let place = place_of(media, id);
    if place == NONE {
        return ior_at(media, 1u) / ior;
    }
    if place + 1u == media.count {
        return ior / ior_at(media, 2u);
    }
    return 1.0;
}

fn cross_boundary(media: Media, id: u32, ior: f32) -> Crossed {
    var beyond = media;
    let place = place_of(media, id);
    if place != NONE {
        for (var next = place + 1u; next < media.count; next++) {
            beyond.ids[next - 1u] = media.ids[next];
            beyond.iors[next - 1u] = media.iors[next];
        }
        beyond.count = media.count - 1u;
        return Crossed(beyond, false);
    }
    if media.count >= MEDIA_CAPACITY {
        return Crossed(beyond, true);
    }
    beyond.ids[media.count] = id;
    beyond.iors[media.count] = ior;
    beyond.count = media.count + 1u;
    return Crossed(beyond, false);
}
