//! Files that change on disk are read again: the scene's, and the models and pictures it names. What cannot be read leaves
//! the last good one in the picture, and what is wrong is shown with its line.
//!
//! Times of files are asked for twice a second, which any file system answers; a file is read once it has stood still for
//! one of these.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use bevy_ecs::prelude::*;

use super::history::History;
use super::{Document, Notices, document};
use crate::scene::{MeshSource, PoseFiles};
use crate::world::Textures;

/// How often files are looked at.
const EVERY: Duration = Duration::from_millis(500);

/// What the files were like when last looked at.
#[derive(Resource, Debug, Default)]
pub struct Watched {
    looked: Option<Instant>,
    files: BTreeMap<PathBuf, Option<SystemTime>>,
    /// Files that changed and have yet to stand still.
    moving: Vec<PathBuf>,
    /// The scene that the files are of, and how often it was saved here.
    of: Option<(PathBuf, u64)>,
}

/// Looks at the files if it is time to; a system of [`crate::schedule::FrameSet::Edit`].
pub fn reload_changed(world: &mut World) {
    let is_due = |looked: Option<Instant>| looked.is_none_or(|when| when.elapsed() >= EVERY);
    if is_due(world.resource::<Watched>().looked) {
        look(world);
    }
}

/// Looks at the files now.
pub fn look(world: &mut World) {
    let mut watched = std::mem::take(&mut *world.resource_mut::<Watched>());
    watched.looked = Some(Instant::now());
    let document = world.resource::<Document>();
    let of = document.path.clone().map(|path| (path, document.saves()));
    let Some((path, _)) = of.clone() else {
        return *world.resource_mut::<Watched>() = watched;
    };
    let now: BTreeMap<PathBuf, Option<SystemTime>> = files_of(world, &path)
        .into_iter()
        .map(|file| {
            let time = std::fs::metadata(&file).and_then(|file| file.modified());
            (file, time.ok())
        })
        .collect();
    // What was written here, or belongs to another scene, is no news.
    let is_known = watched.of == of;
    let changed: Vec<PathBuf> = now
        .iter()
        .filter(|(file, time)| {
            is_known && time.is_some() && watched.files.get(*file).is_some_and(|old| old != *time)
        })
        .map(|(file, _)| file.clone())
        .collect();
    let still = std::mem::replace(&mut watched.moving, changed);
    let settled = still.iter().find(|file| !watched.moving.contains(file));
    let settled = settled.filter(|_| is_known).cloned();
    (watched.files, watched.of) = (now, of);
    *world.resource_mut::<Watched>() = watched;
    if let Some(file) = settled {
        reload(world, &path, &file);
    }
}

/// The scene's file and those that it names.
fn files_of(world: &mut World, scene: &Path) -> Vec<PathBuf> {
    let folder = world.resource::<Document>().base.clone();
    let mut files = vec![scene.to_owned()];
    let mut models = world.query::<&MeshSource>();
    files.extend(models.iter(world).map(|model| folder.join(&model.path)));
    let mut poses = world.query::<&PoseFiles>();
    for poses in poses.iter(world) {
        let named = poses.keys.iter().chain(&poses.morph);
        files.extend(named.map(|pose| folder.join(pose)));
    }
    if let Some(textures) = world.get_resource::<Textures>() {
        let named = textures.rows().iter().filter(|t| !t.path.is_empty());
        files.extend(named.map(|texture| folder.join(&texture.path)));
    }
    files.sort();
    files.dedup();
    files
}

fn reload(world: &mut World, path: &Path, file: &Path) {
    let unsaved = world.resource::<History>().is_unsaved();
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    if file == path && unsaved {
        let mut notices = world.resource_mut::<Notices>();
        return notices.toast(format!(
            "{name} changed on disk; there are unsaved edits: \"Revert to saved\" takes it up"
        ));
    }
    let is_there = if file == path {
        document::put(world, path)
    } else {
        // A model or a picture: the scene as it is now, with that file anew.
        let is_there = document::put_again(world);
        if is_there && unsaved {
            world.resource_mut::<History>().note_unsaved();
        }
        is_there
    };
    if is_there {
        world
            .resource_mut::<Notices>()
            .toast(format!("{name} was read again"));
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use crate::app::Engine;
    use crate::editor::EditorState;
    use crate::scene;
    use crate::world::{Meshes, Sphere};

    struct Folder(PathBuf);

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    /// Writes a file with a time of its own, however coarse those of the file system are.
    fn write(path: &Path, text: &str, secs: u64) {
        std::fs::write(path, text).unwrap();
        let time = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000 + secs);
        File::options()
            .write(true)
            .open(path)
            .unwrap()
            .set_modified(time)
            .unwrap();
    }

    fn scene(radius: &str) -> String {
        format!(
            "(version: 1, entities: [\n(id: \"ball\", sphere: (radius: {radius})),\n(id: \"leaf\", mesh: \"leaf.obj\")])"
        )
    }

    fn radius(world: &mut World) -> f64 {
        let mut balls = world.query::<&Sphere>();
        balls.single(world).unwrap().radius
    }

    #[test]
    fn changed_files_are_read_again_and_bad_ones_leave_the_last_good_one() {
        let folder = std::env::temp_dir().join(format!("orrery-reload-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let folder = Folder(folder);
        let (path, leaf) = (folder.0.join("scene.ron"), folder.0.join("leaf.obj"));
        write(&path, &scene("1"), 0);
        write(&leaf, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0);
        let mut engine = Engine::new();
        let world = &mut engine.world;
        world.init_resource::<History>();
        world.init_resource::<EditorState>();
        world.init_resource::<Notices>();
        world.init_resource::<Watched>();
        scene::load(world, &path).unwrap_or_else(|problems| panic!("{problems}"));
        world.insert_resource(Document::of(&path));
        let settle = |world: &mut World| (0..3).for_each(|_| look(world));
        settle(world);
        assert_eq!(radius(world), 1.0);
        write(&path, &scene("2"), 10);
        settle(world);
        assert_eq!(radius(world), 2.0);
        write(&path, &scene("\"wide\""), 20);
        settle(world);
        assert_eq!(radius(world), 2.0);
        let issues = world.resource::<Notices>().issues.join("\n");
        assert!(issues.contains("scene.ron:2:"), "{issues}");
        write(&path, &scene("3"), 30);
        settle(world);
        assert_eq!(radius(world), 3.0);
        write(&leaf, "v 0 0 0\nv 5 0 0\nv 0 5 0\nf 1 2 3\n", 40);
        settle(world);
        let widest = |world: &World| {
            let meshes = world.resource::<Meshes>().rows();
            meshes.iter().map(|row| row.data.extent).fold(0.0, f64::max)
        };
        assert!(widest(world) > 6.0, "the new leaf is there");
        assert_eq!(radius(world), 3.0);
    }
}
