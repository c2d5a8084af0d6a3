//! How far a picture is from what is true: the error bar of every figure.

use glam::Vec3;

use super::percentile_of_sorted;
use crate::trace::Picture;

/// Distance between two pictures of one size, as a display would show them: clipped to [0, 1], linear light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureError {
    /// Pixels off by more than 1/255 in some channel, per million: what is seen in the wrong place.
    pub mismatch_ppm: f64,
    /// The largest channel difference that 99.9 % of pixels do not exceed.
    pub p999: f64,
    /// The largest channel difference.
    pub max: f64,
    /// Mean of (test - true)^2 / (true^2 + 0.01) over pixels and channels.
    pub relative_mse: f64,
}

impl PictureError {
    /// Measures `test` against `truth`. What is not finite counts as fully wrong.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn of(test: &Picture, truth: &Picture) -> Self {
        assert_eq!(test.size, truth.size, "sizes of the pictures compared");
        let clip = |p: Vec3| p.clamp(Vec3::ZERO, Vec3::ONE).as_dvec3();
        let mut squares = 0.0;
        let mut errors: Vec<f64> = Vec::with_capacity(test.pixels.len());
        for (&found, &expected) in test.pixels.iter().zip(&truth.pixels) {
            let expected = clip(expected);
            let off = if found.is_finite() {
                clip(found) - expected
            } else {
                glam::DVec3::ONE
            };
            squares += (off * off / (expected * expected + 0.01)).element_sum();
            errors.push(off.abs().max_element());
        }
        errors.sort_unstable_by(f64::total_cmp);
        let count = errors.len().max(1) as f64;
        let wrong = errors.len() - errors.partition_point(|&e| e <= 1.0 / 255.0);
        Self {
            mismatch_ppm: wrong as f64 * 1e6 / count,
            p999: percentile_of_sorted(&errors, 0.999),
            max: errors.last().copied().unwrap_or(0.0),
            relative_mse: squares / (3.0 * count),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn wrong_and_broken_pixels_count() {
        let truth = Picture::new(UVec2::new(10, 10));
        let mut test = truth.clone();
        test.pixels[3] = Vec3::splat(0.01);
        test.pixels[4] = Vec3::splat(f32::NAN);
        test.pixels[5] = Vec3::splat(0.001);
        let error = PictureError::of(&test, &truth);
        assert_eq!((error.mismatch_ppm, error.max), (20_000.0, 1.0));
        let expected = (1.0 + 1e-4 + 1e-6) / 0.01 / 100.0;
        assert!((error.relative_mse / expected - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_a_display_clips_is_no_error() {
        let mut bright = Picture::new(UVec2::ONE);
        bright.pixels[0] = Vec3::splat(7.0);
        let mut white = bright.clone();
        white.pixels[0] = Vec3::ONE;
        assert_eq!(PictureError::of(&bright, &white), PictureError::default());
    }
}
