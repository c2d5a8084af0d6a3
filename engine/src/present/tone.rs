//! Scene light to display light: exposure, tone curve, sRGB encoding. Twin of `shaders/present.wgsl`.
//!
//! Sources: Reinhard et al., "Photographic Tone Reproduction for Digital Images" (2002), eq. 3; Narkowicz,
//! "ACES Filmic Tone Mapping Curve" (2015); IEC 61966-2-1 (sRGB). Tone mapping is what the 2008 report
//! left as future work.

use glam::Vec3;

use crate::world::ToneMap;

/// Rec. 709 luminance of linear RGB.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Above every display: keeps infinite light finite, so that no curve meets infinity over infinity.
const BRIGHTEST: f32 = 1.0e6;

/// Linear display light in [0, 1] of linear scene light; `exposure` in stops. NaN becomes black.
pub fn display_rgb(pixel: Vec3, exposure: f32, tone: ToneMap) -> Vec3 {
    let light = (pixel * exposure.exp2())
        .max(Vec3::ZERO)
        .min(Vec3::splat(BRIGHTEST));
    let mapped = match tone {
        ToneMap::Clip => light,
        ToneMap::Reinhard => light / (1.0 + light.dot(LUMINANCE)),
        ToneMap::Filmic => light.map(filmic),
    };
    mapped.clamp(Vec3::ZERO, Vec3::ONE)
}

/// The rational fit of the ACES reference by Narkowicz (2015).
fn filmic(x: f32) -> f32 {
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The sRGB transfer curve on one channel in [0, 1].
pub fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// The 8-bit sRGB pixel a display gets, rounded to nearest; `exposure` in stops.
pub fn display_rgb8(pixel: Vec3, exposure: f32, tone: ToneMap) -> [u8; 3] {
    let display = display_rgb(pixel, exposure, tone);
    display
        .to_array()
        .map(|channel| (srgb_from_linear(channel) * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONES: [ToneMap; 3] = [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic];

    #[test]
    fn known_values_of_the_plain_picture() {
        let gray = |x| display_rgb8(Vec3::splat(x), 0.0, ToneMap::Clip)[0];
        // sRGB of 0.5 is 0.7354, of 0.18 is 0.4613 (IEC 61966-2-1).
        assert_eq!(
            [gray(0.0), gray(0.18), gray(0.5), gray(1.0), gray(7.0)],
            [0, 118, 188, 255, 255]
        );
    }

    #[test]
    fn a_stop_doubles_the_light() {
        for tone in TONES {
            let once = display_rgb(Vec3::new(0.2, 0.1, 0.3), 1.0, tone);
            let twice = display_rgb(Vec3::new(0.4, 0.2, 0.6), 0.0, tone);
            assert!(once.abs_diff_eq(twice, 1e-6), "{tone:?}: {once} != {twice}");
        }
    }

    #[test]
    fn curves_never_fall_and_stay_in_range() {
        for tone in TONES {
            let mut last = 0.0;
            for step in 0..2000 {
                let shown = display_rgb(Vec3::splat(step as f32 * 0.01), 0.0, tone).x;
                assert!(
                    shown >= last && shown <= 1.0,
                    "{tone:?} at {step}: {shown} after {last}"
                );
                last = shown;
            }
        }
    }

    #[test]
    fn light_that_is_not_a_number_is_shown_as_one() {
        for tone in TONES {
            assert_eq!(display_rgb8(Vec3::NAN, 0.0, tone), [0; 3], "{tone:?}");
            let infinite = display_rgb8(Vec3::INFINITY, 0.0, tone);
            assert!(infinite.iter().all(|&c| c >= 180), "{tone:?}: {infinite:?}");
            assert_eq!(
                display_rgb8(Vec3::NEG_INFINITY, 0.0, tone),
                [0; 3],
                "{tone:?}"
            );
        }
    }
}
