//! The benchmark `bart`: the scenes of BART, a benchmark for animated ray tracing (Lext, Assarsson and Möller, IEEE
//! Computer Graphics and Applications 21(2), 2001), played from their first frame to their last.
//!
//! The files do not come along; a scene that is not in the folder is skipped with a note.

use std::path::PathBuf;
use std::time::Instant;

use glam::UVec2;
use orrery_engine::frame::{FrameScene, Shape, TraceSettings};
use orrery_engine::present::write_png8;
use orrery_engine::profile::{Profile, percentile_of_sorted};
use orrery_engine::trace::{Counters, Picture};

use super::frame::backends;
use super::report::{Better, Report, Row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::assets::is_there;
use crate::contact_sheet::{MOMENTS, contact_sheet, halved};
use crate::defects::Defects;
use crate::failure::Failure;
use crate::output::progress;
use crate::{device, interrupt, stage};

/// Where the files are unless it is said otherwise.
const FOLDER: &str = "../shared/scenes/bart-aff";
/// Size of the pictures unless asked otherwise: the scenes' own.
const SIZE: UVec2 = UVec2::new(800, 600);
/// Of a short run.
const SMALL_SIZE: UVec2 = UVec2::new(80, 60);
/// Frames of a short run.
const SMALL_FRAMES: u64 = 8;
/// Pictures on a contact sheet.
const SHEET: u64 = 12;
/// Pictures of a sheet are not much wider.
const SHEET_WIDTH: u32 = 320;

/// A scene, and how it is played (its file's `a` statement).
struct Scene {
    name: &'static str,
    file: &'static str,
    frames: u64,
    secs: f64,
}

const SCENES: [Scene; 3] = [
    Scene {
        name: "kitchen",
        file: "kitchen/kitchen.aff",
        frames: 800,
        secs: 20.0,
    },
    Scene {
        name: "robots",
        file: "robots/Robot.aff",
        frames: 800,
        secs: 50.0,
    },
    Scene {
        name: "museum",
        file: "museum/museum5.aff",
        frames: 300,
        secs: 6.0,
    },
];

/// Plays every scene that is there on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let folder = request
        .files
        .clone()
        .unwrap_or_else(|| PathBuf::from(FOLDER));
    let there = SCENES
        .iter()
        .filter(|scene| is_there(scene.name, &folder.join(scene.file)));
    let there: Vec<&Scene> = there.collect();
    if there.is_empty() {
        return Err(Failure::Input(format!(
            "{}: none of the scenes is there; expected the folder of `kitchen`, `robots` and `museum` after `--files`",
            folder.display()
        )));
    }
    interrupt::listen();
    let (mut rows, mut devices) = (Vec::new(), Vec::new());
    let mut defects = Defects::default();
    for choice in backends(common) {
        devices.push(device::open_choice(choice, common)?.device());
        for scene in &there {
            let play = Play {
                scene,
                file: folder.join(scene.file),
                choice,
                request,
                common,
            };
            rows.extend(play.run(&mut defects)?);
        }
    }
    defects.tell();
    let size = size_of(request, common);
    Ok(Report {
        rows,
        remarks: vec![format!(
            "{}x{}, first frame to last, one at a time, each picture read back; memory: of the whole process, afterwards",
            size.x, size.y
        )],
        ..Report::new("bart", &devices)
    })
}

fn size_of(request: &BenchRequest, common: &Common) -> UVec2 {
    let size = if request.small { SMALL_SIZE } else { SIZE };
    common.size.unwrap_or(size)
}

/// One scene on one backend.
struct Play<'a> {
    scene: &'a Scene,
    file: PathBuf,
    choice: BackendChoice,
    request: &'a BenchRequest,
    common: &'a Common,
}

/// What its frames took.
#[derive(Default)]
struct Run {
    millis: Vec<f64>,
    counters: Vec<Counters>,
    sheet: Vec<Picture>,
}

impl Play<'_> {
    fn run(&self, defects: &mut Defects) -> Result<Vec<Row>, Failure> {
        let tracer = device::open_choice(self.choice, self.common)?;
        let name = format!("{}.{}", self.scene.name, tracer.backend());
        let begun = Instant::now();
        let size = size_of(self.request, self.common);
        let rate = self.scene.frames as f64 / self.scene.secs;
        let mut engine = stage::set(&self.file, self.common, size, rate)?;
        let loaded = begun.elapsed().as_secs_f64() * 1e3;
        stage::cast(&mut engine, tracer);
        engine.world.resource_mut::<TraceSettings>().count_rays = true;
        let begun = Instant::now();
        stage::picture(&mut engine, 0)?;
        let first = begun.elapsed().as_secs_f64() * 1e3;
        let frames = self.frames();
        let bar = progress(frames.len() as u64, &name);
        let every = (frames.len() as u64).div_ceil(SHEET).max(1);
        let mut run = Run::default();
        for (number, frame) in (0..).zip(frames) {
            let start = Instant::now();
            let picture = stage::picture(&mut engine, frame)?;
            run.millis.push(start.elapsed().as_secs_f64() * 1e3);
            let counters = engine.world.resource::<Profile>().counters;
            defects.add(&picture, &counters);
            run.counters.push(counters);
            if self.request.report.is_some() && number % every == 0 {
                run.sheet.push(small(picture));
            }
            bar.inc(1);
            if interrupt::asked() {
                break;
            }
        }
        bar.finish_and_clear();
        if let Some(report) = &self.request.report {
            let path = report.join(format!("{}.png", name.replace('.', "_")));
            let view = stage::view(&engine);
            write_png8(
                &path,
                &contact_sheet(&run.sheet, MOMENTS),
                view.exposure,
                view.tone_map,
            )
            .map_err(|error| Failure::Input(error.to_string()))?;
        }
        let mut rows = vec![
            Row::single(format!("{name}.load"), "ms", Better::Lower, loaded),
            Row::single(format!("{name}.first_frame"), "ms", Better::Lower, first),
        ];
        rows.extend(run.rows(&name));
        let triangles = triangles(engine.world.resource::<FrameScene>());
        rows.push(Row::single(
            format!("{name}.triangles"),
            "triangles",
            Better::Higher,
            triangles,
        ));
        rows.extend(
            memory().map(|mib| Row::single(format!("{name}.memory"), "MiB", Better::Lower, mib)),
        );
        Ok(rows)
    }

    /// All, or so many spread over the run, the first and the last among them.
    fn frames(&self) -> Vec<u64> {
        let last = self.scene.frames - 1;
        let asked = match (self.request.frames, self.request.small) {
            (Some(count), _) => count,
            (None, true) => SMALL_FRAMES,
            (None, false) => self.scene.frames,
        };
        spread(last, asked)
    }
}

/// So many numbers from 0 to the last one; no more than there are.
fn spread(last: u64, count: u64) -> Vec<u64> {
    let steps = count.saturating_sub(1).clamp(1, last.max(1));
    (0..=steps).map(|step| step * last / steps).collect()
}

impl Run {
    fn rows(&self, name: &str) -> Vec<Row> {
        let mut sorted = self.millis.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let median = percentile_of_sorted(&sorted, 0.5);
        // As the window's own figure has it: the slowest hundredth of frames.
        let slowest = &sorted[sorted.len() - sorted.len().div_ceil(100)..];
        let slow = slowest.iter().sum::<f64>() / slowest.len().max(1) as f64;
        let rate = |millis: f64| 1e3 / millis.max(1e-9);
        let of = |value: fn(&Counters) -> u64| -> Vec<f64> {
            self.counters
                .iter()
                .map(|counters| value(counters) as f64)
                .collect()
        };
        let row = |what: &str, unit, better, value| {
            Row::single(format!("{name}.{what}"), unit, better, value)
        };
        let sampled = |what: &str, unit, values: &[f64]| {
            Row::sampled(format!("{name}.{what}"), unit, Better::Lower, values)
        };
        vec![
            row("frames", "frames", Better::Higher, self.millis.len() as f64),
            sampled("frame", "ms", &self.millis),
            row("fps", "1/s", Better::Higher, rate(median)),
            row("fps_1%_low", "1/s", Better::Higher, rate(slow)),
            sampled("rays", "rays", &of(Counters::rays)),
            sampled("trees_updated", "trees", &of(|c| c.trees_updated)),
            sampled("uploaded", "bytes", &of(|c| c.bytes_uploaded)),
        ]
    }
}

/// At most a few times halved, so that sheets stay small.
fn small(mut picture: Picture) -> Picture {
    while picture.size.x > SHEET_WIDTH {
        picture = halved(&picture);
    }
    picture
}

/// Of all instances.
fn triangles(scene: &FrameScene) -> f64 {
    let meshes = scene
        .instances
        .iter()
        .filter_map(|instance| match instance.shape {
            Shape::Mesh(row) => scene.meshes.get(row as usize),
            _ => None,
        });
    meshes.map(|mesh| mesh.data.triangles.len() as f64).sum()
}

/// Resident memory of this process in MiB, where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_the_frames_has_the_first_and_the_last() {
        assert_eq!(spread(799, 3), [0, 399, 799]);
        assert_eq!(spread(2, 100), [0, 1, 2]);
        assert_eq!(spread(299, 300).len(), 300);
        assert_eq!(spread(299, 0), [0, 299]);
    }
}
