//! A point of a solid in the solid's own space, moved onto it.

use glam::Vec3;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidPoint {
    /// Where.
    pub at: Vec3,
    /// Outward, of any length.
    pub normal: Vec3,
    /// Sizes of the numbers that `at` was rounded from, axis by axis.
    pub roundings: Vec3,
}

impl SolidPoint {
    /// One that is rounded from nothing larger than itself.
    pub fn on(at: Vec3, normal: Vec3) -> Self {
        Self {
            at,
            normal,
            roundings: at.abs(),
        }
    }
}
