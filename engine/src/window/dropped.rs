//! Files dropped onto the window: a scene or model takes the place of what is shown; what cannot be read leaves all as
//! it was. Called by the window, tested without one.

use std::path::Path;

use bevy_ecs::prelude::*;

use crate::editor::{EditorState, Notices};
use crate::scene;
use crate::time::Time;

/// Sentences shown at once.
const MOST: usize = 8;

/// Shows a file from its first moment on, and says what is odd or wrong with it. The name of the scene, if it is
/// another one now.
pub fn show(world: &mut World, path: &Path) -> Option<String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    match scene::load(world, path) {
        Ok(report) => {
            world.resource_mut::<Time>().secs = 0.0;
            // What was selected is gone.
            world.resource_mut::<EditorState>().selected = None;
            let warnings = report.warnings.iter().map(ToString::to_string);
            world.resource_mut::<Notices>().issues = first(warnings.collect());
            Some(name.into_owned())
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
    use crate::world::{Mesh, Sphere};

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
