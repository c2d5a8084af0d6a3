use glam::DVec3;

use super::*;
use crate::app::Engine;
use crate::editor::{Command, EditQueue, EditorState, Wish, edits, history};
use crate::world::{PointLight, SceneId, Sphere, Transform};

const SCENE: &str = "(version: 1, entities: [(id: \"ball\", sphere: (radius: 2)), (id: \"cow\", mesh: \"cow.obj\")])";

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// An editor over a scene in a folder of its own.
fn open(folder: &Folder) -> (Engine, PathBuf) {
    let path = folder.0.join("scene.ron");
    if !path.exists() {
        std::fs::write(&path, SCENE).unwrap();
        std::fs::write(
            folder.0.join("cow.obj"),
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        )
        .unwrap();
    }
    let mut engine = Engine::new();
    let world = &mut engine.world;
    world.init_resource::<History>();
    world.init_resource::<EditorState>();
    world.init_resource::<EditQueue>();
    world.init_resource::<Notices>();
    scene::load(world, &path).unwrap_or_else(|problems| panic!("{problems}"));
    world.insert_resource(Document::of(&path));
    (engine, path)
}

fn edit(world: &mut World, name: &str) {
    let parts: Vec<history::Value> = vec![Box::new(PointLight::default())];
    let command = Command::Spawn {
        name: name.into(),
        parent: None,
        parts,
    };
    world.resource_mut::<EditQueue>().push(command);
    edits::apply_edits(world);
}

fn ids(world: &mut World) -> Vec<String> {
    let mut ids = world.query::<&SceneId>();
    let mut ids: Vec<String> = ids.iter(world).map(|id| id.0.clone()).collect();
    ids.sort();
    ids
}

#[test]
fn saving_writes_the_scene_and_keeps_what_was_there() {
    let folder = Folder::new("save");
    let (mut engine, path) = open(&folder);
    let world = &mut engine.world;
    edit(world, "lamp");
    assert!(world.resource::<History>().is_unsaved());
    world.resource_mut::<EditQueue>().0.push(Wish::Save);
    edits::apply_edits(world);
    assert!(!world.resource::<History>().is_unsaved());
    assert_eq!(
        std::fs::read_to_string(path.with_extension("ron.bak")).unwrap(),
        SCENE
    );
    let saved = std::fs::read_to_string(&path).unwrap();
    assert_eq!(saved, scene::save(world));
    let names: Vec<_> = std::fs::read_dir(&folder.0).unwrap().flatten().collect();
    assert_eq!(names.len(), 3, "nothing else is left: {names:?}");
}

#[test]
fn unsaved_edits_outlive_a_crash_and_are_offered() {
    let folder = Folder::new("crash");
    let (mut engine, path) = open(&folder);
    edit(&mut engine.world, "lamp");
    copy_unsaved(&mut engine.world);
    drop(engine);
    let (mut engine, _) = open(&folder);
    let world = &mut engine.world;
    assert_eq!(ids(world), ["ball", "cow"], "nothing is taken up unasked");
    assert!(world.resource::<Document>().left.is_some());
    recover(world);
    assert_eq!(ids(world), ["ball", "cow", "lamp"]);
    assert!(world.resource::<History>().is_unsaved());
    save(world);
    assert!(!copy_path(&path).exists());
    let (engine, _) = open(&folder);
    assert!(engine.world.resource::<Document>().left.is_none());
}

#[test]
fn a_scene_saved_elsewhere_still_finds_what_it_names() {
    let folder = Folder::new("elsewhere");
    let (mut engine, _) = open(&folder);
    let there = folder.0.join("deeper/still");
    std::fs::create_dir_all(&there).unwrap();
    save_to(&mut engine.world, &there.join("other.ron"));
    save_to(&mut engine.world, &there.join("other.ron"));
    assert_eq!(
        engine.world.resource::<Notices>().issues,
        Vec::<String>::new()
    );
    let report = scene::check(&there.join("other.ron"));
    assert!(report.problems.0.is_empty(), "{}", report.problems);
}

#[test]
fn what_cannot_be_written_is_said_and_stays_unsaved() {
    let folder = Folder::new("nowhere");
    let (mut engine, path) = open(&folder);
    edit(&mut engine.world, "lamp");
    save_to(&mut engine.world, &folder.0.join("missing/other.ron"));
    assert!(engine.world.resource::<History>().is_unsaved());
    let said = &engine.world.resource::<Notices>().issues;
    assert!(said[0].contains("other.ron"), "{said:?}");
    assert_eq!(
        engine.world.resource::<Document>().path.as_ref(),
        Some(&path)
    );
}

#[test]
fn revert_brings_the_file_back() {
    let folder = Folder::new("revert");
    let (mut engine, _) = open(&folder);
    let world = &mut engine.world;
    edit(world, "lamp");
    revert(world);
    assert_eq!(ids(world), ["ball", "cow"]);
    assert!(!world.resource::<History>().is_unsaved());
    let mut balls = world.query::<(&Sphere, &Transform)>();
    let (ball, place) = balls.single(world).unwrap();
    assert_eq!((ball.radius, place.translation), (2.0, DVec3::ZERO));
}
