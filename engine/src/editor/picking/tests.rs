use std::path::Path;

use glam::UVec2;

use super::*;
use crate::app::Engine;
use crate::frame::TraceSettings;
use crate::scene;
use crate::trace::cpu::CpuTracer;

/// A mirror on the left that shows a ball behind the eye, a pane of glass on the right before a box.
const SCENE: &str = r#"(
    version: 1,
    materials: {
        "mirror": (color: 0.1, diffuse: 0.1, reflection: 0.9),
        "glass": (color: 1, diffuse: 0, transmit: 0.9, ior: 1.5),
        "matt": (color: 0.8),
    },
    entities: [
        (id: "camera", camera: (fov: 60), transform: (eye: (0, 0, 0), target: (0, 0, -1))),
        (id: "mirror", box: (min: (-4, -2, -5.1), max: (-1, 2, -5)), material: "mirror"),
        (id: "behind", sphere: (radius: 1.5), material: "matt", transform: (translation: (-7.5, 0, 5))),
        (id: "pane", box: (min: (1, -2, -4.1), max: (4, 2, -4)), material: "glass"),
        (id: "box", box: (min: (1, -2, -8), max: (9, 2, -7)), material: "matt"),
        (id: "lamp", light: Point(), transform: (translation: (0, 1.5, -6))),
    ],
)"#;

fn engine() -> (Engine, Sight) {
    let mut engine = Engine::new();
    let world = &mut engine.world;
    world.init_resource::<Boxes>();
    scene::load_text(world, SCENE, Path::new("test.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
    world.insert_resource(TraceSettings {
        size: UVec2::new(64, 36),
        ..TraceSettings::default()
    });
    world.resource_mut::<ActiveTracer>().0 = Some(Box::new(CpuTracer::new()));
    engine.frame();
    let sight = Sight {
        view: engine.world.resource::<FrameScene>().view,
        window: Rect::from_min_size(Pos2::ZERO, egui::vec2(1280.0, 720.0)),
    };
    (engine, sight)
}

fn name(world: &World, entity: Option<Entity>) -> String {
    entity.map_or_else(
        || "nothing".into(),
        |e| world.get::<SceneId>(e).unwrap().0.clone(),
    )
}

#[test]
fn a_click_selects_what_is_seen_and_with_alt_what_is_seen_in_it() {
    let (mut engine, sight) = engine();
    let at = |place: DVec3| sight.place(place).unwrap().0;
    let world = &mut engine.world;
    let mut seen = |place, through| {
        let found = entity_at(world, &sight, at(place), through);
        name(world, found)
    };
    let mirror = DVec3::new(-2.5, 0.0, -5.0);
    assert_eq!(seen(mirror, false), "mirror");
    assert_eq!(seen(mirror, true), "behind");
    let pane = DVec3::new(2.5, 0.0, -4.0);
    assert_eq!(seen(pane, false), "pane");
    assert_eq!(seen(pane, true), "box");
    assert_eq!(seen(DVec3::new(0.0, 3.0, -6.0), false), "nothing");
}

#[test]
fn lights_have_marks_and_boxes_take_what_is_in_them() {
    let (mut engine, sight) = engine();
    let world = &mut engine.world;
    let lamp = sight.place(DVec3::new(0.0, 1.5, -6.0)).unwrap().0;
    let found = mark_at(world, &sight, lamp + egui::vec2(4.0, -3.0));
    assert_eq!(name(world, found), "lamp");
    assert_eq!(mark_at(world, &sight, lamp + egui::vec2(40.0, 0.0)), None);
    let right = Rect::from_min_max(Pos2::new(700.0, 0.0), Pos2::new(1280.0, 720.0));
    let things = things_in(world, &sight, right);
    let mut names: Vec<String> = things.iter().map(|&e| name(world, Some(e))).collect();
    names.sort();
    assert_eq!(names, ["box", "pane"]);
}
