//! `orrery render`: exact frames of a scene into picture files.

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::present::{Developed, MOST_VOLUMES, wireframe};
use orrery_engine::profile::Profile;
use orrery_engine::trace::{ActiveTracer, Backend, Level, Picture};

use crate::args::{Common, RenderRequest};
use crate::defects::Defects;
use crate::failure::Failure;
use crate::output::{note, progress, say};
use crate::profile_log::ProfileLog;
use crate::{device, explain, heat, interrupt, stage, video};

/// Size unless asked otherwise: what most screens show without scaling, and quick enough on a processor.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Renders what was asked for.
pub fn run(request: &RenderRequest, common: &Common) -> Result<(), Failure> {
    if let Some(pixel) = request.explain {
        return explain::run(pixel, request, common, SIZE);
    }
    let frames = request.frames.clone();
    let count = frames.end - frames.start;
    if count > 1 && !request.out.has_number() {
        return Err(Failure::Usage(format!(
            "{count} frames would share one file: `--out` has no place for the frame number; write it as ####, as in frames/f_####.png"
        )));
    }
    if let Some(heat) = request.heat {
        return heat::run(heat, request, common, SIZE);
    }
    if request.linear16 && !request.out.is_png() {
        return Err(Failure::Usage(
            "`--linear16` is for .png files; .exr files hold linear light already".into(),
        ));
    }
    if request.levels.is_some() && (request.linear16 || !request.out.is_png()) {
        return Err(Failure::Usage(
            "`--levels` draws over what a display would show: it is for .png files without `--linear16`".into(),
        ));
    }
    if let Some(film) = &request.video {
        video::check(film, &request.out)?;
    }
    let todo: Vec<u64> = frames
        .clone()
        .filter(|&frame| !(request.resume && request.out.path(frame).is_file()))
        .collect();
    let (mut engine, _) = stage::open(&request.scene, common, SIZE, request.fps)?;
    let mut log = ProfileLog::open(common)?;
    log.watch(&mut engine);
    let tracer = device::open(common)?;
    if request.levels.is_some() && tracer.backend() == Backend::Reference {
        return Err(no_trees());
    }
    stage::cast(&mut engine, tracer);
    interrupt::listen();
    let mut defects = Defects::default();
    let bar = progress(todo.len() as u64, "rendering");
    for (done, &frame) in todo.iter().enumerate() {
        let picture = stage::picture(&mut engine, frame)?;
        log.frame(&engine)?;
        let profile = engine.world.resource::<Profile>();
        defects.add(&picture, &profile.counters);
        let view = stage::view(&engine);
        match request.levels {
            Some(level) => {
                let developed = with_levels(&engine, &picture, level)?;
                request.out.write_developed(frame, &developed)?;
            }
            None => request
                .out
                .write(frame, &picture, &view, request.linear16)?,
        }
        bar.inc(1);
        if interrupt::asked() && done + 1 < todo.len() {
            bar.abandon();
            log.finish()?;
            defects.tell();
            return Err(Failure::Interrupted(format!(
                "stopped after frame {frame}; the same command with --resume goes on from there"
            )));
        }
    }
    bar.finish_and_clear();
    log.finish()?;
    defects.tell();
    let skipped = count - todo.len() as u64;
    if skipped > 0 {
        note(format_args!("{skipped} of {count} were there already"));
    }
    match (todo.first(), todo.last()) {
        (Some(&first), Some(&last)) if first != last => say(format_args!(
            "{} pictures: {} to {}",
            todo.len(),
            request.out.path(first).display(),
            request.out.path(last).display()
        )),
        (Some(&only), _) => say(request.out.path(only).display()),
        _ => say("nothing left to do"),
    }
    if let Some(film) = &request.video {
        video::make(film, &request.out, &frames, request.fps)?;
        say(film.display());
    }
    Ok(())
}

/// The picture with a level of the trees over it, and how many volumes that are on stderr.
fn with_levels(engine: &Engine, picture: &Picture, level: Level) -> Result<Developed, Failure> {
    let tracer = &engine.world.resource::<ActiveTracer>().0;
    let tracer = tracer.as_ref();
    let shown = tracer.and_then(|tracer| tracer.hierarchy(level, None, MOST_VOLUMES));
    let shown = shown.ok_or_else(no_trees)?;
    note(shown.words(level));
    let view = stage::view(engine);
    let mut developed = Developed::new(picture, view.exposure, view.tone_map);
    developed.draw(&wireframe(&shown.volumes, level, &view));
    Ok(developed)
}

fn no_trees() -> Failure {
    Failure::Usage(
        "`--levels` shows the trees of the backends gpu and cpu; the reference keeps others".into(),
    )
}
