//! The benchmark `skips`: what it saves to compile, bind and trace only what a scene needs.
//!
//! For each feature, a scene without it under the pipeline made for that scene, under one that has that feature too, and
//! under the general one, which has all. For three kinds of scenes, the pipeline made for them beside a minimal kernel
//! written by hand for nothing else. For each kind of ray that is left out, the demo without and with it. All take turns in one
//! run; their pictures are the same.

mod left_out;
mod scenes;

use std::sync::Arc;

use glam::{UVec2, Vec3};
use orrery_engine::frame::{Features, FrameScene, NamedFeature, Skip, Skips, TraceSettings};
use orrery_engine::trace::gpu::{AdapterChoice, Gpu, GpuTracer, HandKernel};
use orrery_engine::trace::{Picture, Tracer};

use super::frame::SIZE;
use super::report::{Better, Report, Row};
use super::timing::{median, millis_row, zero_row};
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::failure::Failure;
use crate::output::progress;
use crate::stage::{settings, traced};

use scenes::Kind;

/// Size of a short run's pictures, and the features that one looks at.
const SMALL_SIZE: UVec2 = UVec2::new(64, 48);
const SMALL_FEATURES: [&str; 3] = ["transmission", "meshes", "textures"];
/// Rounds before times count, and of times.
const WARM_UP: usize = 3;
/// Pictures of a way before the one that is timed.
const SETTLING: usize = 2;
const ROUNDS: usize = 40;
const SMALL_ROUNDS: usize = 4;
/// The pass that makes pictures.
const KERNEL: &str = "whitted";
/// A step of a display: what pictures of two pipelines differ by nowhere.
const STEP: f32 = 1.0 / 255.0;
/// What a pipeline made for its scene may take over a kernel by hand: noise.
const BY_HAND_TARGET: f64 = 1.05;

/// A way to trace a scene.
#[derive(Clone, Copy)]
struct Way {
    features: Features,
    by_hand: Option<HandKernel>,
    skips: Skips,
    cutoff: f32,
}

impl Way {
    /// With our own kernel for these, all that may be left out left out.
    fn of(features: Features) -> Self {
        Self {
            features,
            by_hand: None,
            skips: Skips::ALL,
            cutoff: 0.0,
        }
    }

    fn settings(&self, settings: &TraceSettings) -> TraceSettings {
        TraceSettings {
            skips: self.skips,
            cutoff: self.cutoff,
            ..*settings
        }
    }
}

/// Measures on the device that `--adapter` names.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    if !matches!(common.backend, BackendChoice::Auto | BackendChoice::Gpu) {
        return Err(Failure::Usage(
            "`skips` measures pipelines of the GPU; expected `--backend gpu`, or none".into(),
        ));
    }
    let named = common.adapter.clone().map(AdapterChoice::Named);
    let which = named.unwrap_or(AdapterChoice::Any);
    let gpu = Arc::new(Gpu::open(Gpu::instance(), &which, None)?);
    let small = request.small.then_some(SMALL_SIZE);
    let run = Run {
        settings: settings(common, small.unwrap_or(SIZE)),
        small: request.small,
    };
    let mut tracer = GpuTracer::new(gpu)?;
    let device = tracer.device();
    let mut rows = Vec::new();
    let count = Kind::ALL.len() + Features::NAMED.len() + left_out::OF_RAYS.len();
    let bar = progress(count as u64, "skips");
    for kind in Kind::ALL {
        rows.extend(run.kind_rows(kind, &mut tracer)?);
        bar.inc(1);
    }
    for feature in Features::NAMED {
        if !request.small || SMALL_FEATURES.contains(&feature.0) {
            rows.extend(run.feature_rows(feature, &mut tracer)?);
        }
        bar.inc(1);
    }
    let scene = left_out::scene(&run, common)?;
    for skip in left_out::OF_RAYS {
        if !request.small || skip == Skip::Away {
            rows.extend(left_out::rows(&run, skip, &scene, &mut tracer)?);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let size = run.settings.size;
    Ok(Report {
        rows,
        remarks: vec![
            format!("{}x{}, the pass that makes the picture, ways to trace it in turn", size.x, size.y),
            "specialised: compiled for what the scene has; with: for the named feature too (and what it needs); general: for all; by hand: a minimal kernel for that kind of scene".into(),
            format!("left_out: of {}, the rays that a name of `--without` stands for: without and with them; too faint ones with a cut-off of {} in both", if request.small { "mirrors" } else { "the demo" }, left_out::CUTOFF),
            "features are missing from the scene of triangles; `meshes` from that of spheres; off: pixels of the other pictures that differ from the specialised one's by a step of 1/255".into(),
        ],
        ..Report::new("skips", &[device])
    })
}

struct Run {
    settings: TraceSettings,
    small: bool,
}

/// What a way took, and what it showed.
struct Outcome {
    millis: Vec<f64>,
    picture: Picture,
}

impl Run {
    /// Specialised, by hand and general, on a kind of scene.
    fn kind_rows(&self, kind: Kind, tracer: &mut GpuTracer) -> Result<Vec<Row>, Failure> {
        let scene = kind.scene(&self.settings, self.small)?;
        let own = |by_hand| Way {
            by_hand,
            ..Way::of(scene.features)
        };
        let ways = [own(None), own(Some(kind.by_hand())), general()];
        let [special, by_hand, general] = self.measure(&scene, ways, tracer)?;
        let name = |what: &str| format!("kind.{}.{what}", kind.name());
        let ratio = median(&special.millis) / median(&by_hand.millis);
        Ok(vec![
            millis_row(name("specialised"), &special.millis),
            millis_row(name("by_hand"), &by_hand.millis),
            millis_row(name("general"), &general.millis),
            Row::single(name("ratio"), "by hand", Better::Lower, ratio).with_target(BY_HAND_TARGET),
            off_row(name("off"), &special, [&by_hand, &general]),
        ])
    }

    /// Specialised, with the feature and general, on a scene without it.
    fn feature_rows(
        &self,
        (feature, switch): NamedFeature,
        tracer: &mut GpuTracer,
    ) -> Result<Vec<Row>, Failure> {
        let mut without = None;
        for kind in Kind::ALL {
            let mut scene = kind.scene(&self.settings, self.small)?;
            if !*switch(&mut scene.features) {
                without = Some(scene);
                break;
            }
        }
        let Some(scene) = without else {
            return Err(Failure::Input(format!("every scene has `{feature}`")));
        };
        let mut more = scene.features;
        for name in needs(feature).iter().chain([&feature]) {
            let named = Features::NAMED.into_iter().find(|named| named.0 == *name);
            if let Some((_, switch)) = named {
                *switch(&mut more) = true;
            }
        }
        let ways = [Way::of(scene.features), Way::of(more), general()];
        let [special, with, general] = self.measure(&scene, ways, tracer)?;
        let name = |what: &str| format!("without.{feature}.{what}");
        let saved = |by: &Outcome| 1.0 - median(&special.millis) / median(&by.millis);
        let share = |what, by| Row::single(name(what), "share", Better::Higher, saved(by));
        Ok(vec![
            millis_row(name("specialised"), &special.millis),
            millis_row(name("with"), &with.millis),
            millis_row(name("general"), &general.millis),
            share("saved", &with),
            share("saved_of_general", &general),
            off_row(name("off"), &special, [&with, &general]),
        ])
    }

    /// All ways in turn, round after round; then a picture of each.
    fn measure<const N: usize>(
        &self,
        scene: &FrameScene,
        ways: [Way; N],
        tracer: &mut GpuTracer,
    ) -> Result<[Outcome; N], Failure> {
        let mut turn = Turn { scene, count: 0 };
        let mut millis = [const { Vec::new() }; N];
        let rounds = if self.small { SMALL_ROUNDS } else { ROUNDS };
        for round in 0..WARM_UP + rounds {
            for (way, millis) in ways.iter().zip(&mut millis) {
                // After another kernel, a picture is cut finer until it is known what samples take.
                for _ in 0..SETTLING {
                    turn.trace(way, &self.settings, tracer)?;
                }
                let (_, took) = turn.trace(way, &self.settings, tracer)?;
                if round >= WARM_UP {
                    millis.push(took);
                }
            }
        }
        let mut pictures = Vec::with_capacity(N);
        for way in &ways {
            // Of a turn in which the background is its own.
            turn.count = 1;
            turn.trace(way, &self.settings, tracer)?;
            pictures.push(turn.trace(way, &self.settings, tracer)?.0);
        }
        let mut pictures = pictures.into_iter();
        Ok(millis.map(|millis| Outcome {
            millis,
            picture: pictures.next().unwrap_or_default(),
        }))
    }
}

/// Frames one after the other, each a little different from the last: an unchanged one is not traced.
struct Turn<'a> {
    scene: &'a FrameScene,
    count: usize,
}

impl Turn<'_> {
    /// The picture, and the milliseconds of the pass that made it; of it all, where the device has no clock.
    fn trace(
        &mut self,
        way: &Way,
        settings: &TraceSettings,
        tracer: &mut GpuTracer,
    ) -> Result<(Picture, f64), Failure> {
        let mut frame = self.scene.clone();
        frame.features = way.features;
        if self.count % 2 == 1 {
            frame.background.horizon += Vec3::splat(1e-6);
        }
        self.count += 1;
        tracer.trace_by_hand(way.by_hand);
        let settings = way.settings(settings);
        let start = std::time::Instant::now();
        let picture = traced(tracer, &frame, &settings)?;
        let around = start.elapsed().as_secs_f64() * 1e3;
        let passes = tracer.pass_times();
        let pass = passes.iter().find(|pass| pass.name == KERNEL);
        Ok((picture, pass.map_or(around, |pass| pass.millis)))
    }
}

fn general() -> Way {
    Way::of(Features::all())
}

/// Features without which one has no effect.
fn needs(feature: &str) -> &'static [&'static str] {
    match feature {
        "absorption" => &["transmission"],
        "curved" => &["smooth_normals"],
        "normal_maps" => &["textures"],
        "cutouts" => &["textures"],
        "panorama" => &["sky"],
        "open_cones" => &["cones", "instances"],
        "spheres" | "sphere_trees" | "cuboids" | "discs" | "cones" | "tori" => &["instances"],
        _ => &[],
    }
}

/// Pixels of others that are not as they should be.
fn off_row<const N: usize>(name: String, right: &Outcome, others: [&Outcome; N]) -> Row {
    let pairs = others.into_iter().flat_map(|other| {
        let pixels = other.picture.pixels.iter();
        pixels.zip(&right.picture.pixels)
    });
    let off = pairs.filter(|(a, b)| (**a - **b).abs().max_element() > STEP);
    zero_row(name, "pixels", off.count() as u64)
}
