//! The panels, driven through what a screen reader sees.

use egui::Modifiers;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::super::*;
use super::load;
use crate::testing::Random;
use crate::world::{Orbit, SceneId, Sphere, Transform, Visibility};

const SCENE: &str = r#"(
    version: 1,
    materials: { "red": (color: (0.9, 0.2, 0.1)), "glass": (transmit: 0.9, ior: 1.5) },
    entities: [
        (id: "lamp", light: Spot(), transform: (translation: (3, 6, 4))),
        (id: "arm", children: [(id: "ball", sphere: (radius: 2), material: "red")]),
        (id: "stone", box: ()),
    ],
)"#;

/// The panels over an engine, without a window.
fn panels(engine: Engine) -> Harness<'static, Engine> {
    let ui = |ui: &mut egui::Ui, engine: &mut Engine| {
        let world = &mut engine.world;
        show_panels(ui, world);
        edits::apply_edits(world);
        engine.frame();
    };
    Harness::builder()
        .with_size(egui::vec2(1100.0, 800.0))
        .with_max_steps(40)
        // Fields stand beside their names, which are labels of their own.
        .with_accessibility_check(false)
        .build_ui_state(ui, engine)
}

fn engine(text: &str) -> Engine {
    let mut engine = Engine::new();
    let world = &mut engine.world;
    init_resources(world);
    world.init_resource::<crate::input::KeyMap>();
    load(world, text);
    engine.add_systems(FrameSet::Edit, hierarchy::watch);
    engine
}

fn id(engine: &mut Engine, wanted: &str) -> Entity {
    let mut ids = engine.world.query::<(Entity, &SceneId)>();
    let found = ids.iter(&engine.world).find(|(_, id)| id.0 == wanted);
    found.unwrap_or_else(|| panic!("no {wanted}")).0
}

fn selected(harness: &Harness<Engine>) -> Vec<String> {
    let world = &harness.state().world;
    let selection = &world.resource::<EditorState>().selection;
    let label = |&entity: &Entity| naming::label(world, entity);
    selection.all().iter().map(label).collect()
}

#[test]
fn the_hierarchy_selects_one_many_and_ranges() {
    let mut harness = panels(engine(SCENE));
    harness.run();
    harness.get_by_label("arm").click();
    harness.run();
    assert_eq!(selected(&harness), ["arm"]);
    harness
        .get_by_label("stone")
        .click_modifiers(Modifiers::SHIFT);
    harness.run();
    assert_eq!(selected(&harness), ["arm", "ball", "stone"]);
    harness
        .get_by_label("ball")
        .click_modifiers(Modifiers::COMMAND);
    harness.run();
    assert_eq!(selected(&harness), ["arm", "stone"]);
}

#[test]
fn a_search_lists_what_it_finds_and_no_more() {
    let mut harness = panels(engine(SCENE));
    harness.run();
    harness
        .get_by_role(egui::accesskit::Role::TextInput)
        .focus();
    harness.run();
    harness
        .get_by_role(egui::accesskit::Role::TextInput)
        .type_text("BAL");
    harness.run();
    assert!(harness.query_by_label("ball").is_some());
    assert!(harness.query_by_label("stone").is_none());
}

#[test]
fn a_menu_copies_hides_and_deletes_and_edit_undoes_it() {
    let mut harness = panels(engine(SCENE));
    harness.run();
    // The inspector says its name, too.
    let row = |harness: &Harness<Engine>, name: &str| {
        let role = egui::accesskit::Role::Button;
        harness
            .query_by_role_and_label(role, name)
            .map(|row| row.click_secondary())
    };
    let act = |harness: &mut Harness<Engine>, what: &str| {
        row(harness, "stone").expect("its row");
        harness.run();
        harness.get_by_label(what).click();
        harness.run();
    };
    act(&mut harness, "Duplicate");
    assert_eq!(selected(&harness), ["stone 2"]);
    act(&mut harness, "Hide or show");
    let stone = id(harness.state_mut(), "stone");
    let shown = |harness: &Harness<Engine>| harness.state().world.get::<Visibility>(stone).copied();
    assert_eq!(shown(&harness), Some(Visibility { shown: false }));
    act(&mut harness, "Delete");
    assert_eq!(shown(&harness), None);
    assert!(harness.query_by_label("stone").is_none());
    for (undo, then) in [
        ("Undo Delete stone", Some(Visibility { shown: false })),
        ("Undo Hide stone", Some(Visibility { shown: true })),
    ] {
        harness.get_by_label("Edit").click();
        harness.run();
        harness.get_by_label_contains(undo).click();
        harness.run();
        assert_eq!(shown(&harness), then, "{undo}");
    }
}

#[test]
fn the_inspector_adds_and_removes_components() {
    let mut harness = panels(engine(SCENE));
    let (lamp, ball) = (
        id(harness.state_mut(), "lamp"),
        id(harness.state_mut(), "ball"),
    );
    harness.run();
    harness.get_by_label("lamp").click();
    harness.run();
    harness.get_by_label("ball").click();
    harness.run();
    harness.get_by_label("Add component").click();
    harness.run();
    harness.get_by_label("Orbit").click();
    harness.run();
    assert!(harness.state().world.get::<Orbit>(ball).is_some());
    assert!(harness.state().world.get::<Orbit>(lamp).is_none());
    harness.get_by_label("Orbit").click_secondary();
    harness.run();
    harness.get_by_label("Remove").click();
    harness.run();
    assert!(harness.state().world.get::<Orbit>(ball).is_none());
    let steps = harness.state().world.resource::<History>().done();
    let names: Vec<&str> = steps.map(|step| step.name.as_str()).collect();
    assert_eq!(names, ["Orbit on ball", "Remove Orbit of ball"]);
}

#[test]
fn ten_thousand_things_lay_out_a_screenful_of_rows() {
    let mut engine = engine("(version: 1)");
    let mut random = Random::new(1);
    for i in 0..10_000 {
        let place = Transform::from_translation(random.cube() * 100.0);
        let parts = (Sphere::default(), place, Name::new(format!("thing {i}")));
        engine.world.spawn(parts);
    }
    let mut harness = panels(engine);
    harness.run();
    let tree = harness.state().world.resource::<hierarchy::Tree>();
    assert_eq!(tree.listed(), 10_000);
    assert!((10..80).contains(&tree.laid_out()), "{}", tree.laid_out());
    let found = tree.version();
    harness.run_steps(5);
    let tree = harness.state().world.resource::<hierarchy::Tree>();
    assert_eq!(
        tree.version(),
        found,
        "nothing changed, so nothing is looked for"
    );
}
