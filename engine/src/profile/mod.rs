//! What the last frame cost: a span for every system, the tracer's passes, rays by kind, frame times.
//!
//! No scope is written by hand: bevy_ecs opens a tracing span around each system it runs, and
//! [`SystemSpans`], a layer of the tracing subscriber, notes when. [`install`] must come before the
//! engine is built, because a system's span is made together with the system; without it everything
//! here but [`Profile::spans`] still works.
//!
//! [`Profile`] is written in [`FrameSet::Report`] and holds that same frame: every system up to and with
//! the one that writes it.

mod error;
mod history;
mod layer;

pub use error::PictureError;
pub use history::{FrameHistory, HISTORY_FRAMES, percentile_of_sorted};
pub use layer::{SystemSpans, install};

use std::sync::Arc;
use std::time::Instant;

use bevy_ecs::prelude::*;

use crate::app::Engine;
use crate::schedule::FrameSet;
use crate::time::Time;
use crate::trace::{ActiveTracer, Counters, OtherPasses, PassTime};

/// One run of one system.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// The system's function, module paths left out: `propagate<GlobalTransform>`.
    pub name: Arc<str>,
    /// Microseconds from the frame's start to the system's.
    pub start_micros: f64,
    /// Microseconds the system ran.
    pub micros: f64,
}

/// The last frame in numbers.
#[derive(Resource, Debug, Default)]
pub struct Profile {
    /// Systems in the order they ran. Empty unless [`install`] came before the engine.
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

/// Adds the [`Profile`] (sets [`FrameSet::Input`] and [`FrameSet::Report`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Profile>();
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
    tracer: Res<ActiveTracer>,
    others: Res<OtherPasses>,
    mut profile: ResMut<Profile>,
) {
    let profile = &mut *profile;
    layer::drain(start.0, &mut profile.spans);
    profile.passes.clear();
    if let Some(tracer) = &tracer.0 {
        profile.passes = tracer.pass_times();
        profile.counters = tracer.counters();
    }
    profile.passes.extend_from_slice(&others.0);
    profile.frame_millis = start.0.elapsed().as_secs_f64() * 1e3;
    // The first frame's interval is the time since the engine was built, which is no frame time.
    if time.frame > 1 {
        profile.history.push(time.wall_delta_secs * 1e3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing_subscriber::layer::SubscriberExt;

    fn slow_system() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }

    fn profiled_frames(frames: usize) -> Engine {
        // A log layer beside the profiler, as in the real program: spans must not depend on its filter.
        let log = tracing_subscriber::fmt::layer().with_writer(std::io::sink);
        let subscriber = tracing_subscriber::registry().with(SystemSpans).with(log);
        tracing::subscriber::with_default(subscriber, || {
            let mut engine = Engine::new();
            engine.add_plugin(plugin);
            engine.add_systems(FrameSet::Simulate, slow_system);
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

    #[test]
    fn passes_that_are_not_the_tracers_are_told_once() {
        let mut engine = Engine::new();
        engine.add_plugin(plugin);
        let present = PassTime {
            name: "present",
            millis: 0.25,
        };
        let passes = vec![present];
        engine.world.resource_mut::<OtherPasses>().0 = passes.clone();
        for _ in 0..2 {
            engine.frame();
            assert_eq!(engine.world.resource::<Profile>().passes, passes);
        }
    }

    #[test]
    fn spans_are_in_order_and_inside_the_frame() {
        let engine = profiled_frames(2);
        let profile = engine.world.resource::<Profile>();
        for pair in profile.spans.windows(2) {
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
