//! `orrery [SCENE]` and `orrery edit SCENE`: a window where there is a display, else a preview in files.

use std::path::Path;

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::import::pipelines_folder;
use orrery_engine::input::KeyMap;
use orrery_engine::window::{WindowError, WindowOptions, display_available, run as run_window};

use crate::args::{Common, WindowArgs};
use crate::assets::find_scene;
use crate::failure::Failure;
use crate::output::{note, say};
use crate::profile_log::ProfileLog;
use crate::{assets, device, preview, stage};

/// Size of the window unless asked otherwise.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Whether the editor is open at first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The picture alone.
    Play,
    /// With the editor.
    Edit,
}

/// Plays a scene; none: the demo.
pub fn run(
    scene: Option<&Path>,
    common: &Common,
    window: &WindowArgs,
    mode: Mode,
) -> Result<(), Failure> {
    let scene = scene.unwrap_or(Path::new(assets::DEMO));
    if let Err(why) = display_available() {
        say(format_args!("no display ({why}): a preview instead"));
        return preview::run(scene, common);
    }
    let (mut engine, issues) = stage::open(scene, common, SIZE, 30.0)?;
    engine.world.resource_mut::<TraceSettings>().refine_to = window.refine;
    let mut log = ProfileLog::open(common)?;
    log.watch(&mut engine);
    let defaults = WindowOptions::default();
    let options = WindowOptions {
        title: scene
            .file_stem()
            .map_or(defaults.title, |stem| stem.to_string_lossy().into_owned()),
        file: find_scene(scene).ok(),
        size: common.size.unwrap_or(SIZE),
        show_editor: mode == Mode::Edit,
        backend: device::wanted(common.backend),
        adapter: common.adapter.clone(),
        key_map: KeyMap::named(&window.keys).unwrap_or(defaults.key_map),
        vsync: !window.no_vsync,
        resolution_scale: window.scale,
        target_millis: window.target_ms,
        pipelines: pipelines_folder(),
        issues,
        ..WindowOptions::default()
    };
    let mut unwritten = None;
    let after_frame = |engine: &Engine| {
        if unwritten.is_none() {
            // What cannot be written is said at once, not when the window closes.
            let written = log.frame(engine).inspect_err(|failure| note(failure));
            unwritten = written.err();
        }
    };
    match run_window(engine, options, after_frame) {
        Ok(()) => unwritten.map_or_else(|| log.finish(), Err),
        Err(WindowError::NoDisplay(why)) => {
            say(format_args!("no display ({why}): a preview instead"));
            preview::run(scene, common)
        }
        Err(WindowError::NoTracer(error) | WindowError::Device(error)) => Err(error.into()),
        Err(error @ WindowError::Schedule(_)) => Err(Failure::Input(error.to_string())),
    }
}
