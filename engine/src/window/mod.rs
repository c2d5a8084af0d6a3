//! The window: opens, feeds the frame with input, presents, and says what it is doing in its title.
//!
//! [`display_available`] tells beforehand, without a panic, whether a window can open at all.
//! [`run`] then owns the thread until the window is closed.

mod app;
mod budget;
mod commands;
mod devices;
mod display;
mod dropped;
mod resolution;
mod router;
mod title;
mod work;

pub use display::display_available;
pub use resolution::SLOW_TARGET_MILLIS;

use std::fmt;
use std::path::PathBuf;

use glam::UVec2;
use winit::event_loop::EventLoop;

use crate::app::Engine;
use crate::input::KeyMap;
use crate::time::Clock;
use crate::trace::gpu::AdapterChoice;
use crate::trace::{BackendChoice, TraceError};

/// How a window is to be.
#[derive(Clone, Debug)]
pub struct WindowOptions {
    /// The scene, as the title calls it and screenshots are named.
    pub title: String,
    /// The scene's file, which the editor saves to; none: there is none.
    pub file: Option<PathBuf>,
    /// Pixels across and down, at first.
    pub size: UVec2,
    /// Open with the editor's panels.
    pub show_editor: bool,
    /// Wait for the display between frames; false shows frames as fast as they come.
    pub vsync: bool,
    /// Who traces, unless the engine has a tracer already.
    pub backend: BackendChoice,
    /// On which adapter, by number or part of its name; none: the best one.
    pub adapter: Option<String>,
    /// Which keys do what.
    pub key_map: KeyMap,
    /// Folder of screenshots.
    pub screenshots: PathBuf,
    /// Traced pixels for each of the window's, along an axis, in (0, 1]; none: as many as the frame time allows.
    pub resolution_scale: Option<f64>,
    /// Milliseconds that a frame is to take, unless a scale is chosen; none: [`SLOW_TARGET_MILLIS`] on devices that are slow
    /// or show themselves so, and every pixel on others.
    pub target_millis: Option<f64>,
    /// Folder in which compiled pipelines are kept for the next start; none: they are not.
    pub pipelines: Option<PathBuf>,
    /// Sentences to show until they are dismissed: what is wrong with the scene.
    pub issues: Vec<String>,
}

impl Default for WindowOptions {
    fn default() -> Self {
        Self {
            title: "Orrery".into(),
            file: None,
            size: UVec2::new(1280, 720),
            show_editor: false,
            vsync: true,
            backend: BackendChoice::Auto,
            adapter: None,
            key_map: KeyMap::standard(),
            screenshots: "screenshots".into(),
            resolution_scale: None,
            target_millis: None,
            pipelines: None,
            issues: Vec::new(),
        }
    }
}

impl WindowOptions {
    /// Which adapters may present: a named one, or whatever there is; software will do for that.
    fn presenting_adapter(&self) -> AdapterChoice {
        self.adapter
            .clone()
            .map_or(AdapterChoice::Any, AdapterChoice::Named)
    }
}

/// Why there is no window, or no longer one.
#[derive(Clone, Debug, PartialEq)]
pub enum WindowError {
    /// No window can open here, or nothing can present to it: the caller goes on without a display.
    NoDisplay(String),
    /// The tracer that was asked for is not to be had.
    NoTracer(TraceError),
    /// The engine's schedule is wrong.
    Schedule(String),
    /// The device failed while running.
    Device(TraceError),
}

impl fmt::Display for WindowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDisplay(why) => write!(f, "no display: {why}"),
            Self::NoTracer(error) | Self::Device(error) => error.fmt(f),
            Self::Schedule(why) => write!(f, "the frame's systems cannot be ordered: {why}"),
        }
    }
}

impl std::error::Error for WindowError {}

/// Opens a window and runs the engine in it until it is closed. A clock that was never set follows the
/// wall; one that was set to a frame stays there. `after_frame` sees the engine after each frame.
///
/// # Errors
/// See [`WindowError`]; [`WindowError::NoDisplay`] comes before the first frame.
pub fn run(
    mut engine: Engine,
    options: WindowOptions,
    mut after_frame: impl FnMut(&Engine),
) -> Result<(), WindowError> {
    display_available().map_err(WindowError::NoDisplay)?;
    let event_loop = EventLoop::new().map_err(|error| WindowError::NoDisplay(error.to_string()))?;
    add_plugins(&mut engine);
    engine.validate().map_err(WindowError::Schedule)?;
    let mut clock = engine.world.resource_mut::<Clock>();
    // What is edited stands still until it is played.
    if *clock == Clock::Paused && !options.show_editor {
        *clock = Clock::Wall;
    }
    let mut app = app::WindowApp::new(engine, options, &mut after_frame);
    let ended = event_loop.run_app(&mut app);
    match (app.take_error(), ended) {
        (Some(error), _) => Err(error),
        (None, Err(error)) => Err(WindowError::NoDisplay(error.to_string())),
        (None, Ok(())) => Ok(()),
    }
}

/// What a windowed run has over a headless one.
fn add_plugins(engine: &mut Engine) {
    engine
        .add_plugin(crate::input::plugin)
        .add_plugin(crate::present::plugin)
        .add_plugin(crate::editor::plugin)
        .add_plugin(commands::plugin);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_of_a_windowed_run_can_be_ordered() {
        let mut engine = Engine::new();
        engine.add_plugin(crate::profile::plugin);
        add_plugins(&mut engine);
        assert_eq!(engine.validate(), Ok(()));
    }
}
