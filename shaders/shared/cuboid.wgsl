// What: the box [-1, 1]^3; faces -x +x -y +y -z +z are 0..6.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/cuboid.rs.
#define_import_path orrery::cuboid

#import orrery::slab::SlabRay

// Both faces a ray meets, entry first.
struct CuboidHit {
    hits: bool,
    near: f32,
    near_face: u32,
    far: f32,
    far_face: u32,
}

fn hit_cuboid(ray: SlabRay) -> CuboidHit {
    let low = (vec3f(-1.0) - ray.origin) * ray.inverse;
    let high = (vec3f(1.0) - ray.origin) * ray.inverse;
    let forward = ray.inverse > vec3f(0.0);
    let enter = select(high, low, forward);
    let leave = select(low, high, forward);
    let positive = select(vec3u(0u), vec3u(1u), forward);
    var hit = CuboidHit(false, enter.x, 1u - positive.x, leave.x, positive.x);
    if enter.y > hit.near {
        hit.near = enter.y;
        hit.near_face = 3u - positive.y;
    }
    if enter.z > hit.near {
        hit.near = enter.z;
        hit.near_face = 5u - positive.z;
    }
    if leave.y < hit.far {
        hit.far = leave.y;
        hit.far_face = 2u + positive.y;
    }
    if leave.z < hit.far {
        hit.far = leave.z;
        hit.far_face = 4u + positive.z;
    }
    hit.hits = hit.near <= hit.far;
    return hit;
}

// Outward normal of a face.
fn cuboid_normal(face: u32) -> vec3f {
    let axis = face / 2u;
    let along = select(-1.0, 1.0, (face & 1u) == 1u);
    return vec3f(
        select(0.0, along, axis == 0u),
        select(0.0, along, axis == 1u),
        select(0.0, along, axis == 2u),
    );
}
