//! Whole frames of a scene under each structure, and that the picture is the same under all.

use std::time::Instant;

use glam::Vec3;
use orrery_engine::trace::Picture;
use orrery_engine::world::{Background, Structure};

use super::stages::Stage;
use crate::args::{BackendChoice, Common};
use crate::bench::report::Row;
use crate::bench::timing::{millis_row, zero_row};
use crate::failure::Failure;
use crate::output::progress;
use crate::{device, stage};

/// Frames before the clock counts.
const WARM_UP: usize = 2;
/// What is added to the background every other frame, so that there is something to trace.
const NUDGE: f32 = 1e-6;

/// One backend, these structures.
pub fn rows(
    scene: &Stage,
    structures: impl Iterator<Item = (&'static str, Structure)>,
    choice: BackendChoice,
    samples: usize,
    common: &Common,
) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    let mut pictures: Vec<(&str, Picture)> = Vec::new();
    for (word, structure) in structures {
        let mut engine = scene.engine(structure, common)?;
        let tracer = device::open_choice(choice, common)?;
        let backend = tracer.backend();
        stage::cast(&mut engine, tracer);
        let name = format!("{}.{word}", scene.name);
        let bar = progress(samples as u64, &name);
        let still = engine.world.resource::<Background>().horizon;
        let mut millis = Vec::with_capacity(samples);
        let mut last = None;
        // Counting down, so that the last frame has the scene's own background.
        for i in (0..WARM_UP + samples).rev() {
            let nudge = if i % 2 == 0 { 0.0 } else { NUDGE };
            *engine.world.resource_mut::<Background>() = (still + Vec3::splat(nudge)).into();
            let start = Instant::now();
            last = Some(scene.picture(&mut engine)?);
            if i < samples {
                millis.push(start.elapsed().as_secs_f64() * 1e3);
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        rows.push(millis_row(format!("{name}.{backend}.frame"), &millis));
        pictures.extend(last.map(|picture| (word, picture)));
    }
    let Some((_, right)) = pictures.last() else {
        return Ok(rows);
    };
    let proofs = pictures.iter().map(|(word, picture)| {
        let pairs = picture.pixels.iter().zip(&right.pixels);
        let wrong = pairs.filter(|(a, b)| a != b).count() as u64;
        let name = format!("{}.{word}.{choice:?}.wrong", scene.name).to_lowercase();
        zero_row(name, "pixels", wrong)
    });
    rows.extend(proofs);
    Ok(rows)
}
