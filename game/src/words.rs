//! Words of the command line as values, or what was expected in their place.

use std::ops::Range;
use std::str::FromStr;

use glam::UVec2;

/// Largest side of a picture in pixels.
const SIDE_LIMIT: u32 = 16_384;
/// Most frames of one command: days of work, and a list that fits into memory.
const FRAMES_LIMIT: u64 = 10_000_000;

/// Pixels across and down.
pub fn size(text: &str) -> Result<UVec2, String> {
    let expected = || format!("expected WIDTHxHEIGHT, each from 1 to {SIDE_LIMIT}, as in 1280x720");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let side = |word: &str| {
        u32::from_str(word)
            .ok()
            .filter(|side| (1..=SIDE_LIMIT).contains(side))
            .ok_or_else(expected)
    };
    Ok(UVec2::new(side(width)?, side(height)?))
}

/// A range of frame numbers, or one.
pub fn frames(text: &str) -> Result<Range<u64>, String> {
    let expected = "expected A..B with A less than B, as in 0..90, or one frame number";
    let number = |word: &str| u64::from_str(word).map_err(|_| expected.to_owned());
    let range = match text.split_once("..") {
        Some((first, end)) => number(first)?..number(end)?,
        None => {
            let only = number(text)?;
            only..only.saturating_add(1)
        }
    };
    if range.is_empty() {
        return Err(format!("there is no frame in it; {expected}"));
    }
    let count = range.end - range.start;
    if count > FRAMES_LIMIT {
        return Err(format!(
            "{count} frames are too many for one command; expected at most {FRAMES_LIMIT}"
        ));
    }
    Ok(range)
}

/// A whole number, perhaps written as 1e9.
pub fn count(text: &str) -> Result<u64, String> {
    f64::from_str(text)
        .ok()
        .filter(|n| (1.0..=1e13).contains(n) && n.fract() == 0.0)
        .map(|n| n as u64)
        .ok_or_else(|| "expected a whole number from 1 to 1e13, as in 1000000 or 1e9".to_owned())
}

/// A share of the window along an axis.
pub fn scale(text: &str) -> Result<f64, String> {
    f64::from_str(text)
        .ok()
        .filter(|scale| (0.05..=1.0).contains(scale))
        .ok_or_else(|| "expected a number from 0.05 to 1, as in 0.5".to_owned())
}

/// Milliseconds of a frame.
pub fn target_millis(text: &str) -> Result<f64, String> {
    f64::from_str(text)
        .ok()
        .filter(|millis| (1.0..=10_000.0).contains(millis))
        .ok_or_else(|| {
            "expected milliseconds from 1 to 10000, as in 16.7 for 60 frames a second".to_owned()
        })
}

/// A pixel's column and row.
pub fn pixel(text: &str) -> Result<UVec2, String> {
    let (x, y) = text.split_once(',').unwrap_or_default();
    let numbers = (u32::from_str(x.trim()), u32::from_str(y.trim()));
    match numbers {
        (Ok(x), Ok(y)) => Ok(UVec2::new(x, y)),
        _ => Err("expected a column and a row from the top left, as in 640,360".into()),
    }
}

/// Per cent.
pub fn per_cent(text: &str) -> Result<f64, String> {
    f64::from_str(text)
        .ok()
        .filter(|percent| (0.0..=10_000.0).contains(percent))
        .ok_or_else(|| "expected per cent from 0 to 10000, as in 5".to_owned())
}

/// Frame numbers a second.
pub fn frames_per_sec(text: &str) -> Result<f64, String> {
    f64::from_str(text)
        .ok()
        .filter(|fps| fps.is_finite() && *fps > 0.0)
        .ok_or_else(|| "expected a number greater than 0, as in 30 or 23.976".to_owned())
}

/// A relative difference.
pub fn contrast(text: &str) -> Result<f32, String> {
    f32::from_str(text)
        .ok()
        .filter(|contrast| (0.0..=1.0).contains(contrast))
        .ok_or_else(|| "expected a number from 0 to 1, as in 0.1".to_owned())
}

/// An error of a pixel.
pub fn cutoff(text: &str) -> Result<f32, String> {
    f32::from_str(text)
        .ok()
        .filter(|error| error.is_finite() && *error >= 0.0)
        .ok_or_else(|| "expected a number from 0 on, as in 1e-4".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_half_open() {
        assert_eq!(frames("3..7"), Ok(3..7));
        assert_eq!(frames("5"), Ok(5..6));
        for wrong in ["7..3", "3..3", "a", "1..", "..4", "-1", "1...3"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
        for too_many in ["0..10000001", "0..18446744073709551615"] {
            assert!(frames(too_many).is_err(), "{too_many}");
        }
        assert_eq!(frames("5..10000005"), Ok(5..10_000_005));
    }

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!(size("640x360"), Ok(UVec2::new(640, 360)));
        for wrong in ["640", "0x3", "3x0", "x", "640x", "99999x2", "2x2x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn counts_are_whole() {
        assert_eq!(count("1e9"), Ok(1_000_000_000));
        assert_eq!(count("20000"), Ok(20_000));
        for wrong in ["0", "-1", "1.5", "1e99", "x"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn scales_are_parts_of_one() {
        assert_eq!(scale("0.5"), Ok(0.5));
        for wrong in ["0", "1.5", "-1", "NaN", "inf", "x"] {
            assert!(scale(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn targets_are_milliseconds() {
        assert_eq!(target_millis("16.7"), Ok(16.7));
        for wrong in ["0", "-5", "1e9", "NaN", "inf", "x", "16ms"] {
            assert!(target_millis(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn cutoffs_are_errors_of_a_pixel() {
        assert_eq!(cutoff("1e-4"), Ok(1e-4));
        assert_eq!(cutoff("0"), Ok(0.0));
        for wrong in ["-1", "NaN", "inf", "x"] {
            assert!(cutoff(wrong).is_err(), "{wrong}");
        }
    }
}
