//! Affine maps as f32 rows, the form in which instances reach the tracers.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};

/// A 3x4 matrix by rows: `p'[i] = dot(row[i].xyz, p) + row[i].w.`
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct AffineRows(pub [[f32; 4]; 3]);

impl AffineRows {
    /// Maps everything to the origin.
    pub const ZERO: Self = Self([[0.0; 4]; 3]);

    /// Rounds a map.
    pub fn new(map: DAffine3) -> Self {
        let m = map.matrix3.transpose();
        let row = |r: DVec3, t: f64| [r.x as f32, r.y as f32, r.z as f32, t as f32];
        let t = map.translation;
        Self([row(m.x_axis, t.x), row(m.y_axis, t.y), row(m.z_axis, t.z)])
    }

    /// Replaces the translation, rounded.
    pub fn set_translation(&mut self, t: DVec3) {
        for (row, t) in self.0.iter_mut().zip(t.as_vec3().to_array()) {
            row[3] = t;
        }
    }

    /// Applies f to each row's linear part and its translation.
    #[inline]
    fn map(&self, f: impl Fn(Vec3, f32) -> f32) -> Vec3 {
        Vec3::from(self.0.map(|[x, y, z, w]| f(Vec3::new(x, y, z), w)))
    }

    /// M p + t.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.map(|row, t| row.dot(p) + t)
    }

    /// M v.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.map(|row, _| row.dot(v))
    }

    /// Transpose(M) n: a normal carried from the image of this map back to its source's dual, as the
    /// inverse transpose asks.
    #[inline]
    pub fn transposed_vector(&self, n: Vec3) -> Vec3 {
        let [x, y, z] = self.0.map(|[x, y, z, _]| Vec3::new(x, y, z));
        x * n.x + y * n.y + z * n.z
    }

    /// |M| v, entries' absolute values.
    #[inline]
    pub fn abs_linear(&self, v: Vec3) -> Vec3 {
        self.map(|row, _| row.abs().dot(v))
    }

    /// t.
    #[inline]
    pub fn translation(&self) -> Vec3 {
        self.map(|_, t| t)
    }
}
