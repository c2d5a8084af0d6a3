//! A picture on the host: linear RGB, row by row from the top.

use glam::{UVec2, Vec3};

/// Linear RGB, unclamped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: UVec2,
    /// `size.x * size.y` pixels, the top row first.
    pub pixels: Vec<Vec3>,
}

impl Picture {
    /// A black picture.
    pub fn new(size: UVec2) -> Self {
        Self {
            size,
            pixels: vec![Vec3::ZERO; size.x as usize * size.y as usize],
        }
    }
}
