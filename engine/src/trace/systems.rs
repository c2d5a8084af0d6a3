//! The tracer's place in the frame: refit, upload, trace.

use bevy_ecs::prelude::*;

use super::{DeviceReport, PassTime, TraceError, Tracer};
use crate::app::Engine;
use crate::frame::{FrameScene, TraceSettings};
use crate::schedule::FrameSet;
use crate::time::Time;

/// The tracer in use; none: frames run without a picture.
#[derive(Resource, Default)]
pub struct ActiveTracer(pub Option<Box<dyn Tracer>>);

/// What went wrong in this frame's tracing; whoever drives the frame looks here after it.
#[derive(Resource, Default, Debug)]
pub struct TraceFault(pub Option<TraceError>);

/// What is not the tracer's, for the profile; whoever runs it keeps it here.
#[derive(Resource, Default, Debug)]
pub struct OtherPasses {
    /// Times of device passes, of the last that have come back.
    pub passes: Vec<PassTime>,
    /// When this frame waited for the display, and how long.
    pub waits: Vec<PassTime>,
    /// What the device has told since the profile last looked.
    pub reports: Vec<DeviceReport>,
}

/// Adds the three steps (sets [`FrameSet::Refit`], [`FrameSet::Upload`], [`FrameSet::Trace`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<ActiveTracer>();
    engine.world.init_resource::<TraceFault>();
    engine.world.init_resource::<OtherPasses>();
    engine.add_systems(FrameSet::Refit, refit_trees);
    engine.add_systems(FrameSet::Upload, upload_rows);
    engine.add_systems(FrameSet::Trace, trace_picture);
}

fn refit_trees(
    time: Res<Time>,
    scene: Res<FrameScene>,
    mut tracer: ResMut<ActiveTracer>,
    mut fault: ResMut<TraceFault>,
) {
    if let Some(tracer) = &mut tracer.0 {
        tracer.begin_frame(time.frame);
        fault.0 = tracer.refit(&scene).err();
    }
}

fn upload_rows(
    scene: Res<FrameScene>,
    settings: Res<TraceSettings>,
    mut tracer: ResMut<ActiveTracer>,
    mut fault: ResMut<TraceFault>,
) {
    if let (Some(tracer), None) = (&mut tracer.0, &fault.0) {
        fault.0 = tracer.upload(&scene, &settings).err();
    }
}

fn trace_picture(mut tracer: ResMut<ActiveTracer>, mut fault: ResMut<TraceFault>) {
    if let (Some(tracer), None) = (&mut tracer.0, &fault.0) {
        fault.0 = tracer.render().err();
    }
}
