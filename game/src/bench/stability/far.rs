//! A scene looks the same wherever it is and however large: bit for bit where the numbers stay exact.

use glam::{DVec3, UVec2};
use orrery_engine::frame::{Kernels, Offset};
use orrery_engine::trace::Picture;

use super::course::Course;
use super::scenes::{mixed, moved, off, rounded, scaled, unequal};
use super::tally::Tally;
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "far";
/// Scenes.
const SCENES: u64 = 10;
/// Scenes where rays without end are asked for.
const LONG: u64 = 200;
/// Pixels of a picture.
const SIZE: UVec2 = UVec2::new(160, 120);
/// A difference that shows.
const VISIBLE: f32 = 1.0 / 255.0;
/// Whole numbers, so that sums with coordinates of scenes are exact. What POV-Ray 3.7 (f32 boxes) was measured at
/// there, in ppm.
const SHIFTS: [(&str, f64, f64); 3] = [
    ("1e4", 1e4, 6.5),
    ("1e6", 1e6, 1292.0),
    ("1e7", 1e7, 10_283.0),
];
/// Powers of two.
const EXACT: [(&str, f64); 2] = [("2^-10", 1.0 / 1024.0), ("2^12", 4096.0)];
/// Others, with POV-Ray's ppm.
const INEXACT: [(&str, f64, f64); 2] = [("1e-4", 1e-4, 127_080.0), ("1e4", 1e4, 4173.0)];

/// Runs shifts and scales.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let scenes = course.scenes(SCENES, LONG);
    let mut rows: Vec<(String, Tally, Option<f64>)> = Vec::new();
    let mut add = |name: String, pixels: u64, wrong: u64, known| {
        let more = Tally::counted(pixels, wrong);
        match rows.iter_mut().find(|row| row.0 == name) {
            Some(row) => row.1.extend(Some(more)),
            None => rows.push((name, more, known)),
        }
    };
    let pixels = u64::from(SIZE.x * SIZE.y);
    for seed in 0..scenes {
        let base = mixed(seed)?;
        let plain = look(course, &base, Kernels::default())?;
        for (word, shift, known) in SHIFTS {
            let far = moved(&base, DVec3::new(shift, -shift, shift));
            let same = unequal(&look(course, &far, Kernels::default())?, &plain);
            let f32s = look(course, &rounded(&far), Kernels::default())?;
            add(
                format!("shift_{word}.f32_positions"),
                pixels,
                off(&f32s, &plain, VISIBLE),
                Some(known),
            );
            add(format!("shift_{word}"), pixels, same, None);
        }
        for (word, factor) in EXACT {
            let other = look(course, &scaled(&base, factor), Kernels::default())?;
            add(
                format!("scale_{word}"),
                pixels,
                unequal(&other, &plain),
                None,
            );
        }
        for (word, factor, known) in INEXACT {
            let fixed = Kernels {
                offsets: Offset::Fixed,
                ..Kernels::default()
            };
            let scene = scaled(&base, factor);
            let lifted = look(course, &scene, fixed)?;
            let other = look(course, &scene, Kernels::default())?;
            add(
                format!("scale_{word}.fixed"),
                pixels,
                off(&lifted, &plain, VISIBLE),
                Some(known),
            );
            add(
                format!("scale_{word}.visible"),
                pixels,
                off(&other, &plain, VISIBLE),
                None,
            );
        }
    }
    for (word, tally, known) in rows {
        let name = format!("{NAME}.{word}");
        if known.is_some() {
            course.must_fail(&name, &tally, known);
        } else if word.ends_with("visible") {
            let ppm = tally.failed as f64 * 1e6 / tally.tried as f64;
            course.at_most(&name, "ppm", &tally, ppm, Some(20.0));
        } else {
            course.none_may_fail(&name, &tally);
        }
    }
    Ok(())
}

fn look(
    course: &mut Course,
    scene: &orrery_engine::frame::FrameScene,
    kernels: Kernels,
) -> Result<Picture, Failure> {
    course.picture(scene, SIZE, kernels)
}
