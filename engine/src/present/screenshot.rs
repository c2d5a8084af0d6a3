//! Saves what is seen, without the overlay: the tracer's picture through exposure and tone curve.

use std::path::PathBuf;

use bevy_ecs::prelude::*;

use super::files::write_png8;
use crate::frame::FrameScene;
use crate::trace::{ActiveTracer, TraceFault};

/// A picture somebody asked for, and what became of it.
#[derive(Resource, Debug, Default)]
pub struct Screenshot {
    /// Where this frame's picture is to go.
    pub wanted: Option<PathBuf>,
    /// Where it went, or a sentence that says why it did not; whoever tells the user takes it.
    pub outcome: Option<Result<PathBuf, String>>,
}

pub(super) fn save_screenshot(
    mut shot: ResMut<Screenshot>,
    mut tracer: ResMut<ActiveTracer>,
    fault: Res<TraceFault>,
    scene: Res<FrameScene>,
) {
    let Some(path) = shot.wanted.take() else {
        return;
    };
    let view = &scene.view;
    let picture = match (&mut tracer.0, &fault.0) {
        (Some(tracer), None) => tracer.picture().map_err(|error| error.to_string()),
        (_, Some(error)) => Err(error.to_string()),
        (None, None) => Err("there is no tracer, so there is no picture".into()),
    };
    let saved = picture.and_then(|picture| {
        write_png8(&path, &picture, view.exposure, view.tone_map).map_err(|e| e.to_string())
    });
    shot.outcome = Some(saved.map(|()| path));
}
