//! Tracers for tests: opened by name, and one call from a frame to its picture.

use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::{Backend, BackendChoice, Picture, TraceError, Tracer, open_tracer};

/// Opens a tracer. For `gpu` any adapter will do, software Vulkan too: tests are about pictures, not speed.
///
/// # Errors
/// [`TraceError::NoDevice`]: there is no adapter at all. Tests fail then, they do not pass unrun.
pub fn open(backend: Backend) -> Result<Box<dyn Tracer>, TraceError> {
    open_tracer(BackendChoice::Backend(backend), None, None).map(|(tracer, _)| tracer)
}

/// The three steps of the frame and the picture.
///
/// # Errors
/// See [`TraceError`].
pub fn picture(
    tracer: &mut dyn Tracer,
    scene: &FrameScene,
    settings: &TraceSettings,
) -> Result<Picture, TraceError> {
    tracer.refit(scene)?;
    tracer.upload(scene, settings)?;
    tracer.render()?;
    tracer.picture()
}
