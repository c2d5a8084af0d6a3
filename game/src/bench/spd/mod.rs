//! The benchmark `spd`: the Standard Procedural Databases (Haines, "A Proposal for Standard Graphics Environments",
//! IEEE Computer Graphics and Applications 7(11), 1987), whose rays by kind are published.
//!
//! The files do not come along; a scene that is not in the folder is skipped with a note.

mod published;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::present::{read_png8, write_png8};
use orrery_engine::profile::PictureError;
use orrery_engine::trace::{Picture, Query, Tracer};
use orrery_engine::world::ToneMap;

use super::frame::backends;
use super::rays::primary_rays;
use super::report::{Better, Report, Row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::assets::is_there;
use crate::contact_sheet::contact_sheet;
use crate::failure::Failure;
use crate::output::{note, progress};
use crate::stage::traced;
use crate::{device, stage};

use published::{DEPTH, EYE_RAYS, KINDS, Kind, Published, SCENES, TOLERANCE, percent_off};

/// Where the files are unless it is said otherwise.
const FOLDER: &str = "../shared/scenes/spd-nff";
/// Eye rays across and down.
const SIZE: UVec2 = UVec2::splat(513);
/// Of a short run.
const SMALL_SIZE: UVec2 = UVec2::splat(65);
/// What the reference's picture of a scene may take.
const REFERENCE_BUDGET: Duration = Duration::from_secs(20);
/// The picture's size over those that are tried for it.
const DIVISORS: [u32; 5] = [1, 2, 4, 8, 16];
/// Pictures that a time is the median of.
const PICTURES: usize = 5;
/// Ends the names of rows that say how far a count is off.
const OFF: &str = "off";
/// How the rows call what is judged: all generations, and the first two.
const JUDGED: [&str; 2] = ["all", "first_bounce"];
/// Generations that a first bounce takes.
const FIRST_BOUNCE: u32 = 2;
/// Pixels that may differ from the reference's by more than 1/255, per million.
const MISMATCH: f64 = 20.0;
/// The same where rays go through glass.
const MISMATCH_IN_GLASS: f64 = 500.0;

/// Whether a row of that name must be as it should: the published counts.
pub fn must_be_met(row: &str) -> bool {
    row.ends_with(OFF)
}

/// Traces every scene that is there on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let folder = request
        .files
        .clone()
        .unwrap_or_else(|| PathBuf::from(FOLDER));
    let settings = settings(request, common);
    let mut tracers: Vec<Box<dyn Tracer>> = Vec::new();
    for choice in backends(common) {
        tracers.push(device::open_choice(choice, common)?);
    }
    let devices: Vec<String> = tracers.iter().map(|tracer| tracer.device()).collect();
    let mut reference = device::open_choice(BackendChoice::Reference, common)?;
    let there = SCENES
        .iter()
        .filter(|scene| is_there(scene.name, &file_of(&folder, scene)));
    let there: Vec<&Published> = there.collect();
    if there.is_empty() {
        return Err(Failure::Input(format!(
            "{}: none of the scenes is there; expected the folder of `balls_s4.nff` and the others after `--files`",
            folder.display()
        )));
    }
    let bar = progress((there.len() * (1 + tracers.len())) as u64, "spd");
    let (mut rows, mut sheet) = (Vec::new(), Vec::new());
    for scene in there {
        bar.set_message(scene.name);
        let frame = frame_of(&file_of(&folder, scene), common, &settings)?;
        let truths = Truth::all(reference.as_mut(), &frame, &settings)?;
        bar.inc(1);
        for tracer in &mut tracers {
            let (picture, counts) = traced_and_counted(tracer.as_mut(), &frame, &settings)?;
            let backend = tracer.backend();
            let name = format!("{}.{backend}", scene.name);
            rows.extend(count_rows(&name, scene, counts, settings.size));
            for (truth, what) in truths.iter().zip(JUDGED) {
                let judged = traced(tracer.as_mut(), &truth.frame, &truth.settings)?;
                rows.extend(error_rows(&format!("{name}.{what}"), scene, &judged, truth));
            }
            rows.push(time_row(&name, tracer.as_mut(), &frame, &settings)?);
            if let Some(report) = &request.report {
                let path = report.join(format!("{}_{backend}.png", scene.name));
                write(&path, &picture)?;
            }
            sheet.push(picture);
            bar.inc(1);
        }
        if request.report.is_some() {
            let nothing = || Picture::new(settings.size);
            sheet.push(authors_picture(&folder, scene).unwrap_or_else(nothing));
        }
    }
    bar.finish_and_clear();
    if let Some(report) = &request.report {
        // A scene a row: each tracer's picture, and the author's.
        let columns = tracers.len() as u32 + 1;
        write(&report.join("spd.png"), &contact_sheet(&sheet, columns))?;
    }
    Ok(Report {
        rows,
        remarks: remarks(&settings),
        ..Report::new("spd", &devices)
    })
}

fn settings(request: &BenchRequest, common: &Common) -> TraceSettings {
    let size = if request.small { SMALL_SIZE } else { SIZE };
    TraceSettings {
        max_generations: Some(common.depth.unwrap_or(DEPTH)),
        ..stage::settings(common, size)
    }
}

fn remarks(settings: &TraceSettings) -> Vec<String> {
    let size = settings.size;
    let eye_rays = u64::from(size.x) * u64::from(size.y);
    let mut remarks = vec![format!(
        "{}x{}, {} generations; `off`: how far a count is off the published one, which may be {TOLERANCE} %",
        size.x,
        size.y,
        settings.max_generations.unwrap_or(DEPTH)
    )];
    if eye_rays != EYE_RAYS {
        remarks.push(format!(
            "published counts are of {EYE_RAYS} eye rays and taken in proportion to {eye_rays}"
        ));
    }
    remarks
}

fn file_of(folder: &Path, scene: &Published) -> PathBuf {
    folder.join(format!("{}_s{}.nff", scene.name, scene.size))
}

fn frame_of(file: &Path, common: &Common, settings: &TraceSettings) -> Result<FrameScene, Failure> {
    let mut engine = stage::set(file, common, settings.size, 1.0)?;
    engine.world.insert_resource(*settings);
    stage::advance(&mut engine, 0)?;
    Ok(engine.world.resource::<FrameScene>().clone())
}

/// A picture of the reference.
struct Truth {
    frame: FrameScene,
    settings: TraceSettings,
    picture: Picture,
}

impl Truth {
    /// Pictures of all generations and of the first two, as large as time allows: the reference takes its time.
    fn all(
        reference: &mut dyn Tracer,
        frame: &FrameScene,
        settings: &TraceSettings,
    ) -> Result<[Self; 2], Failure> {
        let begun = Instant::now();
        let smallest = settings.size / DIVISORS[DIVISORS.len() - 1];
        traced(reference, frame, &at(smallest, settings))?;
        let a_pixel = begun.elapsed().as_secs_f64() / f64::from(smallest.element_product().max(1));
        let fits = |size: &UVec2| {
            f64::from(size.element_product()) * a_pixel <= REFERENCE_BUDGET.as_secs_f64()
        };
        let sizes = DIVISORS.map(|divisor| settings.size / divisor);
        let size = sizes.into_iter().find(fits).unwrap_or(smallest);
        let settings = at(size, settings);
        let one_bounce = FrameScene {
            max_generations: frame.max_generations.min(FIRST_BOUNCE),
            ..frame.clone()
        };
        let mut of = |frame: FrameScene| {
            let picture = traced(reference, &frame, &settings)?;
            Ok::<_, Failure>(Self {
                frame,
                settings,
                picture,
            })
        };
        Ok([of(frame.clone())?, of(one_bounce)?])
    }
}

fn at(size: UVec2, settings: &TraceSettings) -> TraceSettings {
    TraceSettings {
        size: size.max(UVec2::ONE),
        ..*settings
    }
}

/// The picture, and its rays by kind as they are published.
fn traced_and_counted(
    tracer: &mut dyn Tracer,
    frame: &FrameScene,
    settings: &TraceSettings,
) -> Result<(Picture, [u64; 4]), Failure> {
    let counting = TraceSettings {
        count_rays: true,
        ..*settings
    };
    let picture = traced(tracer, frame, &counting)?;
    let counters = tracer.counters();
    let eye_rays = primary_rays(&frame.view, settings.size);
    let hits = tracer.intersect(&eye_rays, Query::Closest)?;
    let hits = hits.iter().filter(|hit| hit.instance != u32::MAX).count();
    let counts = [
        hits as u64,
        counters.reflected_rays,
        counters.refracted_rays,
        counters.shadow_rays,
    ];
    Ok((picture, counts))
}

fn count_rows(name: &str, scene: &Published, counts: [u64; 4], size: UVec2) -> Vec<Row> {
    let share = f64::from(size.x) * f64::from(size.y) / EYE_RAYS as f64;
    let kinds = KINDS.iter().zip(counts).zip(scene.rays);
    kinds
        .flat_map(|((kind, count), published)| {
            let published = published as f64 * share;
            let row = |what: &str, unit, value| {
                let name = format!("{name}.{kind}{what}");
                Row::single(name, unit, Better::Lower, value)
            };
            let off = percent_off(count as f64, published);
            [
                row("", "rays", count as f64),
                row(".published", "rays", published),
                row(&format!(".{OFF}"), "%", off).with_target(TOLERANCE),
            ]
        })
        .collect()
}

fn error_rows(name: &str, scene: &Published, picture: &Picture, truth: &Truth) -> [Row; 3] {
    let error = PictureError::of(picture, &truth.picture);
    let row =
        |what: &str, unit, value| Row::single(format!("{name}.{what}"), unit, Better::Lower, value);
    let mismatch = row("mismatch", "ppm", error.mismatch_ppm);
    let is_first_bounce = truth.frame.max_generations <= FIRST_BOUNCE;
    let mismatch = match scene.kind {
        Kind::CurvedMirrors if !is_first_bounce => mismatch,
        Kind::CurvedMirrors | Kind::Plain => mismatch.with_target(MISMATCH),
        Kind::Glass => mismatch.with_target(MISMATCH_IN_GLASS),
    };
    [
        mismatch,
        row("p99.9_error", "linear", error.p999),
        row("compared", "pixels", truth.picture.pixels.len() as f64),
    ]
}

/// Of tracing alone: pictures of two frames in turn, since an unchanged one would not be traced again.
fn time_row(
    name: &str,
    tracer: &mut dyn Tracer,
    frame: &FrameScene,
    settings: &TraceSettings,
) -> Result<Row, Failure> {
    let mut other = frame.clone();
    other.view.origin += other.view.right.normalize_or_zero() * 1e-6;
    let mut millis = Vec::with_capacity(PICTURES);
    for turn in 0..PICTURES {
        let frame = if turn % 2 == 0 { &other } else { frame };
        traced(tracer, frame, settings)?;
        let passes = tracer.pass_times();
        millis.push(passes.iter().map(|pass| pass.millis).sum());
    }
    Ok(Row::sampled(
        format!("{name}.passes"),
        "ms",
        Better::Lower,
        &millis,
    ))
}

/// The author's rendering, where it is there.
fn authors_picture(folder: &Path, scene: &Published) -> Option<Picture> {
    let path = folder.join("docs").join(format!("{}.png", scene.name));
    match read_png8(&path) {
        Ok(picture) => Some(picture),
        Err(why) => {
            note(why);
            None
        }
    }
}

fn write(path: &Path, picture: &Picture) -> Result<(), Failure> {
    write_png8(path, picture, 0.0, ToneMap::Clip).map_err(|error| Failure::Input(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_held_to_the_published_ones() {
        let rows = count_rows(
            "gears.cpu",
            &SCENES[1],
            [245_086, 330_000, 0, 2_246_955],
            SIZE,
        );
        let off: Vec<_> = rows.iter().filter(|row| must_be_met(&row.name)).collect();
        let met: Vec<_> = off.iter().map(|row| row.met).collect();
        assert_eq!(met, [Some(true), Some(true), Some(false), Some(true)]);
        assert!((off[1].value - 8.3235).abs() < 1e-3, "{}", off[1].value);
        // A quarter of the rays, a quarter of the hits.
        let few = count_rows(
            "tetra.cpu",
            &SCENES[5],
            [12_447, 0, 0, 11_528],
            UVec2::new(513, 513) / 2,
        );
        assert!(few.iter().all(|row| row.met != Some(false)), "{few:?}");
        assert_eq!(percent_off(5.0, 0.0), 500.0);
    }
}
