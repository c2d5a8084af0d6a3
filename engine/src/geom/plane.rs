//! Infinite planes.

use glam::{DVec3, Vec3};

/// The plane n.p = `distance` with n unit, as rays see it whose origins are relative to the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFrame {
    /// Unit.
    pub normal: DVec3,
    /// From the eye.
    pub distance: f64,
}

impl PlaneFrame {
    /// As rows of four: normal and distance, and what rounding left of them, which a device leaves out.
    pub fn rows(&self) -> [[f32; 4]; 3] {
        let exact = self.normal.extend(self.distance);
        let rounded = exact.as_vec4();
        let rest = (exact - rounded.as_dvec4()).as_vec4();
        [rounded.to_array(), rest.to_array(), [0.0; 4]]
    }

    /// Reads [`PlaneFrame::rows`].
    #[inline]
    pub fn from_rows([rounded, rest, _]: [[f32; 4]; 3]) -> Self {
        let [x, y, z, distance] =
            std::array::from_fn(|i| f64::from(rounded[i]) + f64::from(rest[i]));
        Self {
            normal: DVec3::new(x, y, z),
            distance,
        }
    }

    /// How far a point is above the plane.
    pub fn height(&self, point: Vec3) -> f32 {
        (self.normal.dot(point.as_dvec3()) - self.distance) as f32
    }

    /// In lengths of the direction, rounded once; none for a parallel ray.
    pub fn intersect(&self, origin: Vec3, dir: Vec3) -> Option<f32> {
        let along = self.normal.dot(dir.as_dvec3());
        let above = self.distance - self.normal.dot(origin.as_dvec3());
        (along as f32 != 0.0).then(|| (above / along) as f32)
    }
}
