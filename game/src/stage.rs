//! An engine with a scene on it and a tracer before it: what every command that makes pictures needs.

use std::path::Path;

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Skips, TraceSettings, View};
use orrery_engine::import::{Cache, Loader, user_folder};
use orrery_engine::profile::{self, Profile};
use orrery_engine::time::{Clock, Time};
use orrery_engine::trace::{ActiveTracer, Picture, TraceError, TraceFault, Tracer};

use crate::args::Common;
use crate::assets::find_scene;
use crate::failure::Failure;
use crate::output::{note, watch};

/// Puts a scene (a path, or the bare name of one that comes along) into a new engine without a tracer. For measurements:
/// nothing is taken from the cache, and nothing left there.
pub fn set(
    scene: &Path,
    common: &Common,
    size: UVec2,
    frames_per_sec: f64,
) -> Result<Engine, Failure> {
    let (engine, warnings) = load(scene, common, (size, frames_per_sec), Loader::default())?;
    tell(&warnings);
    Ok(engine)
}

/// [`set`] for those who wait: with the user's cache, and a bar where it takes long. With what is odd about the scene,
/// which has been said on stderr already.
pub fn open(
    scene: &Path,
    common: &Common,
    size: UVec2,
    frames_per_sec: f64,
) -> Result<(Engine, Vec<String>), Failure> {
    let loader = Loader {
        cache: user_folder().map(Cache::in_folder),
        ..Loader::default()
    };
    let progress = loader.progress.clone();
    let load = || load(scene, common, (size, frames_per_sec), loader);
    let (engine, warnings) = watch(&progress, load)?;
    tell(&warnings);
    Ok((engine, warnings))
}

fn tell(warnings: &[String]) {
    for warning in warnings {
        note(format_args!("note: {warning}"));
    }
}

/// [`open`] with a loader of the caller's, in silence.
pub fn load(
    scene: &Path,
    common: &Common,
    (size, frames_per_sec): (UVec2, f64),
    loader: Loader,
) -> Result<(Engine, Vec<String>), Failure> {
    let path = find_scene(scene)?;
    let mut engine = Engine::new();
    engine.add_plugin(profile::plugin);
    engine.world.insert_resource(loader);
    let report = orrery_engine::scene::load(&mut engine.world, &path)
        .map_err(|problems| Failure::Input(problems.to_string()))?;
    let warnings: Vec<String> = report.warnings.iter().map(ToString::to_string).collect();
    engine.world.insert_resource(settings(common, size));
    engine.world.resource_mut::<Time>().frames_per_sec = frames_per_sec;
    engine
        .validate()
        .map_err(|why| Failure::Input(format!("the frame's systems cannot be ordered: {why}")))?;
    Ok((engine, warnings))
}

/// How pictures are traced unless the command has its own way: what was asked for, at this size if none was, and no ray
/// counted.
pub fn settings(common: &Common, size: UVec2) -> TraceSettings {
    TraceSettings {
        size: common.size.unwrap_or(size),
        samples: common.samples,
        adaptive: common.adaptive,
        cutoff: common.cutoff,
        max_generations: common.depth,
        count_rays: false,
        skips: common
            .without
            .iter()
            .copied()
            .fold(Skips::ALL, Skips::without),
        ..TraceSettings::default()
    }
}

/// Gives the engine the tracer it renders with from now on.
pub fn cast(engine: &mut Engine, tracer: Box<dyn Tracer>) {
    engine.world.resource_mut::<ActiveTracer>().0 = Some(tracer);
}

/// Runs the frame of that number.
pub fn advance(engine: &mut Engine, frame: u64) -> Result<(), TraceError> {
    *engine.world.resource_mut::<Clock>() = Clock::Frame(frame);
    engine.frame();
    match engine.world.resource_mut::<TraceFault>().0.take() {
        Some(fault) => Err(fault),
        None => Ok(()),
    }
}

/// Runs the frame of that number and hands its picture out. The [`Profile`] then has what this very
/// picture took: when the frame wrote it, a GPU was still at work. A device that is lost over it is opened anew, once.
pub fn picture(engine: &mut Engine, frame: u64) -> Result<Picture, Failure> {
    match traced_frame(engine, frame) {
        Err(TraceError::DeviceLost(why)) => {
            note(format_args!("note: {why}; frame {frame} is traced again"));
            if let Some(tracer) = &mut engine.world.resource_mut::<ActiveTracer>().0 {
                tracer.recover(None)?;
            }
            Ok(traced_frame(engine, frame)?)
        }
        other => Ok(other?),
    }
}

fn traced_frame(engine: &mut Engine, frame: u64) -> Result<Picture, TraceError> {
    advance(engine, frame)?;
    let mut tracer = engine.world.resource_mut::<ActiveTracer>();
    let Some(tracer) = &mut tracer.0 else {
        return Err(TraceError::NoDevice("no tracer was opened".into()));
    };
    let picture = tracer.picture()?;
    let (passes, counters) = (tracer.pass_times(), tracer.counters());
    let mut profile = engine.world.resource_mut::<Profile>();
    (profile.passes, profile.counters) = (passes, counters);
    profile::collect(&mut engine.world);
    Ok(picture)
}

/// A frame's picture by a tracer that stands in no engine.
pub fn traced(
    tracer: &mut dyn Tracer,
    scene: &FrameScene,
    settings: &TraceSettings,
) -> Result<Picture, Failure> {
    tracer.refit(scene)?;
    tracer.upload(scene, settings)?;
    tracer.render()?;
    Ok(tracer.picture()?)
}

/// The eye of the last frame.
pub fn view(engine: &Engine) -> View {
    engine.world.resource::<FrameScene>().view
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use clap::Parser;
    use orrery_engine::trace::gpu::{AdapterChoice, Gpu};
    use orrery_engine::trace::{Backend, BackendChoice, open_tracer};

    use super::*;
    use crate::args::Cli;

    #[test]
    fn a_frame_whose_device_is_lost_is_traced_again() {
        let common = Cli::parse_from(["orrery"]).common;
        let gpu = Gpu::open(Gpu::instance(), &AdapterChoice::Any, None);
        let gpu = Arc::new(gpu.expect("a GPU, or software Vulkan, for the tests"));
        let choice = BackendChoice::Backend(Backend::Gpu);
        let (tracer, _) = open_tracer(choice, None, Some(gpu.clone())).expect("a tracer");
        let scene = Path::new("../assets/scenes/two_spheres.ron");
        let mut engine = set(scene, &common, UVec2::new(64, 36), 30.0).expect("a scene");
        cast(&mut engine, tracer);
        let before = picture(&mut engine, 7).expect("a picture");
        gpu.device.destroy();
        let after = picture(&mut engine, 7).expect("the same picture");
        assert!(before == after);
    }
}
