//! ufbx's vectors and matrices to glam's.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use crate::world::{FARTHEST, Transform};

/// A point or direction.
pub fn vector(v: ufbx::Vec3) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

/// A unit quaternion; none: it is none.
pub fn rotation(q: ufbx::Quat) -> Option<DQuat> {
    let q = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
    (q.is_finite() && q.length_squared() > 0.0).then(|| q.normalize())
}

/// A pose; none: not all of it is finite and within reach.
pub fn pose(t: &ufbx::Transform) -> Option<Transform> {
    let (translation, scale) = (vector(t.translation), vector(t.scale));
    let near = |v: DVec3| v.is_finite() && v.abs().max_element() <= FARTHEST;
    (near(translation) && near(scale)).then_some(())?;
    Some(Transform {
        translation,
        rotation: rotation(t.rotation)?,
        scale,
    })
}

/// An affine map; none: not all of it is finite.
pub fn affine(m: &ufbx::Matrix) -> Option<DAffine3> {
    let affine = DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(m.m00, m.m10, m.m20),
            DVec3::new(m.m01, m.m11, m.m21),
            DVec3::new(m.m02, m.m12, m.m22),
        ),
        translation: DVec3::new(m.m03, m.m13, m.m23),
    };
    affine.is_finite().then_some(affine)
}

/// Linear RGB, finite and not negative.
pub fn color(v: ufbx::Vec3) -> Vec3 {
    let channel = |c: f64| (c as f32).clamp(0.0, 1e6);
    let [r, g, b] = [v.x, v.y, v.z].map(|c| if c.is_finite() { channel(c) } else { 0.0 });
    Vec3::new(r, g, b)
}
