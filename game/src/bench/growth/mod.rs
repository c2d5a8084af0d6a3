//! The benchmark `growth`: how frame time grows with triangles, instances, lights, depth and pixels.
//!
//! Each quantity grows by itself on a scene made by code in which something moves in every frame; a point is a whole frame,
//! systems, trees, upload and rays, one after the other as in a window. An exponent of 0 means that more costs nothing, of 1
//! that twice as many take twice as long.

mod fit;
mod page;
mod scenes;

use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::ActiveTracer;
use tracing::subscriber::{NoSubscriber, with_default};

use super::flight::{Flight, open};
use super::frame::{SIZE, backends};
use super::report::{Better, Report, Row};
use super::timing::{median, millis_row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::failure::Failure;
use crate::output::{note, progress};
use crate::stage;

use fit::{exponent, upper};
use scenes::Quantity;

/// Size of a short run's pictures.
const SMALL_SIZE: UVec2 = UVec2::new(64, 48);
/// Frames before the clock counts.
const WARM_UP: u64 = 3;
/// Frames of a point: as many as fit the time, within these bounds.
const PATIENCE: Duration = Duration::from_secs(2);
const FRAMES: (usize, usize) = (5, 200);
/// The pass that traces.
const KERNEL: &str = "whitted";

/// A point of a curve.
pub struct Point {
    /// How many.
    pub count: usize,
    /// From one frame to the next.
    pub frames: Vec<f64>,
    /// Of that, tracing alone; by the device's clock where it has one.
    pub rays: Vec<f64>,
    /// Rays a pixel of the picture after those that were timed: counting takes time on a device.
    pub rays_a_pixel: f64,
}

/// Frame time against a quantity, on a device.
pub struct Curve {
    /// What grows.
    pub quantity: Quantity,
    /// On which backend.
    pub backend: String,
    /// In order of counts.
    pub points: Vec<Point>,
}

/// Measures every curve on every chosen backend.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let small = request.small.then_some(SMALL_SIZE);
    let size = common.size.or(small).unwrap_or(SIZE);
    let mut devices = Vec::new();
    let mut curves = Vec::new();
    for choice in backends(common) {
        let (tracer, _) = open(choice, common)?;
        devices.push(tracer.device());
        let backend = tracer.backend().to_string();
        drop(tracer);
        for quantity in Quantity::ALL {
            curves.push(Curve {
                quantity,
                backend: backend.clone(),
                points: points(quantity, choice, size, request.small, common)?,
            });
        }
    }
    let rows = curves.iter().flat_map(Curve::rows).collect();
    let abouts = Quantity::ALL.map(|quantity| format!("{}: {}", quantity.name(), quantity.about()));
    let report = Report {
        rows,
        remarks: vec![
            format!(
                "{}x{} unless pixels grow, 4 generations unless depth grows; as in a window: two pictures under way",
                size.x, size.y
            ),
            abouts.join("; "),
            "exponent: of the power law that fits all points best; top: the upper half of them"
                .into(),
        ],
        ..Report::new("growth", &devices)
    };
    if let Some(folder) = &request.report {
        page::write(folder, &report, &curves)?;
    }
    Ok(report)
}

/// A curve, as far as the device goes.
fn points(
    quantity: Quantity,
    choice: BackendChoice,
    size: UVec2,
    small: bool,
    common: &Common,
) -> Result<Vec<Point>, Failure> {
    let steps = quantity.steps(small);
    let bar = progress(steps.len() as u64, quantity.name());
    let mut points = Vec::new();
    for &step in steps {
        let (tracer, gpu) = open(choice, common)?;
        // Spans are made together with their systems, in the first frame: none are, under this subscriber.
        let point = with_default(NoSubscriber::new(), || {
            let mut engine = quantity.scene(step, size)?;
            stage::cast(&mut engine, tracer);
            measure(&mut engine, Flight::new(gpu), quantity.count(step))
        });
        match point {
            Ok(point) => points.push(point),
            // What is too large for a device ends its curve.
            Err(failure) if !points.is_empty() => {
                note(format_args!(
                    "note: {} ends before {step}: {failure}",
                    quantity.name()
                ));
                break;
            }
            Err(failure) => return Err(failure),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(points)
}

fn measure(engine: &mut Engine, mut flight: Flight, count: usize) -> Result<Point, Failure> {
    for frame in 0..WARM_UP {
        stage::advance(engine, frame)?;
        flight.submitted()?;
    }
    flight.land()?;
    let size = engine.world.resource::<TraceSettings>().size;
    let mut point = Point {
        count,
        frames: Vec::new(),
        rays: Vec::new(),
        rays_a_pixel: 0.0,
    };
    let begun = Instant::now();
    let is_enough = |point: &Point| {
        let (least, most) = FRAMES;
        let count = point.frames.len();
        count >= most || (count >= least && begun.elapsed() >= PATIENCE)
    };
    let mut start = Instant::now();
    for frame in WARM_UP.. {
        if is_enough(&point) {
            break;
        }
        stage::advance(engine, frame)?;
        flight.submitted()?;
        let end = Instant::now();
        point.frames.push((end - start).as_secs_f64() * 1e3);
        start = end;
        if let Some(tracer) = &engine.world.resource::<ActiveTracer>().0 {
            let passes = tracer.pass_times();
            let pass = passes.iter().find(|pass| pass.name == KERNEL);
            point.rays.extend(pass.map(|pass| pass.millis));
        }
    }
    flight.land()?;
    engine.world.resource_mut::<TraceSettings>().count_rays = true;
    stage::advance(engine, WARM_UP + point.frames.len() as u64)?;
    if let Some(tracer) = &mut engine.world.resource_mut::<ActiveTracer>().0 {
        tracer.picture()?;
        let pixels = f64::from(size.x) * f64::from(size.y);
        point.rays_a_pixel = tracer.counters().rays() as f64 / pixels;
    }
    Ok(point)
}

impl Curve {
    fn rows(&self) -> Vec<Row> {
        let name = format!("{}.{}", self.backend, self.quantity.name());
        let mut rows = Vec::new();
        for point in &self.points {
            let name = |what| format!("{name}.{}.{what}", point.count);
            rows.push(millis_row(name("frame"), &point.frames));
            rows.push(millis_row(name("trace"), &point.rays));
            let rays = point.rays_a_pixel;
            rows.push(Row::single(name("rays"), "a pixel", Better::Higher, rays));
        }
        let all = self.medians(|point| &point.frames);
        let rays = self.medians(|point| &point.rays);
        let fits = [
            ("exponent", exponent(&all)),
            ("exponent.top", exponent(upper(&all))),
            ("trace.exponent", exponent(&rays)),
            ("trace.exponent.top", exponent(upper(&rays))),
        ];
        rows.extend(fits.into_iter().filter_map(|(what, fitted)| {
            let name = format!("{name}.{what}");
            fitted.map(|fitted| Row::single(name, "1", Better::Lower, fitted))
        }));
        rows
    }

    /// Count and milliseconds of each point.
    pub fn medians(&self, of: impl Fn(&Point) -> &[f64]) -> Vec<(f64, f64)> {
        let points = self.points.iter();
        points
            .map(|point| (point.count as f64, median(of(point))))
            .collect()
    }
}
