// What: the unit disc about the origin across +Y.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/disc.rs.
#define_import_path orrery::disc

// A direction less steep than this runs along the disc: beyond it, distances would leave f32's range.
const LEAST_STEEPNESS: f32 = 1e-18;

struct DiscHit {
    hits: bool,
    t: f32,
}

fn hit_disc(origin: vec3f, dir: vec3f) -> DiscHit {
    if abs(dir.y) <= LEAST_STEEPNESS * (abs(dir.x) + abs(dir.z)) {
        return DiscHit(false, 0.0);
    }
    let t = -origin.y / dir.y;
    let at = origin.xz + dir.xz * t;
    let is_near = max(abs(at.x), abs(at.y)) <= 1.0;
    return DiscHit(is_near && dot(at, at) <= 1.0, t);
}
