//! One setting measured: what tracing took, and how far the picture is from the truth.

use std::time::{Duration, Instant};

use glam::{UVec2, Vec3};
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::profile::PictureError;
use orrery_engine::trace::{Picture, Tracer};

use super::classes::Class;
use super::knobs::{Knob, Panel};
use crate::args::{BenchRequest, Common};
use crate::bench::report::{Better, Row};
use crate::failure::Failure;
use crate::stage::traced;

/// Size of the pictures that are timed and judged with one sample.
const SIZE: UVec2 = UVec2::new(512, 384);
/// Size of those judged against many samples of the reference, which takes its time.
const SAMPLED_SIZE: UVec2 = UVec2::new(128, 96);
/// Samples of the truth that sampling is judged by.
const TRUE_SAMPLES: u32 = 256;
/// The passes that trace.
const TRACING: [&str; 2] = ["whitted", "antialias"];
/// Fewest pictures that a time is the median of.
const FEWEST: usize = 5;

/// How much is spent.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    size: UVec2,
    sampled_size: UVec2,
    true_samples: u32,
    pictures: usize,
    /// Before times count: a device's clock rises with its work.
    warming: Duration,
    budget: Duration,
}

impl Effort {
    /// As asked.
    pub fn of(request: &BenchRequest, common: &Common) -> Self {
        if request.small {
            Self {
                size: UVec2::new(32, 24),
                sampled_size: UVec2::new(16, 12),
                true_samples: 16,
                pictures: FEWEST,
                warming: Duration::ZERO,
                budget: Duration::ZERO,
            }
        } else {
            Self {
                size: common.size.unwrap_or(SIZE),
                sampled_size: SAMPLED_SIZE,
                true_samples: TRUE_SAMPLES,
                pictures: request.repeat as usize,
                warming: Duration::from_millis(250),
                budget: Duration::from_millis(500),
            }
        }
    }

    /// Sentences that say so.
    pub fn remarks(self) -> Vec<String> {
        let Self {
            size, sampled_size, ..
        } = self;
        vec![
            format!(
                "times: tracing alone at {}x{}, by the device's own timestamps on a GPU; medians of {FEWEST} to {} pictures",
                size.x, size.y, self.pictures
            ),
            format!(
                "errors: against one sample of the f64 reference at that size; of samples and sizes against {} of it at {}x{}",
                self.true_samples, sampled_size.x, sampled_size.y
            ),
        ]
    }
}

/// A setting's place in the charts.
#[derive(Clone, Debug)]
pub struct Point {
    /// What traced.
    pub backend: String,
    /// The setting.
    pub knob: String,
    /// What it is judged by.
    pub panel: Panel,
    /// The engine as it comes.
    pub is_default: bool,
    /// Milliseconds: the median.
    pub median: f64,
    /// 5th percentile.
    pub p05: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Pictures timed.
    pub pictures: usize,
    /// Distance from the truth.
    pub error: PictureError,
    /// By each measure; see [`super::front`].
    pub is_beaten: [bool; 3],
}

impl Point {
    fn new(backend: String, knob: &Knob, millis: &[f64], error: PictureError) -> Self {
        let time = Row::sampled("", "ms", Better::Lower, millis);
        Self {
            backend,
            knob: knob.name.clone(),
            panel: knob.panel,
            is_default: knob.is_default,
            median: time.value,
            p05: time.p05.unwrap_or(time.value),
            p95: time.p95.unwrap_or(time.value),
            pictures: millis.len(),
            error,
            is_beaten: [false; 3],
        }
    }

    /// Its numbers.
    pub fn rows(&self, class: &str) -> Vec<Row> {
        let name = |what: &str| format!("{class}.{}.{}.{what}", self.backend, self.knob);
        let single = |what, unit, value| Row::single(name(what), unit, Better::Lower, value);
        let time = Row {
            p05: Some(self.p05),
            p95: Some(self.p95),
            ..single("tracing", "ms", self.median)
        };
        match self.panel {
            Panel::Arithmetic => vec![
                time,
                single("mismatch", "ppm", self.error.mismatch_ppm),
                single("p99.9", "linear", self.error.p999),
            ],
            Panel::Sampling => vec![time, single("relMSE", "1", self.error.relative_mse)],
        }
    }
}

/// A class with its true pictures.
pub struct Stand<'a> {
    class: &'a Class,
    effort: Effort,
    /// One sample, and many.
    truths: [Picture; 2],
    /// The reference's own point: its time, without error.
    pub reference: Point,
}

impl<'a> Stand<'a> {
    /// Traces the truth.
    pub fn new(
        class: &'a Class,
        effort: Effort,
        reference: &mut dyn Tracer,
    ) -> Result<Self, Failure> {
        let settings = TraceSettings {
            size: effort.size,
            ..TraceSettings::default()
        };
        let many = TraceSettings {
            size: effort.sampled_size,
            samples: effort.true_samples,
            ..settings
        };
        let start = Instant::now();
        let one = traced(reference, &class.frames[0], &settings)?;
        let millis = start.elapsed().as_secs_f64() * 1e3;
        let truths = [one, traced(reference, &class.frames[0], &many)?];
        let mut knob = super::knobs::all().swap_remove(0);
        knob.is_default = false;
        let name = reference.backend().to_string();
        Ok(Self {
            class,
            effort,
            truths,
            reference: Point::new(name, &knob, &[millis], PictureError::default()),
        })
    }

    /// Measures a setting; the picture is the one that was judged.
    pub fn measure(
        &self,
        tracer: &mut dyn Tracer,
        knob: &Knob,
    ) -> Result<(Point, Picture), Failure> {
        let (size, truth) = match knob.panel {
            Panel::Arithmetic => (self.effort.size, &self.truths[0]),
            Panel::Sampling => (self.effort.sampled_size, &self.truths[1]),
        };
        let settings = TraceSettings {
            size,
            ..TraceSettings::default()
        };
        let frames = self.class.frames.clone().map(|frame| knob.shorten(frame));
        let judged = traced(tracer, &frames[0], &knob.turn(settings))?;
        let judged = enlarged(judged, size);
        let error = PictureError::of(&judged, truth);
        let timed = knob.turn(TraceSettings {
            size: self.effort.size,
            ..settings
        });
        let millis = self.millis(tracer, &frames, &timed)?;
        let name = tracer.backend().to_string();
        Ok((Point::new(name, knob, &millis, error), judged))
    }

    /// Of pictures of two frames in turn: an unchanged one would not be traced again.
    fn millis(
        &self,
        tracer: &mut dyn Tracer,
        frames: &[FrameScene; 2],
        settings: &TraceSettings,
    ) -> Result<Vec<f64>, Failure> {
        let mut millis = Vec::new();
        let start = Instant::now();
        let mut turn = 0;
        while turn < FEWEST || start.elapsed() < self.effort.warming {
            turn += 1;
            traced(tracer, &frames[turn % 2], settings)?;
        }
        let start = Instant::now();
        while millis.len() < FEWEST
            || (millis.len() < self.effort.pictures && start.elapsed() < self.effort.budget)
        {
            turn += 1;
            traced(tracer, &frames[turn % 2], settings)?;
            let passes = tracer.pass_times();
            let tracing = passes.iter().filter(|pass| TRACING.contains(&pass.name));
            millis.push(tracing.map(|pass| pass.millis).sum());
        }
        Ok(millis)
    }
}

/// A picture at another size, interpolated between the centres of its pixels.
fn enlarged(small: Picture, size: UVec2) -> Picture {
    if small.size == size {
        return small;
    }
    let mut large = Picture::new(size);
    let most = small.size.as_vec2() - 1.0;
    let at = |x: u32, y: u32| small.pixels[(y * small.size.x + x) as usize];
    for (i, pixel) in large.pixels.iter_mut().enumerate() {
        let place = UVec2::new(i as u32 % size.x, i as u32 / size.x).as_vec2() + 0.5;
        let place = place * small.size.as_vec2() / size.as_vec2() - 0.5;
        let place = place.clamp(glam::Vec2::ZERO, most);
        let (low, share) = (place.floor().as_uvec2(), place.fract());
        let high = (low + 1).min(small.size - 1);
        let row = |y: u32| -> Vec3 { at(low.x, y).lerp(at(high.x, y), share.x) };
        *pixel = row(low.y).lerp(row(high.y), share.y);
    }
    large
}
