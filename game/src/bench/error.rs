//! The error bar: how far a picture is from the f64 reference's.

use glam::Vec3;
use orrery_engine::profile::percentile_of_sorted;
use orrery_engine::trace::Picture;

/// Distance between two pictures of one size, as a display would show them: clipped to [0, 1], linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureError {
    /// Pixels off by more than 1/255 in some channel, per million.
    pub mismatch_ppm: f64,
    /// The largest channel difference that 99.9 % of pixels do not exceed.
    pub p999: f64,
}

impl PictureError {
    /// Measures `test` against `reference`. What is not finite counts as fully wrong.
    pub fn of(test: &Picture, reference: &Picture) -> Self {
        let clip = |p: &Vec3| p.clamp(Vec3::ZERO, Vec3::ONE);
        let mut errors: Vec<f64> = test
            .pixels
            .iter()
            .zip(&reference.pixels)
            .map(|(t, r)| {
                if t.is_finite() {
                    f64::from((clip(t) - clip(r)).abs().max_element())
                } else {
                    1.0
                }
            })
            .collect();
        errors.sort_unstable_by(f64::total_cmp);
        let off = errors.len() - errors.partition_point(|&e| e <= 1.0 / 255.0);
        Self {
            mismatch_ppm: off as f64 * 1e6 / errors.len().max(1) as f64,
            p999: percentile_of_sorted(&errors, 0.999),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn wrong_and_broken_pixels_count() {
        let reference = Picture::new(UVec2::new(10, 10));
        let mut test = reference.clone();
        test.pixels[3] = Vec3::splat(0.01);
        test.pixels[4] = Vec3::splat(f32::NAN);
        test.pixels[5] = Vec3::splat(0.001);
        let error = PictureError::of(&test, &reference);
        assert_eq!(error.mismatch_ppm, 20_000.0);
    }

    #[test]
    fn what_a_display_clips_is_no_error() {
        let mut bright = Picture::new(UVec2::ONE);
        bright.pixels[0] = Vec3::splat(7.0);
        let mut white = bright.clone();
        white.pixels[0] = Vec3::ONE;
        assert_eq!(PictureError::of(&bright, &white).mismatch_ppm, 0.0);
    }
}
