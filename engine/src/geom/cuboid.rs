//! The box [-1, 1]^3; a box's size and place are in its instance's transform.

use glam::Vec3;

use super::safe_reciprocal;

/// Face numbers: -x +x -y +y -z +z are 0..6.
fn face(axis: usize, positive: bool) -> u32 {
    2 * axis as u32 + u32::from(positive)
}

/// Outward normal of a face.
pub fn cuboid_normal(face: u32) -> Vec3 {
    let sign = if face % 2 == 1 { 1.0 } else { -1.0 };
    Vec3::AXES[(face as usize / 2).min(2)] * sign
}

/// Both faces a ray meets, entry first: `[(t, face); 2]`; none for a miss.
pub fn intersect_cuboid(origin: Vec3, dir: Vec3) -> Option<[(f32, u32); 2]> {
    let (mut near, mut far) = ((f32::MIN, 0), (f32::MAX, 0));
    for axis in 0..3 {
        let inverse = safe_reciprocal(dir[axis]);
        let (low, high) = (
            (-1.0 - origin[axis]) * inverse,
            (1.0 - origin[axis]) * inverse,
        );
        let forward = inverse > 0.0;
        let (enter, leave) = if forward { (low, high) } else { (high, low) };
        if enter > near.0 {
            near = (enter, face(axis, !forward));
        }
        if leave < far.0 {
            far = (leave, face(axis, forward));
        }
    }
    (near.0 <= far.0).then_some([near, far])
}
