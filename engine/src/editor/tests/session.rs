//! A session with the demo: select by a click, move by a handle, change a material, undo, save, load again, compare.

use std::any::TypeId;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use egui::{Pos2, RawInput, Rect};
use glam::{DVec2, UVec2, Vec3};

use super::super::*;
use crate::frame::TraceSettings;
use crate::input::{Input, KeyCode, MouseButton};
use crate::scene;
use crate::trace::ActiveTracer;
use crate::trace::cpu::CpuTracer;
use crate::world::{Material, SceneId, Surface};

const DEMO: &str = "../assets/scenes/demo.ron";
const WINDOW: [f32; 2] = [1280.0, 720.0];

struct Session {
    engine: Engine,
    folder: PathBuf,
}

impl Drop for Session {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Session {
    fn open() -> Self {
        let mut engine = Engine::new();
        engine
            .add_plugin(crate::profile::plugin)
            .add_plugin(crate::input::plugin)
            .add_plugin(crate::present::plugin)
            .add_plugin(plugin);
        engine.validate().expect("the systems can be ordered");
        let world = &mut engine.world;
        let demo = Path::new(DEMO);
        scene::load(world, demo).unwrap_or_else(|problems| panic!("{problems}"));
        world.insert_resource(Document::of(demo));
        world.insert_resource(TraceSettings {
            size: UVec2::new(64, 36),
            ..TraceSettings::default()
        });
        world.resource_mut::<ActiveTracer>().0 = Some(Box::new(CpuTracer::new()));
        world.resource_mut::<EditorState>().panels = true;
        world.resource_mut::<Input>().set_editing(true);
        let folder = std::env::temp_dir().join(format!("orrery-session-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut session = Self { engine, folder };
        session.frame();
        session.frame();
        session
    }

    fn frame(&mut self) {
        let screen = Rect::from_min_size(Pos2::ZERO, WINDOW.into());
        self.engine.world.resource_mut::<Ui>().feed(RawInput {
            screen_rect: Some(screen),
            ..RawInput::default()
        });
        self.engine.frame();
        self.engine.world.resource_mut::<Input>().end_frame();
    }

    fn input(&mut self) -> Mut<'_, Input> {
        self.engine.world.resource_mut::<Input>()
    }

    /// Presses the left button at the first place, lets it go at the last.
    fn drag(&mut self, way: &[Pos2]) {
        let place = |at: Pos2| Some(DVec2::new(at.x.into(), at.y.into()));
        self.input().point_at(place(way[0]));
        self.frame();
        self.input().button(MouseButton::Left, true);
        self.frame();
        for &at in way {
            self.input().point_at(place(at));
            self.frame();
        }
        self.input().button(MouseButton::Left, false);
        self.frame();
    }

    fn press(&mut self, keys: &[KeyCode]) {
        for &key in keys {
            self.input().key(key, true);
        }
        self.frame();
        for &key in keys {
            self.input().key(key, false);
        }
        self.frame();
    }

    /// Saves under a name in the session's folder; what was written.
    fn save_as(&mut self, name: &str) -> String {
        let path = self.folder.join(name);
        let wish = Wish::SaveAs(path.clone());
        self.engine.world.resource_mut::<EditQueue>().0.push(wish);
        self.frame();
        let issues = &self.engine.world.resource::<Notices>().issues;
        assert_eq!(issues, &Vec::<String>::new());
        std::fs::read_to_string(path).expect("the file was written")
    }

    fn steps(&self) -> Vec<String> {
        let history = self.engine.world.resource::<History>();
        history.done().map(|step| step.name.clone()).collect()
    }
}

/// The lines of the second text that the first does not have.
fn new_lines<'a>(before: &str, after: &'a str) -> Vec<&'a str> {
    let known: HashSet<&str> = before.lines().collect();
    after.lines().filter(|line| !known.contains(line)).collect()
}

#[test]
fn a_session_with_the_demo_saves_what_was_done_and_nothing_else() {
    let mut session = Session::open();
    let original = session.save_as("original.ron");

    // A click on what the middle of the picture shows.
    session.drag(&[Pos2::new(640.0, 400.0)]);
    let world = &session.engine.world;
    let thing = world.resource::<EditorState>().selection.lead();
    let thing = thing.expect("the demo shows something in its middle");
    assert!(world.get::<SceneId>(thing).is_some());

    // The handle of the second axis, up by eighty points.
    let sight = pointer::sight(world);
    let frame = pointer::frame(world, &sight).expect("it has handles");
    let tip = frame.pivot + frame.axes[1] * (frame.reach * 0.8);
    let tip = sight.place(tip).expect("it is seen").0;
    session.drag(&[
        tip,
        tip - egui::vec2(0.0, 30.0),
        tip - egui::vec2(0.0, 80.0),
    ]);
    let steps = session.steps();
    assert_eq!(steps.len(), 1, "a drag is one step: {steps:?}");
    assert!(steps[0].starts_with("Move "), "{steps:?}");
    let moved = session.save_as("moved.ron");
    // The one entity, on as many lines as its numbers take.
    let lines = new_lines(&original, &moved);
    assert!((1..=14).contains(&lines.len()), "{lines:#?}");
    assert!(
        lines.iter().any(|line| line.contains("translation")),
        "{lines:#?}"
    );

    // A material, changed and taken back.
    let material = {
        let mut surfaces = session.engine.world.query::<&Surface>();
        surfaces
            .iter(&session.engine.world)
            .next()
            .expect("a material is used")
            .0
    };
    let paint = Command::Set(vec![FieldSet {
        entity: material,
        component: TypeId::of::<Material>(),
        path: ".color".into(),
        value: Box::new(Vec3::new(0.125, 0.25, 0.5)),
    }]);
    session.engine.world.resource_mut::<EditQueue>().push(paint);
    session.frame();
    assert_ne!(session.save_as("painted.ron"), moved);
    session.press(&[KeyCode::ControlLeft, KeyCode::KeyZ]);
    assert_eq!(session.save_as("unpainted.ron"), moved);

    // What was saved loads, and is the same again.
    let mut again = Engine::new();
    scene::load(&mut again.world, &session.folder.join("unpainted.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(scene::save(&mut again.world), moved);

    // All the way back.
    session.press(&[KeyCode::ControlLeft, KeyCode::KeyZ]);
    assert_eq!(session.save_as("back.ron"), original);
}
