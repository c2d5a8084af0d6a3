//! The benchmark `profile`: what measuring costs. The same frames with and without it, one after the other in turn, so that a
//! machine that grows warm or busy does so for both.

use std::time::Instant;

use glam::UVec2;
use orrery_engine::editor::EditorState;
use orrery_engine::frame::TraceSettings;
use orrery_engine::profile::Ledger;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::{Engine, editor, input, present};
use tracing::subscriber::{NoSubscriber, with_default};

use super::crowd::{Crowd, Kind, Plan};
use super::report::{Better, Report, Row};
use super::timing::median;
use crate::args::{BenchRequest, Common};
use crate::failure::Failure;
use crate::stage::{advance, cast};

/// Frames that do not count.
const WARM_UP: u64 = 30;
/// Frames that count, of each kind.
const FRAMES: u64 = 600;
/// Fewer pixels than anyone plays with, so that the share is no smaller than anyone's.
const SIZE: UVec2 = UVec2::new(320, 180);
/// What measuring may cost while nobody looks, and while somebody does, in per cent of the frame.
const CLOSED_TARGET: f64 = 0.5;
const OPEN_TARGET: f64 = 3.0;

/// Measures it.
pub fn run(request: &BenchRequest, _: &Common) -> Result<Report, Failure> {
    let plan = Plan {
        count: if request.small { 100 } else { 1000 },
        kind: Kind::Spheres,
        moving: true,
        profiled: false,
    };
    let profiled = Plan {
        profiled: true,
        ..plan
    };
    let frames = if request.small { 60 } else { FRAMES };
    // Spans are made with the systems: built where nobody listens, an engine has none.
    let mut bare = with_default(NoSubscriber::default(), || Crowd::new(plan)).engine;
    let mut closed = Crowd::new(profiled).engine;
    let (mut shut, mut open) = (with_panels(profiled, false), with_panels(profiled, true));
    let (mut looking, mut traced) = (Crowd::new(profiled).engine, Crowd::new(profiled).engine);
    looking.world.resource_mut::<Ledger>().wanted = true;
    traced.world.resource_mut::<TraceSettings>().size = SIZE;
    cast(&mut traced, Box::new(CpuTracer::new()));
    let [traced] = micros_in_turn([&mut traced], frames)?;
    // Of those that are compared, none follows the same one in every turn.
    let compared = [&mut bare, &mut closed, &mut looking, &mut shut, &mut open];
    let [bare, closed, looking, shut, open] = micros_in_turn(compared, frames)?;
    let row = |name: &str, micros: &[f64]| Row::sampled(name, "us", Better::Lower, micros);
    let frame = median(&traced);
    let cost = |with: &[f64], without: &[f64]| median(with) - median(without);
    let share = |name: &str, micros: f64| {
        let percent = 100.0 * micros / frame;
        Row::single(name, "%", Better::Lower, percent)
    };
    let spans = cost(&closed, &bare);
    let rows = vec![
        row("frame, processor, 320x180", &traced),
        row("systems alone, not measured", &bare),
        row("systems alone, measured", &closed),
        share("spans and frames kept, of the frame", spans).with_target(CLOSED_TARGET),
        share("the same while the profiler is open", spans).with_target(OPEN_TARGET),
        Row::single(
            "who changed what",
            "us",
            Better::Lower,
            cost(&looking, &closed),
        ),
        Row::single(
            "drawing the profiler",
            "us",
            Better::Lower,
            cost(&open, &shut),
        ),
    ];
    Ok(Report {
        rows,
        remarks: vec![format!(
            "{} moving spheres, {frames} frames of each kind in turn; spans and frames are kept alike whether the profiler is open or closed. Who changed what is looked at while its table is shown, and the profiler's own drawing is no part of the frame it shows",
            plan.count
        )],
        ..Report::new("profile", &["the processor".to_owned()])
    })
}

/// Microseconds of each engine's frames, one of each in turn, forwards and backwards.
fn micros_in_turn<const N: usize>(
    engines: [&mut Engine; N],
    frames: u64,
) -> Result<[Vec<f64>; N], Failure> {
    let mut micros = [const { Vec::new() }; N];
    for frame in 0..WARM_UP + frames {
        for turn in 0..N {
            let which = if frame % 2 == 0 { turn } else { N - 1 - turn };
            let start = Instant::now();
            advance(engines[which], frame)?;
            if frame >= WARM_UP {
                micros[which].push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
    }
    Ok(micros)
}

/// An engine with the overlay of a window, and the profiler open in it or not.
fn with_panels(plan: Plan, open: bool) -> Engine {
    let mut engine = Crowd::new(plan).engine;
    engine
        .add_plugin(input::plugin)
        .add_plugin(present::plugin)
        .add_plugin(editor::plugin);
    engine.world.resource_mut::<EditorState>().profiler = open;
    engine
}
