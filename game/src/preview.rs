//! Where there is no display: a preview of the scene as pictures in a folder, and a contact sheet.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::present::{FileError, write_png8};
use orrery_engine::profile::Profile;
use orrery_engine::time::Time;
use orrery_engine::trace::Picture;

use crate::args::Common;
use crate::contact_sheet::{MOMENTS, contact_sheet, halved};
use crate::defects::Defects;
use crate::failure::Failure;
use crate::output::{progress, say};
use crate::profile_log::ProfileLog;
use crate::{device, interrupt, stage};

/// Size unless asked otherwise.
const SIZE: UVec2 = UVec2::new(640, 360);
/// Seconds of the scene shown.
const SCENE_SECS: u64 = 5;
/// What everything from the start on may take, by the pace of the first pictures.
const BUDGET: Duration = Duration::from_secs(42);
/// No picture is begun that would end later, by what the last one took: the scene got heavier than its
/// first pictures. What is left of a minute is for that one being heavier still, and for the sheet.
const DEADLINE: Duration = Duration::from_secs(50);
/// A first picture that takes longer is pace enough: there is no time for a second one that is not kept.
const SLOW: Duration = Duration::from_secs(5);
/// Frame rates to choose from, smoothest first.
const RATES: [u64; 7] = [30, 15, 10, 6, 3, 2, 1];
/// Pictures on the contact sheet.
const SHEET: usize = 12;

const FOLDER: &str = "frames";

/// Renders the preview of a scene and says where it is.
pub fn run(scene: &Path, common: &Common) -> Result<(), Failure> {
    let start = Instant::now();
    let (mut engine, _) = stage::open(scene, common, SIZE, 1.0)?;
    let mut log = ProfileLog::open(common)?;
    log.watch(&mut engine);
    stage::cast(&mut engine, device::open(common)?);
    interrupt::listen();
    let size = common.size.unwrap_or(SIZE);
    remove_old_preview();
    let mut last = pace(&mut engine)?;
    let rate = affordable_rate(last, start.elapsed());
    let count = SCENE_SECS * rate;
    say(format_args!(
        "rendering {SCENE_SECS} seconds at {rate} frames a second, {}x{}, into {FOLDER}/",
        size.x, size.y
    ));
    engine.world.resource_mut::<Time>().frames_per_sec = rate as f64;
    let mut defects = Defects::default();
    let bar = progress(count, "rendering");
    let mut small = Vec::new();
    let every = (count as usize).div_ceil(SHEET).max(1);
    let mut done = 0;
    for frame in 0..count {
        let begun = Instant::now();
        // Without any picture there would be nothing to show.
        if frame > 0 && (interrupt::asked() || start.elapsed() + last > DEADLINE) {
            break;
        }
        let picture = stage::picture(&mut engine, frame)?;
        log.frame(&engine)?;
        let profile = engine.world.resource::<Profile>();
        defects.add(&picture, &profile.counters);
        write(&engine, &frame_path(frame), &picture)?;
        if (frame as usize).is_multiple_of(every) {
            small.push(halved(&picture));
        }
        bar.inc(1);
        done = frame + 1;
        last = begun.elapsed();
    }
    let sheet = Path::new(FOLDER).join("contact_sheet.png");
    write(&engine, &sheet, &contact_sheet(&small, MOMENTS))?;
    if done < count {
        bar.abandon();
        say(format_args!("stopped after {done} of {count} pictures"));
    } else {
        bar.finish_and_clear();
    }
    log.finish()?;
    defects.tell();
    say(format_args!(
        "{done} pictures: {} to {}; all at a glance: {}",
        frame_path(0).display(),
        frame_path(done.saturating_sub(1)).display(),
        sheet.display()
    ));
    Ok(())
}

/// What a picture takes, written: the second one's time, since the first also builds trees and warms up,
/// unless that one was slow already.
fn pace(engine: &mut Engine) -> Result<Duration, Failure> {
    let mut timed = |frame| -> Result<Duration, Failure> {
        let start = Instant::now();
        let picture = stage::picture(engine, frame)?;
        write(engine, &frame_path(0), &picture)?;
        Ok(start.elapsed())
    };
    let first = timed(0)?;
    if first > SLOW {
        return Ok(first);
    }
    timed(SCENE_SECS / 2)
}

/// The smoothest frame rate that fits what the budget leaves; else one frame a second.
fn affordable_rate(pace: Duration, gone: Duration) -> u64 {
    let left = BUDGET.saturating_sub(gone).as_secs_f64();
    let fits = |rate: &u64| pace.as_secs_f64() * (SCENE_SECS * rate) as f64 <= left;
    RATES.into_iter().find(fits).unwrap_or(1)
}

fn frame_path(frame: u64) -> PathBuf {
    Path::new(FOLDER).join(format!("preview_{frame:04}.png"))
}

/// Takes away what an earlier preview left, so that a shorter one does not mix with it.
fn remove_old_preview() {
    for frame in 0..SCENE_SECS * RATES[0] {
        // Not there is what is wanted; what cannot be removed will say so when it is written.
        let _ = std::fs::remove_file(frame_path(frame));
    }
}

fn write(engine: &Engine, path: &Path, picture: &Picture) -> Result<(), Failure> {
    let view = stage::view(engine);
    write_png8(path, picture, view.exposure, view.tone_map)
        .map_err(|error: FileError| Failure::Input(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_machines_get_fewer_frames() {
        let rate =
            |pace, gone| affordable_rate(Duration::from_millis(pace), Duration::from_millis(gone));
        assert_eq!(rate(10, 0), 30);
        assert_eq!(rate(500, 0), 15);
        assert_eq!(rate(500, 10_000), 10);
        assert_eq!(rate(10, 60_000), 1);
        assert_eq!(rate(100_000, 0), 1);
    }
}
