//! `orrery render`: exact frames of a scene into picture files.

use glam::UVec2;
use orrery_engine::profile::Profile;

use crate::args::{Common, RenderRequest};
use crate::defects::Defects;
use crate::failure::Failure;
use crate::output::{note, progress, say};
use crate::profile_log::ProfileLog;
use crate::{device, interrupt, stage};

/// Size unless asked otherwise: what most screens show without scaling, and quick enough on a processor.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Renders what was asked for.
pub fn run(request: &RenderRequest, common: &Common) -> Result<(), Failure> {
    let frames = request.frames.clone();
    let count = frames.end - frames.start;
    if count > 1 && !request.out.has_number() {
        return Err(Failure::Usage(format!(
            "{count} frames would share one file: `--out` has no place for the frame number; write it as ####, as in frames/f_####.png"
        )));
    }
    if request.linear16 && !request.out.is_png() {
        return Err(Failure::Usage(
            "`--linear16` is for .png files; .exr files hold linear light already".into(),
        ));
    }
    let todo: Vec<u64> = frames
        .filter(|&frame| !(request.resume && request.out.path(frame).is_file()))
        .collect();
    let mut engine = stage::set(&request.scene, common, SIZE, request.fps)?;
    let mut log = ProfileLog::open(common.profile.as_deref())?;
    stage::cast(&mut engine, device::open(common)?);
    interrupt::listen();
    let mut defects = Defects::default();
    let bar = progress(todo.len() as u64, "rendering");
    for (done, &frame) in todo.iter().enumerate() {
        let picture = stage::picture(&mut engine, frame)?;
        let profile = engine.world.resource::<Profile>();
        log.frame(frame, profile)?;
        defects.add(&picture, &profile.counters);
        let view = stage::view(&engine);
        request
            .out
            .write(frame, &picture, &view, request.linear16)?;
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
    Ok(())
}
