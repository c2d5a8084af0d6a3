//! What the last frame cost: a span for every system, the tracer's passes, rays by kind, frame times.
//!
//! No scope is written by hand: bevy_ecs opens a tracing span around each system it runs, and
//! [`SystemSpans`], a layer of the tracing subscriber, notes when. [`install`] must come before the
//! engine is built, because a system's span is made together with the system; without it everything
//! here but [`Profile::spans`] still works.
//!
//! [`Profile`] and the newest of [`Frames`] are written in [`FrameSet::Report`] and hold that same frame: every system up to
//! and with the one that writes it. What a device did for a frame comes back frames later, and is then added to that frame.

mod align;
mod blame;
mod entities;
mod error;
pub mod export;
mod frame;
mod frames;
mod history;
mod layer;
pub mod ledger;

pub use blame::{Blame, blame, costs};
pub use entities::{EntityCost, EntityCosts};
pub use error::PictureError;
pub use frame::{Frame, Pass, Span};
pub use frames::{Frames, SETTLING_FRAMES, Stop, WORST_FRAMES};
pub use history::{FrameHistory, HISTORY_FRAMES, percentile_of_sorted};
pub(crate) use layer::forget;
pub use layer::{SystemSpans, install};
pub use ledger::{Change, Ledger};

use std::time::Instant;

use bevy_ecs::prelude::*;

use self::frame::{nest, step};
use crate::app::Engine;
use crate::schedule::FrameSet;
use crate::time::Time;
use crate::trace::{ActiveTracer, Counters, OtherPasses, PassTime};

/// The last frame in numbers.
#[derive(Resource, Debug, Default)]
pub struct Profile {
    /// Systems and their steps in the order they ran. Empty unless [`install`] came before the engine.
    pub spans: Vec<Span>,
    /// The tracer's passes in order, then what presents; on a GPU, of the last picture that has come back.
    pub passes: Vec<PassTime>,
    /// What tracing took; on a GPU, of the last picture that has come back.
    pub counters: Counters,
    /// Milliseconds of work, from the frame's first system to the report; waiting for the display is
    /// in it only where a system waits.
    pub frame_millis: f64,
    /// Times from one frame's start to the next one's.
    pub history: FrameHistory,
}

/// When this frame began.
#[derive(Resource, Debug)]
struct FrameStart(Instant);

/// Adds the [`Profile`] and the [`Frames`] (sets [`FrameSet::Input`] and [`FrameSet::Report`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Profile>();
    engine.world.init_resource::<Frames>();
    engine.world.init_resource::<Ledger>();
    engine.world.init_resource::<EntityCosts>();
    engine.world.insert_resource(FrameStart(Instant::now()));
    engine.add_systems(FrameSet::Input, begin_frame);
    engine.add_systems(FrameSet::Report, report_frame);
}

fn begin_frame(mut start: ResMut<FrameStart>) {
    start.0 = Instant::now();
}

fn report_frame(
    start: Res<FrameStart>,
    time: Res<Time>,
    mut tracer: ResMut<ActiveTracer>,
    mut others: ResMut<OtherPasses>,
    mut profile: ResMut<Profile>,
    mut frames: ResMut<Frames>,
) {
    let profile = &mut *profile;
    layer::drain(start.0, &mut profile.spans);
    profile.passes.clear();
    let mut on_device = false;
    if let Some(tracer) = &tracer.0 {
        profile.passes = tracer.pass_times();
        profile.counters = tracer.counters();
        on_device = tracer.device_millis().is_some();
    }
    profile.passes.extend_from_slice(&others.passes);
    let steps = profile.passes.iter().chain(&others.waits);
    profile
        .spans
        .extend(steps.filter_map(|pass| step(pass, start.0)));
    nest(&mut profile.spans);
    profile.frame_millis = start.0.elapsed().as_secs_f64() * 1e3;
    // The first frame's interval is the time since the engine was built, which is no frame time.
    if time.frame > 1 {
        profile.history.push(time.wall_delta_secs * 1e3);
    }
    let waited = others.waits.drain(..).map(|wait| wait.millis * 1e3).sum();
    let frame = captured(&mut frames, profile, start.0);
    frames.push(Frame {
        id: time.frame,
        secs: time.secs,
        wait_micros: waited,
        awaits_device: on_device && profile.counters.kept_samples == 0,
        counters: match on_device {
            true => profile.counters.with_rays_of(Counters::default()),
            false => profile.counters,
        },
        ..frame
    });
    take_reports(&mut tracer, &mut others, &mut frames);
}

/// The frame whose spans these are, in the room of one that was forgotten; its time begins with its first system.
fn captured(frames: &mut Frames, profile: &Profile, start: Instant) -> Frame {
    let mut frame = frames.take_spare();
    frame.spans.clone_from(&profile.spans);
    frame.passes.clear();
    // Systems ahead of the one that notes the start.
    let first = frame.spans.first().map_or(0.0, |span| span.start_micros);
    let ahead = first.min(0.0);
    for span in &mut frame.spans {
        span.start_micros -= ahead;
    }
    Frame {
        start_micros: frames.micros(start) + ahead,
        micros: profile.frame_millis * 1e3 - ahead,
        interval_micros: 0.0,
        ..frame
    }
}

/// Adds what devices have told since to the frames it is of. Whoever waits for a picture calls it then: it has come back
/// after the frame's report.
pub fn collect(world: &mut World) {
    world.resource_scope(|world, mut frames: Mut<Frames>| {
        world.resource_scope(|world, mut others: Mut<OtherPasses>| {
            let mut tracer = world.resource_mut::<ActiveTracer>();
            take_reports(&mut tracer, &mut others, &mut frames);
        });
    });
}

fn take_reports(tracer: &mut ActiveTracer, others: &mut OtherPasses, frames: &mut Frames) {
    let told = tracer.0.as_mut().map(|tracer| tracer.take_device_reports());
    for report in told.into_iter().flatten().chain(others.reports.drain(..)) {
        frames.note_device(&report);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    use tracing::Dispatch;
    use tracing_subscriber::layer::SubscriberExt;

    /// Where one subscriber alone is alive, tracing asks that of the thread that meets a span first whether anybody wants it, and
    /// other tests' threads have none. With this one beside it, all are asked.
    static BESIDE: LazyLock<Dispatch> =
        LazyLock::new(|| Dispatch::new(tracing_subscriber::registry().with(SystemSpans)));

    fn slow_system() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }

    fn profiled_frames(frames: usize) -> Engine {
        // A log layer beside the profiler, as in the real program: spans must not depend on its filter.
        let log = tracing_subscriber::fmt::layer().with_writer(std::io::sink);
        LazyLock::force(&BESIDE);
        let subscriber = tracing_subscriber::registry().with(SystemSpans).with(log);
        tracing::subscriber::with_default(subscriber, || {
            let mut engine = Engine::new();
            engine.add_plugin(plugin);
            engine.add_systems(FrameSet::Simulate, slow_system);
            let before = tracing::info_span!("system", name = "a::before_the_frame");
            before.in_scope(|| ());
            for _ in 0..frames {
                engine.frame();
            }
            engine
        })
    }

    #[test]
    fn every_system_has_a_span_with_a_readable_name() {
        let engine = profiled_frames(3);
        let spans = &engine.world.resource::<Profile>().spans;
        let names: Vec<&str> = spans.iter().map(|s| &*s.name).collect();
        for expected in [
            "begin_frame",
            "slow_system",
            "propagate<GlobalTransform>",
            "propagate<GlobalVisibility>",
            "extract_instances",
            "trace_picture",
            "report_frame",
        ] {
            let count = names.iter().filter(|n| **n == expected).count();
            assert_eq!(count, 1, "spans named {expected} among {names:?}");
        }
        assert!(spans.iter().all(|s| s.micros > 0.0), "{spans:?}");
        assert!(!names.iter().any(|n| n.contains("::")), "{names:?}");
    }

    #[derive(Resource)]
    struct SpikeAt(u64);

    fn innocent_system() {
        std::thread::sleep(std::time::Duration::from_micros(300));
    }

    fn moody_system(time: Res<Time>, at: Res<SpikeAt>) {
        if time.frame == at.0 {
            std::thread::sleep(std::time::Duration::from_millis(150));
        }
    }

    #[test]
    fn a_spike_in_one_system_is_found_with_its_frame() {
        LazyLock::force(&BESIDE);
        let subscriber = tracing_subscriber::registry().with(SystemSpans);
        tracing::subscriber::with_default(subscriber, || {
            let mut engine = Engine::new();
            engine.add_plugin(plugin);
            engine.world.insert_resource(SpikeAt(23));
            engine
                .world
                .resource_mut::<Frames>()
                .set_spike_limit(Some(140.0));
            engine.add_systems(FrameSet::Simulate, (innocent_system, moody_system).chain());
            for _ in 0..40 {
                engine.frame();
            }
            let frames = engine.world.resource::<Frames>();
            assert_eq!(frames.stopped(), Some(Stop::Spike(23)));
            assert_eq!(frames.worst()[0].id, 23);
            let frame = frames.get(23).expect("it is held");
            let found = blame(frame, frames.iter()).expect("systems ran");
            assert_eq!(&*found.name, "moody_system");
            assert!(
                found.micros >= 150e3 && found.usual_micros < 10e3,
                "{found:?}"
            );
        });
    }

    #[test]
    fn frames_begin_with_their_first_system_and_hold_all_of_it() {
        let engine = profiled_frames(5);
        let frames = engine.world.resource::<Frames>();
        let ids: Vec<u64> = frames.iter().map(|frame| frame.id).collect();
        assert_eq!(ids, [1, 2, 3, 4, 5]);
        for frame in frames.iter() {
            assert!(frame.spans.iter().all(|span| span.start_micros >= 0.0));
            let last = frame.spans.iter().map(Span::end_micros).fold(0.0, f64::max);
            assert!(last <= frame.micros, "{last} {}", frame.micros);
        }
        let mut spans = frames.iter().flat_map(|frame| &frame.spans);
        let is_foreign = spans.any(|span| &*span.name == "before_the_frame");
        assert!(
            !is_foreign,
            "what ran before the first frame is no part of it"
        );
        let starts: Vec<f64> = frames.iter().map(|frame| frame.start_micros).collect();
        assert!(starts.is_sorted(), "{starts:?}");
    }

    #[test]
    fn passes_that_are_not_the_tracers_are_told_once() {
        let mut engine = Engine::new();
        engine.add_plugin(plugin);
        let present = PassTime {
            name: "present",
            millis: 0.25,
            start: None,
        };
        let passes = vec![present];
        engine.world.resource_mut::<OtherPasses>().passes = passes.clone();
        for _ in 0..2 {
            engine.frame();
            assert_eq!(engine.world.resource::<Profile>().passes, passes);
        }
    }

    #[test]
    fn spans_are_in_order_and_inside_the_frame() {
        let engine = profiled_frames(2);
        let profile = engine.world.resource::<Profile>();
        let systems: Vec<_> = profile.spans.iter().filter(|s| s.depth == 0).collect();
        for pair in systems.windows(2) {
            assert!(
                pair[0].start_micros + pair[0].micros <= pair[1].start_micros + 1.0,
                "{pair:?} overlap"
            );
        }
        let slow = profile.spans.iter().find(|s| &*s.name == "slow_system");
        assert!(slow.is_some_and(|s| s.micros >= 2000.0), "{slow:?}");
        assert!(profile.frame_millis >= 2.0);
        assert_eq!(profile.history.len(), 1);
    }
}
