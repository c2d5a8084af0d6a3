//! The scene's file: save, save as, revert, and what is written beside it so that a crash loses little.
//!
//! A file is written whole or not at all: beside its place first, then renamed. While edits are unsaved a copy is written
//! beside the file every half minute; saving takes it away. Where one is found when a scene is opened, it is offered.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;

use super::Notices;
use super::history::History;
use crate::scene::{self, LoadReport, Problems};
use crate::time::Time;

/// How often unsaved edits are written beside the file.
const EVERY: Duration = Duration::from_secs(30);

/// Where the scene came from, and where it goes.
#[derive(Resource, Debug, Default)]
pub struct Document {
    /// The scene's file; none: it came from a model's, and has none of its own yet.
    pub path: Option<PathBuf>,
    /// The folder that paths in the world are from: that of the file that was loaded.
    pub base: PathBuf,
    /// What is being typed as a path, while one is asked for.
    pub asked: Option<Asked>,
    /// A copy of unsaved edits that an earlier run left.
    pub left: Option<PathBuf>,
    /// The state that was last written beside the file, and when.
    copied: Option<(u64, Instant)>,
    /// Files that were there before this run wrote over them have a copy.
    kept: Vec<PathBuf>,
    /// How often this run saved.
    saves: u64,
}

/// A path that is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// What has been typed.
    pub typed: String,
    /// A model to add; false: where to save to.
    pub adds: bool,
}

impl Document {
    /// The document of a file that was opened; a model's file is not one that a scene can be saved to.
    pub fn of(file: &Path) -> Self {
        let is_scene = file.extension().is_some_and(|ending| ending == "ron");
        let path = is_scene.then(|| file.to_owned());
        let left = path.as_deref().and_then(left_copy);
        let kept = Vec::new();
        Self {
            path,
            left,
            kept,
            base: folder_of(file),
            ..Self::default()
        }
    }
}

impl Document {
    /// How often this run saved: another number after each time.
    pub fn saves(&self) -> u64 {
        self.saves
    }
}

/// `scene.ron` to `.scene.autosave.ron`, in the same folder, so that what it names is found from there.
fn copy_path(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    scene.with_file_name(format!(".{stem}.autosave.ron"))
}

/// The copy of a scene that a run left that did not end well: one that is younger than the scene.
fn left_copy(scene: &Path) -> Option<PathBuf> {
    let copy = copy_path(scene);
    let written = std::fs::metadata(&copy).and_then(|file| file.modified());
    let saved = std::fs::metadata(scene).and_then(|file| file.modified());
    match (written, saved) {
        (Ok(written), Ok(saved)) if written >= saved => Some(copy),
        (Ok(_), Err(_)) => Some(copy),
        _ => None,
    }
}

/// Writes a file whole or not at all.
///
/// # Errors
/// A sentence that names the file.
pub fn write_whole(path: &Path, text: &str) -> Result<(), String> {
    // What a link names is written, not the link.
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let beside = target.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let written = std::fs::File::create(&beside).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        std::fs::rename(&beside, &target)
    });
    written.map_err(|error| {
        // It may never have come to be.
        let _ = std::fs::remove_file(&beside);
        format!("{} cannot be written: {error}", path.display())
    })
}

/// Saves to the scene's file, or asks for one.
pub fn save(world: &mut World) {
    match world.resource::<Document>().path.clone() {
        Some(path) => save_to(world, &path),
        None => ask(world),
    }
}

/// Asks where to save to.
pub fn ask(world: &mut World) {
    let mut document = world.resource_mut::<Document>();
    let path = document.path.clone();
    let proposed = path.unwrap_or_else(|| "scene.ron".into());
    document.asked = Some(Asked {
        typed: proposed.to_string_lossy().into_owned(),
        adds: false,
    });
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().map(Path::to_owned).unwrap_or_default()
}

/// The scene's text for a file: what it names is found from that file's folder.
fn text_for(world: &mut World, path: &Path) -> String {
    let mut scene = scene::describe(world);
    let (from, to) = (world.resource::<Document>().base.clone(), folder_of(path));
    if from != to {
        scene.rebase(&from, &to);
    }
    scene::text_of(&scene)
}

/// Saves to a file, which is the scene's from then on.
pub fn save_to(world: &mut World, path: &Path) {
    let text = text_for(world, path);
    if let Err(why) = keep_original(world, path).and_then(|()| write_whole(path, &text)) {
        world.resource_mut::<Notices>().issues.push(why);
        return;
    }
    let old = {
        let mut document = world.resource_mut::<Document>();
        document.copied = None;
        document.left = None;
        document.asked = None;
        document.saves += 1;
        document.path.replace(path.to_owned())
    };
    // There need not be one.
    let _ = std::fs::remove_file(copy_path(&old.unwrap_or_else(|| path.to_owned())));
    world.resource_mut::<History>().note_saved();
    let mut notices = world.resource_mut::<Notices>();
    notices.toast(format!("Saved {}", path.display()));
}

/// A file written by hand has comments, which saving does not know: what was there before this run stays beside it.
fn keep_original(world: &mut World, path: &Path) -> Result<(), String> {
    if world
        .resource::<Document>()
        .kept
        .iter()
        .any(|kept| kept == path)
        || !path.exists()
    {
        return Ok(());
    }
    let mut name = path.as_os_str().to_owned();
    name.push(".bak");
    std::fs::copy(path, &name)
        .map_err(|error| format!("{} cannot be copied: {error}", path.display()))?;
    world.resource_mut::<Document>().kept.push(path.to_owned());
    Ok(())
}

/// Loads the scene's file again, and forgets what was done since it was saved.
pub fn revert(world: &mut World) {
    let Some(path) = world.resource::<Document>().path.clone() else {
        let mut notices = world.resource_mut::<Notices>();
        return notices.toast("This scene has no file of its own yet");
    };
    if put(world, &path) {
        drop_copy(world);
        world
            .resource_mut::<Notices>()
            .toast(format!("Back to {}", path.display()));
    }
}

/// Takes up the edits that an earlier run left; they are unsaved.
pub fn recover(world: &mut World) {
    let Some(copy) = world.resource_mut::<Document>().left.take() else {
        return;
    };
    if put(world, &copy) {
        world.resource_mut::<History>().note_unsaved();
        world
            .resource_mut::<Notices>()
            .toast("Recovered; not saved yet");
    }
}

/// Lets go of the edits that an earlier run left.
pub fn drop_copy(world: &mut World) {
    let mut document = world.resource_mut::<Document>();
    document.left = None;
    document.copied = None;
    if let Some(path) = &document.path {
        // There need not be one.
        let _ = std::fs::remove_file(copy_path(path));
    }
}

/// Puts a file's scene in place of the one that is there, at the same time; false: it stays, and why is said.
pub(super) fn put(world: &mut World, path: &Path) -> bool {
    let is_there = put_loaded(world, |world| scene::load(world, path));
    if is_there {
        world.resource_mut::<Document>().base = folder_of(path);
    }
    is_there
}

/// Reads all files anew that the scene names; see [`put`].
pub(super) fn put_again(world: &mut World) -> bool {
    let text = scene::save(world);
    let file = world.resource::<Document>().base.join("scene.ron");
    put_loaded(world, |world| scene::load_text(world, &text, &file))
}

fn put_loaded(
    world: &mut World,
    load: impl FnOnce(&mut World) -> Result<LoadReport, Problems>,
) -> bool {
    let secs = world.resource::<Time>().secs;
    match load(world) {
        Ok(_) => {
            super::scene_replaced(world);
            world.resource_mut::<Time>().secs = secs;
            true
        }
        Err(problems) => {
            let problems = problems.0.iter().map(ToString::to_string).collect();
            world.resource_mut::<Notices>().issues = problems;
            false
        }
    }
}

/// Writes unsaved edits beside the file if it is time to; a system of [`crate::schedule::FrameSet::Edit`].
pub fn copy_unsaved(world: &mut World) {
    let state = world.resource::<History>().state();
    let document = world.resource::<Document>();
    let is_due = match document.copied {
        Some((copied, when)) => copied != state && when.elapsed() >= EVERY,
        None => true,
    };
    if !is_due || document.left.is_some() || !world.resource::<History>().is_unsaved() {
        return;
    }
    copy_now(world);
}

/// Writes unsaved edits beside the file now: the program ends.
pub fn copy_at_end(world: &mut World) {
    let is_unsaved = world
        .get_resource::<History>()
        .is_some_and(History::is_unsaved);
    if is_unsaved && world.contains_resource::<Document>() {
        copy_now(world);
    }
}

fn copy_now(world: &mut World) {
    let Some(path) = world.resource::<Document>().path.clone() else {
        return;
    };
    let state = world.resource::<History>().state();
    let copy = copy_path(&path);
    let text = text_for(world, &copy);
    let is_first_failure = world.resource::<Document>().copied.is_none();
    let written = write_whole(&copy, &text);
    world.resource_mut::<Document>().copied = Some((state, Instant::now()));
    if let Err(why) = written
        && is_first_failure
        && let Some(mut notices) = world.get_resource_mut::<Notices>()
    {
        notices.toast(format!("Unsaved edits are not kept: {why}"));
    }
}

#[cfg(test)]
mod tests;
