//! The benchmark `growth`: how frame time grows with triangles, instances, lights, depth and pixels.
//!
//! Each quantity grows by itself on a scene made by code in which something moves in every frame; a point is a whole frame,
//! systems, trees, upload and rays, one after the other as in a window. An exponent of 0 means that more costs nothing, of 1
//! that twice as many take twice as long. The whole run has a limit of time: what does not fit it is left out, and named.

mod fit;
mod limit;
mod page;
mod scenes;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::gpu::Gpu;
use orrery_engine::trace::{ActiveTracer, Backend, open_tracer};
use tracing::subscriber::{NoSubscriber, with_default};

use super::flight::{Flight, open};
use super::frame::{SIZE, backends};
use super::report::{Better, Report, Row, short};
use super::timing::{median, millis_row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::device::wanted;
use crate::failure::Failure;
use crate::output::{note, progress};
use crate::stage;

use fit::{exponent, upper};
use limit::Limit;
use scenes::Quantity;

/// Size of a short run's pictures.
const SMALL_SIZE: UVec2 = UVec2::new(64, 48);
/// Frames before the clock counts, while there is time.
const WARM_UP: u64 = 3;
/// Frames of a point: as many as fit the time, within these bounds.
const PATIENCE: Duration = Duration::from_secs(1);
const FRAMES: (usize, usize) = (3, 200);
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
    let backends = backends(common);
    let mut limit = Limit::new(backends.len());
    for choice in backends {
        let (tracer, gpu) = open(choice, common)?;
        devices.push(tracer.device());
        let backend = tracer.backend().to_string();
        drop(tracer);
        let bench = Bench {
            choice,
            gpu,
            size,
            small: request.small,
            common,
        };
        for quantity in Quantity::ALL {
            let mut curve = Curve {
                quantity,
                backend: backend.clone(),
                points: Vec::new(),
            };
            limit.start(quantity);
            bench.follow(&mut curve, &mut limit)?;
            curves.push(curve);
        }
    }
    let rows = curves.iter().flat_map(Curve::rows).collect();
    let abouts = Quantity::ALL.map(|quantity| format!("{}: {}", quantity.name(), quantity.about()));
    let mut report = Report {
        rows,
        remarks: vec![
            format!(
                "{}x{} unless pixels grow, 4 generations unless depth grows; as in a window: two pictures under way",
                size.x, size.y
            ),
            abouts.join("; "),
            "exponent: of the power law, the median of the slopes between any two points; top: of the upper half of them"
                .into(),
        ],
        ..Report::new("growth", &devices)
    };
    report.remarks.extend(limit.left_out);
    if let Some(folder) = &request.report {
        page::write(folder, &report, &curves)?;
    }
    Ok(report)
}

/// Where curves are measured.
struct Bench<'a> {
    choice: BackendChoice,
    /// The device, where it is one: opened once.
    gpu: Option<Arc<Gpu>>,
    size: UVec2,
    small: bool,
    common: &'a Common,
}

impl Bench<'_> {
    /// A curve, as far as the device and the time go.
    fn follow(&self, curve: &mut Curve, limit: &mut Limit) -> Result<(), Failure> {
        let quantity = curve.quantity;
        let steps = quantity.steps(self.small);
        let bar = progress(steps.len() as u64, quantity.name());
        for &step in steps {
            let count = quantity.count(step);
            let name = format!("{}.{}.{count}", curve.backend, quantity.name());
            if limit.is_too_long(count, &name) {
                break;
            }
            match self.point(quantity, step, limit) {
                Ok(point) => {
                    bar.suspend(|| note(format_args!("{name}: {}", point.words())));
                    curve.points.push(point);
                }
                // What is too large for a device ends its curve; what fails for another reason is a failure.
                Err(Failure::Input(why)) if !curve.points.is_empty() => {
                    bar.suspend(|| limit.leave_out(format!("{name} and more: {why}")));
                    break;
                }
                Err(failure) => return Err(failure),
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }

    fn point(&self, quantity: Quantity, step: usize, limit: &mut Limit) -> Result<Point, Failure> {
        let begun = Instant::now();
        let tracer = match &self.gpu {
            Some(gpu) => open_tracer(wanted(self.choice), None, Some(Arc::clone(gpu)))?.0,
            None => open(self.choice, self.common)?.0,
        };
        // Spans are made together with their systems, in the first frame: none are, under this subscriber.
        with_default(NoSubscriber::new(), || {
            let mut engine = quantity.scene(step, self.size)?;
            stage::cast(&mut engine, tracer);
            let mut flight = Flight::new(self.gpu.clone());
            let first = warm_up(&mut engine, &mut flight)?;
            let before = begun.elapsed();
            let count = quantity.count(step);
            let point = measure(&mut engine, flight, count, first, limit.end())?;
            limit.note(count, before, median(&point.frames));
            Ok(point)
        })
    }
}

/// Frames that do not count: one at least, which builds everything. The number of the next.
fn warm_up(engine: &mut Engine, flight: &mut Flight) -> Result<u64, Failure> {
    let mut begun = None;
    for frame in 0..WARM_UP {
        if begun.is_some_and(|begun: Instant| begun.elapsed() > PATIENCE) {
            return Ok(frame);
        }
        stage::advance(engine, frame)?;
        flight.submitted()?;
        flight.land()?;
        begun.get_or_insert_with(Instant::now);
    }
    Ok(WARM_UP)
}

/// Frames from a number on, for as long as there is patience; at the end of time, one.
fn measure(
    engine: &mut Engine,
    mut flight: Flight,
    count: usize,
    first: u64,
    end: Instant,
) -> Result<Point, Failure> {
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
        let is_late = count > 0 && Instant::now() >= end;
        count >= most || is_late || (count >= least && begun.elapsed() >= PATIENCE)
    };
    let mut start = Instant::now();
    let mut frame = first;
    while !is_enough(&point) {
        stage::advance(engine, frame)?;
        flight.submitted()?;
        frame += 1;
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
    let pixels = f64::from(size.x) * f64::from(size.y);
    point.rays_a_pixel = rays_of(engine, frame)? as f64 / pixels;
    Ok(point)
}

/// Rays of a frame; on the processor, of the one before it: they are always counted there.
fn rays_of(engine: &mut Engine, frame: u64) -> Result<u64, Failure> {
    let tracer = &engine.world.resource::<ActiveTracer>().0;
    let is_device = tracer.as_ref().map(|tracer| tracer.backend()) == Some(Backend::Gpu);
    if is_device {
        engine.world.resource_mut::<TraceSettings>().count_rays = true;
        stage::advance(engine, frame)?;
    }
    let Some(tracer) = &mut engine.world.resource_mut::<ActiveTracer>().0 else {
        return Ok(0);
    };
    if is_device {
        tracer.picture()?;
    }
    Ok(tracer.counters().rays())
}

impl Point {
    fn words(&self) -> String {
        format!(
            "{} ms a frame, {} ms tracing, {} rays a pixel",
            short(median(&self.frames)),
            short(median(&self.rays)),
            short(self.rays_a_pixel)
        )
    }
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
