//! Differences between linear pictures, as `compare.py` of the ground-truth set computes them.
//!
//! The size of a difference is per pixel: the largest over the channels of |test - reference|. A pixel is
//! off (a mismatch) when that exceeds one step of an 8-bit display, 1/255.

use glam::{DVec3, UVec2};
use orrery_engine::profile::percentile_of_sorted;
use orrery_engine::trace::Picture;

/// A difference a display of 8 bit shows.
pub const MISMATCH: f64 = 1.0 / 255.0;
/// A step of a 16-bit file.
pub const QUANTUM: f64 = 1.0 / 65535.0;
/// A step between neighbouring pixels of the reference that counts as a discontinuity.
const EDGE_STEP: f64 = 0.02;

/// A picture as numbers to be compared: linear RGB, the top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Across and down.
    pub size: UVec2,
    /// `size.x * size.y` values.
    pub rgb: Vec<DVec3>,
}

impl Pixels {
    /// A traced picture as it is.
    pub fn of(picture: &Picture) -> Self {
        Self {
            size: picture.size,
            rgb: picture.pixels.iter().map(|p| p.as_dvec3()).collect(),
        }
    }

    /// A traced picture as a 16-bit file keeps it: clipped to [0, 1], rounded to nearest; what is not
    /// finite stays so, to be counted.
    pub fn of_16_bit(picture: &Picture) -> Self {
        let quantise = |p: &glam::Vec3| {
            let p = p.as_dvec3();
            if p.is_finite() {
                (p.clamp(DVec3::ZERO, DVec3::ONE) * 65535.0).round() / 65535.0
            } else {
                p
            }
        };
        Self {
            size: picture.size,
            rgb: picture.pixels.iter().map(quantise).collect(),
        }
    }

    /// Reads a PNG file's values as linear light.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub fn read_png(path: &std::path::Path) -> Result<Self, String> {
        let picture = image::open(path)
            .map_err(|error| format!("{}: {error}", path.display()))?
            .into_rgb16();
        Ok(Self {
            size: UVec2::new(picture.width(), picture.height()),
            rgb: picture
                .pixels()
                .map(|p| DVec3::from(p.0.map(f64::from)) / 65535.0)
                .collect(),
        })
    }

    /// Every `step`-th value across and down, beginning with the middle of the first block. For odd
    /// steps that divide the size these are the pixel centres of the picture at a `step`-th of the size.
    pub fn every(&self, step: u32) -> Self {
        let size = self.size / step;
        let rgb = pixels_of(size)
            .map(|p| self.rgb[index(self.size, p * step + step / 2)])
            .collect();
        Self { size, rgb }
    }
}

/// What [`compare`] finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Pixels compared.
    pub pixels: usize,
    /// Pixels that are infinite or NaN in the tested picture.
    pub non_finite: usize,
    /// Mismatches per million pixels.
    pub mismatch_ppm: f64,
    /// Mismatches away from discontinuities of the reference.
    pub mismatch_flat: usize,
    /// The difference that 99.9 % of pixels do not exceed.
    pub p999: f64,
    /// The same away from discontinuities.
    pub p999_flat: f64,
    /// The largest difference.
    pub max: f64,
    /// Mean of (test - reference)^2 / (reference^2 + 0.01) over pixels and channels.
    pub relative_mse: f64,
}

/// Compares `test` with `reference`, leaving out what lies in `ambiguous` pixels; `edges` is
/// [`edge_mask`] of the reference.
///
/// # Panics
/// If the sizes differ.
pub fn compare(test: &Pixels, reference: &Pixels, edges: &[bool], ambiguous: &[UVec2]) -> Metrics {
    assert_eq!(
        test.size, reference.size,
        "sizes of test and reference picture"
    );
    let mut test = test.rgb.clone();
    for &pixel in ambiguous {
        let i = index(reference.size, pixel);
        test[i] = reference.rgb[i];
    }
    let non_finite = test.iter().filter(|p| !p.is_finite()).count();
    let finite = |p: &DVec3| {
        let channel = |c: f64| {
            if c.is_finite() {
                c.clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        DVec3::new(channel(p.x), channel(p.y), channel(p.z))
    };
    let (mut all, mut flat) = (Vec::with_capacity(test.len()), Vec::new());
    let mut relative = 0.0;
    for ((t, r), &edge) in test.iter().map(finite).zip(&reference.rgb).zip(edges) {
        let difference = t - *r;
        let error = difference.abs().max_element();
        relative += (difference * difference / (r * r + 0.01)).element_sum();
        all.push(error);
        if !edge {
            flat.push(error);
        }
    }
    all.sort_unstable_by(f64::total_cmp);
    flat.sort_unstable_by(f64::total_cmp);
    let mismatches = |sorted: &[f64]| sorted.len() - sorted.partition_point(|&e| e <= MISMATCH);
    let pixels = all.len();
    Metrics {
        pixels,
        non_finite,
        mismatch_ppm: mismatches(&all) as f64 * 1e6 / pixels.max(1) as f64,
        mismatch_flat: mismatches(&flat),
        p999: percentile_of_sorted(&all, 0.999),
        p999_flat: percentile_of_sorted(&flat, 0.999),
        max: all.last().copied().unwrap_or(0.0),
        relative_mse: relative / (3 * pixels.max(1)) as f64,
    }
}

/// Compares two traced pictures with one another, the second as the reference.
pub fn compare_pictures(test: &Picture, reference: &Picture) -> Metrics {
    let reference = Pixels::of(reference);
    let clipped = Pixels {
        size: reference.size,
        rgb: reference
            .rgb
            .iter()
            .map(|p| p.clamp(DVec3::ZERO, DVec3::ONE))
            .collect(),
    };
    compare(&Pixels::of(test), &clipped, &edge_mask(&clipped), &[])
}

/// Pixels within one pixel of a discontinuity: a silhouette, a shadow's edge, a crease.
pub fn edge_mask(reference: &Pixels) -> Vec<bool> {
    let size = reference.size;
    let mut near = vec![false; reference.rgb.len()];
    for p in pixels_of(size) {
        for next in [p + UVec2::X, p + UVec2::Y] {
            if next.cmplt(size).all() {
                let (a, b) = (index(size, p), index(size, next));
                let step = (reference.rgb[b] - reference.rgb[a]).abs().max_element();
                if step > EDGE_STEP {
                    near[a] = true;
                    near[b] = true;
                }
            }
        }
    }
    let mut grown = near.clone();
    for p in pixels_of(size).filter(|&p| near[index(size, p)]) {
        for neighbour in [
            p.wrapping_sub(UVec2::X),
            p.wrapping_sub(UVec2::Y),
            p + UVec2::X,
            p + UVec2::Y,
        ] {
            if neighbour.cmplt(size).all() {
                grown[index(size, neighbour)] = true;
            }
        }
    }
    grown
}

/// The edge mask of every `step`-th pixel; see [`Pixels::every`].
pub fn every_edge(edges: &[bool], size: UVec2, step: u32) -> Vec<bool> {
    pixels_of(size / step)
        .map(|p| edges[index(size, p * step + step / 2)])
        .collect()
}

/// Pixels that show the background: where a closed scene leaks.
pub fn leaks(test: &Pixels, background: DVec3) -> usize {
    let is_background = |p: &&DVec3| (**p - background).abs().max_element() < 0.05;
    test.rgb.iter().filter(is_background).count()
}

fn pixels_of(size: UVec2) -> impl Iterator<Item = UVec2> {
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
}

fn index(size: UVec2, pixel: UVec2) -> usize {
    pixel.y as usize * size.x as usize + pixel.x as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: UVec2, value: impl Fn(UVec2) -> f64) -> Pixels {
        Pixels {
            size,
            rgb: pixels_of(size).map(|p| DVec3::splat(value(p))).collect(),
        }
    }

    #[test]
    fn one_wrong_pixel_is_one_mismatch() {
        let size = UVec2::new(10, 10);
        let reference = grey(size, |_| 0.5);
        let mut test = reference.clone();
        test.rgb[37].y += 0.01;
        let edges = edge_mask(&reference);
        let m = compare(&test, &reference, &edges, &[]);
        assert_eq!((m.mismatch_ppm, m.mismatch_flat), (10_000.0, 1));
        assert!((m.max - 0.01).abs() < 1e-12);
        let expected = 0.01 * 0.01 / 0.26 / 300.0;
        assert!((m.relative_mse - expected).abs() < 1e-15);
        let spared = compare(&test, &reference, &edges, &[UVec2::new(7, 3)]);
        assert_eq!((spared.mismatch_ppm, spared.max), (0.0, 0.0));
    }

    #[test]
    fn not_a_number_is_counted_and_compared_as_black() {
        let size = UVec2::new(4, 1);
        let reference = grey(size, |_| 0.25);
        let mut test = reference.clone();
        test.rgb[1] = DVec3::NAN;
        let m = compare(&test, &reference, &edge_mask(&reference), &[]);
        assert_eq!((m.non_finite, m.mismatch_flat, m.max), (1, 1, 0.25));
    }

    #[test]
    fn edges_are_two_pixels_wide_on_either_side() {
        let size = UVec2::new(10, 5);
        let mask = edge_mask(&grey(size, |p| f64::from(p.x / 5)));
        let row: Vec<u32> = (0..10).filter(|&x| mask[20 + x as usize]).collect();
        assert_eq!(row, [3, 4, 5, 6]);
    }

    #[test]
    fn every_third_pixel_is_the_block_centre() {
        let picture = grey(UVec2::new(9, 6), |p| f64::from(p.x + 100 * p.y));
        let small = picture.every(3);
        assert_eq!(small.size, UVec2::new(3, 2));
        let values: Vec<f64> = small.rgb.iter().map(|p| p.x).collect();
        assert_eq!(values, [101.0, 104.0, 107.0, 401.0, 404.0, 407.0]);
    }
}
