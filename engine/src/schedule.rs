//! The order of a frame, on one page.
//!
//! Every system belongs to one of these sets; they run from top to bottom. Inside a set, systems that
//! touch the same data are chained by hand: [`crate::Engine::validate`] refuses an ambiguous pair.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};

/// Label of the one schedule there is.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Frame;

/// What a frame does, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameSet {
    /// Window events and the clock become `Input` and `Time`.
    Input,
    /// Motion components pose what they move, then the timeline what the scene keys (any field of any entity), then
    /// clips the nodes of models.
    Animate,
    /// Game rules write transforms, materials and lights.
    Simulate,
    /// Editor panels and queued edits write components and settings.
    Edit,
    /// The hierarchy hands poses and visibility down changed subtrees.
    Propagate,
    /// Changed rows of the world become rows of the `FrameScene`.
    Extract,
    /// The tracer builds the trees of meshes that are new or changed.
    Refit,
    /// The tracer packs its f32 rows and builds the tree over instances if any moved; changed ranges go to the
    /// device.
    Upload,
    /// The tracer makes the picture.
    Trace,
    /// Tone map, overlay, swap chain or file.
    Present,
    /// Spans, GPU timestamps and counters become the `Profile`.
    Report,
}

/// An empty frame: sets chained, ambiguity an error, one thread (systems go parallel inside).
pub fn frame_schedule() -> Schedule {
    use FrameSet::{
        Animate, Edit, Extract, Input, Present, Propagate, Refit, Report, Simulate, Trace, Upload,
    };
    let mut schedule = Schedule::new(Frame);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    });
    schedule.configure_sets(
        (
            Input, Animate, Simulate, Edit, Propagate, Extract, Refit, Upload, Trace, Present,
            Report,
        )
            .chain(),
    );
    schedule
}
