//! Where in a pixel its samples lie: one fixed sequence, whatever asks for how many of it.
//!
//! The first point is the pixel's centre. The first 2^m points have one in each of the 2^m boxes of equal
//! area, however the pixel is divided: 1 x 4, 2 x 2 and 4 x 1 alike, a (0, 2)-sequence in base 2
//! (Sobol' 1967; Niederreiter 1987), so every beginning of it is well spread and a picture refines by taking
//! the next point. Its digits are mixed by random lower triangular matrices (Matousek 1998, "On the
//! L2-discrepancy for anchored boxes"); of some thousand, those were kept that measure straight edges at random
//! angles best with 4, 16 and 64 points.
//!
//! Twin of `sample_offset` in `shaders/shared/pixel.wgsl`. Called by all three tracers.

use super::wire::{SAMPLE_COLUMNS, SAMPLE_FIRST_CELL, SAMPLES_CAPACITY};

/// The place of a sample in its pixel, right and down from the top left corner, in pixels, exact in f32. Below
/// [`SAMPLES_CAPACITY`] no two are the same.
pub fn sample_offset(index: u32) -> [f32; 2] {
    debug_assert!(index < SAMPLES_CAPACITY, "there are no more samples");
    if index == 0 {
        return [0.5; 2];
    }
    let mut cell = SAMPLE_FIRST_CELL;
    for (bit, column) in SAMPLE_COLUMNS.iter().enumerate() {
        cell ^= column * (index >> bit & 1);
    }
    // Centres of cells of a grid of 256 x 256.
    [cell & 0xff, cell >> 8].map(|step| (step as f32 + 0.5) / 256.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn every_box_of_every_division_has_one_of_the_first_samples() {
        for m in 0..=8 {
            for across in 0..=m {
                let mut seen = vec![false; 1 << m];
                for index in 0..1 << m {
                    let [x, y] = sample_offset(index);
                    let column = (x * (1_u32 << across) as f32) as usize;
                    let row = (y * (1_u32 << (m - across)) as f32) as usize;
                    let cell = &mut seen[row << across | column];
                    assert!(!*cell, "sample {index} of 2^{m} shares its box");
                    *cell = true;
                }
            }
        }
    }

    #[test]
    fn the_first_sample_is_the_centre_and_powers_of_four_are_about_it() {
        assert_eq!(sample_offset(0), [0.5; 2]);
        for (count, most) in [(4_u32, 0.04), (16, 0.01), (64, 0.005), (256, 1e-4)] {
            let sum = (0..count).map(sample_offset).fold([0.0; 2], |sum, at| {
                [sum[0] + f64::from(at[0]), sum[1] + f64::from(at[1])]
            });
            let off = sum.map(|sum| (sum / f64::from(count) - 0.5).abs());
            assert!(off[0] <= most && off[1] <= most, "{count}: {off:?}");
        }
    }

    /// Straight edges through a pixel at random: the mean of samples against the area to one side.
    #[test]
    fn samples_measure_edges_better_the_more_they_are() {
        let mut random = Random::new(7);
        let counts = [1, 4, 16, 64, 256];
        let mut errors = [0.0; 5];
        for _ in 0..2000 {
            let (sin, cos) = (random.unit() * std::f64::consts::TAU).sin_cos();
            let (a, b) = (cos.abs(), sin.abs());
            let along = random.unit() * (a + b);
            let part = |s: f64| s.max(0.0).powi(2);
            let both = part(along) - part(along - a) - part(along - b) + part(along - a - b);
            let area = both / (2.0 * a * b).max(1e-12);
            for (error, count) in errors.iter_mut().zip(counts) {
                let inside = (0..count).filter(|&index| {
                    let [x, y] = sample_offset(index).map(|at| f64::from(at) - 0.5);
                    x * cos + y * sin < along - (a + b) / 2.0
                });
                *error += (inside.count() as f64 / f64::from(count) - area).powi(2) / 2000.0;
            }
        }
        for pair in errors.windows(2) {
            assert!(pair[1] < pair[0] / 4.0, "{errors:?}");
        }
    }
}
