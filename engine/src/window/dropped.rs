//! Files dropped onto the window: a scene or model takes the place of what is shown; what cannot be read leaves all as
//! it was. A file is read on a thread of its own, so that frames go on until it has come. Called by the window, tested
//! without one.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use bevy_ecs::prelude::*;

use crate::editor::{self, Document, Notices};
use crate::scene::{self, Loader, Prepared, Problems, Progress};
use crate::time::Time;

/// Sentences shown at once.
const MOST: usize = 8;

/// The file that was dropped last, until it is shown.
#[derive(Default)]
pub struct Dropped(Option<Coming>);

/// A file that is being read.
struct Coming {
    name: String,
    file: PathBuf,
    progress: Progress,
    prepared: Receiver<Result<Prepared, Problems>>,
}

impl Dropped {
    /// Begins to read a file, whatever becomes of the one before.
    pub fn take(&mut self, world: &mut World, path: &Path) {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let loader = Loader {
            progress: Progress::default(),
            ..world.get_resource_or_init::<Loader>().clone()
        };
        let progress = loader.progress.clone();
        let (sender, prepared) = mpsc::channel();
        let file = path.to_owned();
        let read = file.clone();
        let reader = thread::Builder::new().name("dropped file".into());
        let reader = reader.spawn(move || {
            // Nobody waits for it once another file was dropped.
            let _ = sender.send(scene::prepare(&read, &loader));
        });
        match reader {
            Ok(_) => {
                self.0 = Some(Coming {
                    name: name.into_owned(),
                    file,
                    progress,
                    prepared,
                });
            }
            Err(why) => world
                .resource_mut::<Notices>()
                .toast(format!("{name} cannot be read: {why}")),
        }
    }

    /// What is being done for the file, in words; none: nothing is on its way.
    pub fn step(&self) -> Option<String> {
        let step = self.0.as_ref()?.progress.now();
        Some(match step.count {
            0 | 1 => step.what,
            count => format!("{} {}/{count}", step.what, step.done),
        })
    }

    /// Shows the file, once it has been read, from its first moment on, and says what is odd or wrong with it. The name
    /// of the scene, if it is another one now.
    pub fn show(&mut self, world: &mut World) -> Option<String> {
        let prepared = match self.0.as_ref()?.prepared.try_recv() {
            Ok(prepared) => prepared,
            Err(TryRecvError::Empty) => return None,
            // Its reader is gone without a word, which is on stderr.
            Err(TryRecvError::Disconnected) => Err(Problems::default()),
        };
        let Coming { name, file, .. } = self.0.take()?;
        match prepared.and_then(|prepared| scene::put(world, prepared)) {
            Ok(report) => {
                world.resource_mut::<Time>().secs = 0.0;
                editor::scene_replaced(world);
                world.insert_resource(Document::of(&file));
                let warnings = report.warnings.iter().map(ToString::to_string);
                world.resource_mut::<Notices>().issues = first(warnings.collect());
                Some(name)
            }
            Err(problems) => {
                let problems = problems.0.iter().map(ToString::to_string);
                let mut notices = world.resource_mut::<Notices>();
                notices.issues = first(problems.collect());
                notices.toast(format!("{name} cannot be shown"));
                None
            }
        }
    }
}

/// The first few sentences; the last one says how many more there were.
fn first(mut sentences: Vec<String>) -> Vec<String> {
    let more = sentences.len().saturating_sub(MOST);
    sentences.truncate(MOST);
    if more > 0 {
        sentences.push(format!("and {more} more"));
    }
    sentences
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Engine;
    use crate::editor::EditorState;
    use crate::world::{Mesh, Sphere};

    /// Drops a file and waits until it has come.
    fn show(world: &mut World, path: &Path) -> Option<String> {
        let mut dropped = Dropped::default();
        dropped.take(world, path);
        while dropped.step().is_some() {
            if let Some(name) = dropped.show(world) {
                assert_eq!(dropped.step(), None);
                return Some(name);
            }
            thread::yield_now();
        }
        None
    }

    fn count<T: Component>(world: &mut World) -> usize {
        world.query::<&T>().iter(world).count()
    }

    #[test]
    fn a_file_takes_the_scenes_place_and_a_bad_one_does_not() {
        let folder = std::env::temp_dir().join(format!("orrery-dropped-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let ball = file(
            "ball.ron",
            "(version: 1, entities: [(sphere: (radius: 1.0))])",
        );
        let leaf = file("leaf.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let bad = [
            file("bad.obj", "v 0 0 0\nf 1 2 3\n"),
            file(
                "bad.ron",
                "(version: 1, entities: [(sphere: (radius: \"wide\"))])",
            ),
            folder.join("missing.ron"),
        ];
        let mut engine = Engine::new();
        let world = &mut engine.world;
        world.init_resource::<EditorState>();
        world.init_resource::<editor::History>();
        world.init_resource::<Notices>();
        assert_eq!(show(world, &ball).as_deref(), Some("ball"));
        assert_eq!((count::<Sphere>(world), count::<Mesh>(world)), (1, 0));
        world.resource_mut::<Time>().secs = 3.0;
        for path in &bad {
            assert_eq!(show(world, path), None, "{}", path.display());
            assert!(!world.resource::<Notices>().issues.is_empty());
            assert_eq!((count::<Sphere>(world), count::<Mesh>(world)), (1, 0));
            assert_eq!(world.resource::<Time>().secs, 3.0);
        }
        assert_eq!(show(world, &leaf).as_deref(), Some("leaf"));
        assert_eq!((count::<Sphere>(world), count::<Mesh>(world)), (0, 1));
        assert_eq!(world.resource::<Time>().secs, 0.0);
        assert_eq!(world.resource::<Notices>().issues, Vec::<String>::new());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn many_sentences_are_cut() {
        let sentences = first((0..20).map(|i| i.to_string()).collect());
        assert_eq!(sentences.len(), MOST + 1);
        assert_eq!(sentences[MOST], "and 12 more");
    }
}
