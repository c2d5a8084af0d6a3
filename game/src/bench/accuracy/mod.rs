//! The benchmark `accuracy`: run time against error.
//!
//! On every class of scene each knob that trades one for the other is turned by itself; a point is what tracing took
//! and how far its picture is from the f64 reference's. Two panels judge one sample a pixel against one sample of the
//! reference (what arithmetic and left-out rays cost), a third judges sampling against 256 samples of it. Per device
//! and panel, what nothing else beats in both is the front; the engine's defaults must be on it.

mod chart;
mod classes;
mod front;
mod knobs;
mod page;
mod point;

use orrery_engine::trace::{Picture, Tracer};

use super::frame::backends;
use super::report::{Better, Report, Row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::device;
use crate::failure::Failure;
use crate::output::progress;

use classes::Class;
use knobs::{Knob, Panel};
use point::{Effort, Point, Stand};

/// What sums of other terms may round differently, a channel.
const ROUNDING: f64 = 2e-6;
/// Ends the names of rows that prove a bound.
const PROOF: &str = "worst_pixel";

/// Whether a row of that name must be as it should: the proofs; a default beaten by noise is no fault.
pub fn must_be_met(row: &str) -> bool {
    row.ends_with(PROOF)
}

/// What was measured on one class.
pub struct Measured {
    /// The class's name.
    pub name: &'static str,
    /// What it holds.
    pub about: &'static str,
    /// Every backend's points, in the order of the knobs.
    pub points: Vec<Point>,
}

/// Measures every class on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let effort = Effort::of(request, common);
    let classes = classes::all(request, common)?;
    let mut tracers: Vec<Box<dyn Tracer>> = Vec::new();
    for choice in backends(common) {
        tracers.push(device::open_choice(choice, common)?);
    }
    let devices: Vec<String> = tracers.iter().map(|tracer| tracer.device()).collect();
    let mut reference = device::open_choice(BackendChoice::Reference, common)?;
    let knobs = knobs::all();
    let bar = progress(
        (classes.len() * (1 + tracers.len() * knobs.len())) as u64,
        "accuracy",
    );
    let (mut rows, mut measured) = (Vec::new(), Vec::new());
    for class in &classes {
        bar.set_message(class.name);
        let stand = Stand::new(class, effort, reference.as_mut())?;
        bar.inc(1);
        let mut points = vec![stand.reference.clone()];
        for tracer in &mut tracers {
            let mut full = None;
            for knob in &knobs {
                bar.inc(1);
                let (point, picture) = stand.measure(tracer.as_mut(), knob)?;
                rows.extend(bound_row(class, knob, &point, &picture, full.as_ref()));
                if knob.is_default {
                    full = Some(picture);
                }
                rows.extend(point.rows(class.name));
                points.push(point);
            }
        }
        front::mark(&mut points);
        rows.extend(front::default_rows(class.name, &points));
        measured.push(Measured {
            name: class.name,
            about: class.about,
            points,
        });
    }
    bar.finish_and_clear();
    let report = Report {
        rows,
        remarks: effort.remarks(),
        ..Report::new("accuracy", &devices)
    };
    if let Some(folder) = &request.report {
        page::write(folder, &report, &measured)?;
    }
    Ok(report)
}

/// That leaving out rays cost no pixel more than it was allowed to.
fn bound_row(
    class: &Class,
    knob: &Knob,
    point: &Point,
    picture: &Picture,
    full: Option<&Picture>,
) -> Option<Row> {
    let (Panel::Arithmetic, Some(cutoff), Some(full)) = (knob.panel, knob.cutoff, full) else {
        return None;
    };
    let pairs = picture.pixels.iter().zip(&full.pixels);
    let off = pairs.map(|(a, b)| f64::from((*a - *b).abs().max_element()));
    let name = format!("{}.{}.{}.{PROOF}", class.name, point.backend, knob.name);
    let worst = off.fold(0.0, f64::max);
    let most = f64::from(cutoff) + ROUNDING;
    Some(Row::single(name, "linear", Better::Lower, worst).with_target(most))
}
