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

    /// Pixels with a channel that is infinite or not a number: a picture that is right has none. Files and
    /// screens show them as white or black without a word, so whoever writes one asks here.
    pub fn non_finite(&self) -> usize {
        let odd = |pixel: &&Vec3| !pixel.is_finite();
        self.pixels.iter().filter(odd).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_that_are_no_light_are_counted_once() {
        let mut picture = Picture::new(UVec2::new(3, 2));
        assert_eq!(picture.non_finite(), 0);
        picture.pixels[1] = Vec3::NAN;
        picture.pixels[3] = Vec3::new(0.5, f32::INFINITY, f32::NAN);
        picture.pixels[5] = Vec3::new(f32::MAX, -1.0, 0.0);
        assert_eq!(picture.non_finite(), 2);
    }
}
