//! A frame around a normal: Duff, Burgess, Christensen, Hery, Kensler, Liani and Villemin, "Building an
//! Orthonormal Basis, Revisited" (JCGT 6:1, 2017).
//!
//! Twin of `out_of_frame` in `shaders/leave.wgsl`.

use glam::Vec3;

/// A vector given in the frame whose z axis is the unit normal `n`, in the space of `n`.
pub fn out_of_frame(n: Vec3, v: Vec3) -> Vec3 {
    let side = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    let tangent = Vec3::new(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
    let bitangent = Vec3::new(b, side + n.y * n.y * a, -n.y);
    tangent * v.x + bitangent * v.y + n * v.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn the_frame_is_orthonormal_all_around() {
        let mut random = Random::new(5);
        for _ in 0..10_000 {
            let n = random.direction().as_vec3().normalize();
            let axes = Vec3::AXES.map(|axis| out_of_frame(n, axis));
            assert_eq!(axes[2], n);
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                assert!(axes[i].dot(axes[j]).abs() < 1e-6, "{n}: {axes:?}");
                assert!((axes[i].length() - 1.0).abs() < 1e-6, "{n}: {axes:?}");
            }
        }
    }
}
