use std::any::TypeId;
use std::collections::BTreeMap;
use std::path::Path;

use bevy_ecs::reflect::AppTypeRegistry;
use glam::{DVec3, Vec3};

use super::parts::{authored, copy_of};
use super::*;
use crate::app::Engine;
use crate::editor::EditorState;
use crate::scene;
use crate::testing::Random;
use crate::world::{
    GlobalTransform, Material, Orbit, PointLight, Rest, SceneId, Sphere, Spin, Surface, Transform,
    Visibility,
};

const SCENE: &str = r#"(
    version: 1,
    materials: { "red": (color: (0.9, 0.2, 0.1)), "glass": (transmit: 0.9, ior: 1.5) },
    entities: [
        (id: "camera", camera: (fov: 50), transform: (eye: (0, 1.5, 6), target: (0, 0.5, 0))),
        (id: "lamp", light: Point(color: (1, 1, 1)), transform: (translation: (3, 6, 4))),
        (id: "arm", transform: (translation: (1, 2, 3), scale: (1, 2, 0.5)), children: [
            (id: "ball", sphere: (radius: 1), material: "red", transform: (rotation: Euler(10, 20, 30))),
            (id: "moon", sphere: (radius: 0.2), material: "glass", motion: (orbit: (radius: 2, period: 3))),
        ]),
        (id: "tile", polygon: (corners: [(0, 0, 0), (1, 0, 0), (1, 1, 0)]), material: "glass"),
        (id: "top", box: (), motion: (spin: (period: 2)), material: "red", children: [(id: "leaf", torus: ())]),
    ],
    timeline: (tracks: [(target: "lamp", field: "light.intensity", keys: [(0, 1), (2, 3)])]),
)"#;

fn engine() -> Engine {
    let mut engine = Engine::new();
    engine.world.init_resource::<History>();
    engine.world.init_resource::<EditorState>();
    scene::load_text(&mut engine.world, SCENE, Path::new("test.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
    engine.frame();
    engine
}

/// Every entity with parts of its own: all of them in words, and its children in their order. Poses of what moves by
/// itself are written by motion in every frame.
fn state(world: &World) -> BTreeMap<String, String> {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let mut state = BTreeMap::new();
    for entity in world.iter_entities() {
        let id = entity.id();
        let moves = entity.contains::<Rest>();
        for component in authored(world, &registry, id) {
            if moves && component == TypeId::of::<Transform>() {
                continue;
            }
            let value = copy_of(world, &registry, id, component).expect("it can be copied");
            let path = value.reflect_type_path().to_owned();
            state.insert(format!("{id} {path}"), format!("{value:?}"));
        }
        if let Some(children) = entity.get::<Children>() {
            state.insert(format!("{id} children"), format!("{:?}", &**children));
        }
    }
    state
}

type State = (BTreeMap<String, String>, String);

fn all(world: &mut World) -> State {
    (state(world), scene::save(world))
}

/// Fails with the first line that differs, and no more.
fn assert_same(now: &State, then: &State, when: &str) {
    let keys = now.0.keys().chain(then.0.keys());
    for key in keys {
        assert_eq!(now.0.get(key), then.0.get(key), "{when}: {key}");
    }
    assert_eq!(now.1, then.1, "{when}: the saved scene");
}

fn id(world: &mut World, wanted: &str) -> Entity {
    let mut ids = world.query::<(Entity, &SceneId)>();
    let found = ids.iter(world).find(|(_, id)| id.0 == wanted);
    found.unwrap_or_else(|| panic!("no {wanted}")).0
}

fn set<C: Component>(
    entity: Entity,
    path: &str,
    value: impl bevy_reflect::PartialReflect,
) -> Command {
    Command::Set(vec![FieldSet {
        entity,
        component: TypeId::of::<C>(),
        path: path.into(),
        value: Box::new(value),
    }])
}

fn perform_plain(world: &mut World, command: Command) {
    perform(world, command, None, None).unwrap_or_else(|why| panic!("{why}"));
}

/// A command drawn at random over the entities that are there.
fn any_command(world: &mut World, random: &mut Random) -> Command {
    let mut there = world.query_filtered::<Entity, With<SceneId>>();
    let mut there: Vec<Entity> = there.iter(world).collect();
    there.sort_unstable();
    let one = |random: &mut Random| there[random.below(there.len())];
    let entity = one(random);
    let other = one(random);
    let place = random.cube() + 2.0;
    match random.below(14) {
        0 => set::<Transform>(entity, ".translation", place),
        1 => set::<Material>(entity, ".color", place.as_vec3()),
        2 => set::<Sphere>(entity, ".radius", place.x),
        3 => Command::Insert(vec![entity, other], Box::new(Orbit::default())),
        4 => Command::Insert(vec![entity], Box::new(Spin::default())),
        5 => Command::Remove(vec![entity, other], TypeId::of::<Orbit>()),
        6 => Command::Remove(vec![entity], TypeId::of::<Surface>()),
        7 => Command::Spawn {
            name: "bulb".into(),
            parent: (random.below(2) == 0).then_some(other),
            parts: vec![Box::new(PointLight::default())],
        },
        8 => Command::Delete(vec![entity]),
        9 => Command::Duplicate(vec![entity, other]),
        10 => Command::Reparent(vec![entity], Some(other)),
        11 => Command::Reparent(vec![entity, other], None),
        12 => Command::rename(entity, &format!("name {}", random.below(9))),
        _ => Command::show(&[entity, other], random.below(2) == 0),
    }
}

#[test]
fn random_commands_go_back_and_forth_exactly() {
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let mut engine = engine();
        let mut states = vec![all(&mut engine.world)];
        while states.len() < 40 {
            let command = any_command(&mut engine.world, &mut random);
            let before = engine.world.resource::<History>().done().len();
            // Some are refused (a parent below its child, a field that is not there): those leave no step.
            let _ = perform(&mut engine.world, command, None, None);
            if random.below(3) == 0 {
                engine.frame();
            }
            let now = all(&mut engine.world);
            if engine.world.resource::<History>().done().len() == before {
                assert_same(&now, &states[states.len() - 1], "a refused command");
            } else {
                states.push(now);
            }
        }
        for _ in 0..2 {
            for at in (0..states.len() - 1).rev() {
                let name = undo(&mut engine.world).expect("a step to undo");
                if random.below(4) == 0 {
                    engine.frame();
                }
                let now = all(&mut engine.world);
                assert_same(
                    &now,
                    &states[at],
                    &format!("seed {seed}, undo to {at}: {name}"),
                );
            }
            assert_eq!(undo(&mut engine.world), None);
            for (at, then) in states.iter().enumerate().skip(1) {
                let name = redo(&mut engine.world).expect("a step to do again");
                if random.below(4) == 0 {
                    engine.frame();
                }
                let now = all(&mut engine.world);
                assert_same(&now, then, &format!("seed {seed}, redo to {at}: {name}"));
            }
            assert_eq!(redo(&mut engine.world), None);
        }
    }
}

#[test]
fn what_refers_to_a_deleted_entity_means_it_again_after_undo() {
    let mut engine = engine();
    let world = &mut engine.world;
    let (red, arm, ball, lamp) = (
        id(world, "red"),
        id(world, "arm"),
        id(world, "ball"),
        id(world, "lamp"),
    );
    let saved = scene::save(world);
    perform_plain(world, Command::Delete(vec![red, arm, lamp]));
    assert!(is_bare(world, ball), "it is gone with its parent");
    assert_eq!(world.get::<Sphere>(ball), None);
    engine.frame();
    let world = &mut engine.world;
    // What is saved without them is a scene that loads.
    let text = scene::save(world);
    assert!(
        scene::check_text(&text, Path::new("test.ron"))
            .problems
            .0
            .is_empty(),
        "{text}"
    );
    undo(world);
    assert_eq!(world.get::<Surface>(ball), Some(&Surface(red)));
    assert_eq!(world.get::<ChildOf>(ball).map(ChildOf::parent), Some(arm));
    assert_eq!(scene::save(world), saved);
}

#[test]
fn drags_are_one_step_and_a_closed_group_starts_another() {
    let mut engine = engine();
    let world = &mut engine.world;
    let ball = id(world, "ball");
    let start = *world.get::<Transform>(ball).unwrap();
    let drag = |world: &mut World, x: f64| {
        let command = set::<Transform>(ball, ".translation", DVec3::splat(x));
        perform(world, command, None, Some("drag".into())).unwrap();
    };
    (1..50).for_each(|x| drag(world, f64::from(x)));
    assert_eq!(world.resource::<History>().done().len(), 1);
    world.resource_mut::<History>().close_group();
    (50..60).for_each(|x| drag(world, f64::from(x)));
    assert_eq!(world.resource::<History>().done().len(), 2);
    assert_eq!(
        undo(world).as_deref(),
        Some("Transform translation of ball")
    );
    assert_eq!(
        world.get::<Transform>(ball).unwrap().translation,
        DVec3::splat(49.0)
    );
    undo(world);
    assert_eq!(world.get::<Transform>(ball), Some(&start));
    redo(world);
    assert_eq!(
        world.get::<Transform>(ball).unwrap().translation,
        DVec3::splat(49.0)
    );
}

#[test]
fn the_oldest_of_a_thousand_steps_is_forgotten_and_its_entities_with_it() {
    let mut engine = engine();
    let world = &mut engine.world;
    let ball = id(world, "ball");
    let arm = id(world, "arm");
    perform_plain(world, Command::Delete(vec![arm]));
    let lamp = id(world, "lamp");
    for step in 0..STEPS + 10 {
        let place = DVec3::splat(step as f64 + 100.0);
        perform_plain(world, set::<Transform>(lamp, ".translation", place));
    }
    assert_eq!(world.resource::<History>().done().len(), STEPS);
    assert!(world.get_entity(ball).is_err(), "nothing can bring it back");
    while undo(world).is_some() {}
    let place = world.get::<Transform>(lamp).unwrap().translation;
    assert_eq!(place, DVec3::splat(109.0));
}

#[test]
fn what_is_saved_is_known_through_undo_and_redo() {
    let mut engine = engine();
    let world = &mut engine.world;
    let ball = id(world, "ball");
    let unsaved = |world: &World| world.resource::<History>().is_unsaved();
    let shift = |world: &mut World, x| {
        perform_plain(
            world,
            set::<Transform>(ball, ".translation", DVec3::splat(x)),
        );
    };
    assert!(!unsaved(world));
    shift(world, 1.5);
    assert!(unsaved(world));
    world.resource_mut::<History>().note_saved();
    shift(world, 2.5);
    undo(world);
    assert!(!unsaved(world));
    undo(world);
    assert!(unsaved(world));
    shift(world, 3.5);
    assert!(unsaved(world), "as many steps, but not the same");
}

#[test]
fn reparenting_keeps_the_place_in_the_world_even_where_that_takes_shear() {
    let mut engine = engine();
    let (ball, top) = (id(&mut engine.world, "ball"), id(&mut engine.world, "top"));
    let before = engine.world.get::<GlobalTransform>(ball).unwrap().0;
    for parent in [None, Some(top)] {
        perform_plain(&mut engine.world, Command::Reparent(vec![ball], parent));
        engine.frame();
        let after = engine.world.get::<GlobalTransform>(ball).unwrap().0;
        assert!(
            after.abs_diff_eq(before, 1e-9),
            "{after:?} is not {before:?}"
        );
    }
    let inside = perform(
        &mut engine.world,
        Command::Reparent(vec![top], Some(ball)),
        None,
        None,
    );
    assert!(inside.is_err(), "nothing hangs from itself");
}

#[test]
fn a_copy_has_its_own_id_and_its_own_children() {
    let mut engine = engine();
    let world = &mut engine.world;
    let (arm, ball) = (id(world, "arm"), id(world, "ball"));
    perform_plain(world, Command::Duplicate(vec![arm, ball]));
    let (copy, child) = (id(world, "arm 2"), id(world, "ball 2"));
    assert_eq!(world.get::<ChildOf>(child).map(ChildOf::parent), Some(copy));
    assert_eq!(world.get::<Surface>(child), world.get::<Surface>(ball));
    let moon = id(world, "moon 2");
    assert!(world.get::<Rest>(moon).is_some());
    perform_plain(world, Command::Duplicate(vec![copy]));
    id(world, "arm 3");
    let text = scene::save(world);
    let report = scene::check_text(&text, Path::new("test.ron"));
    assert!(report.problems.0.is_empty(), "{}", report.problems);
}

#[test]
fn a_refused_field_changes_nothing() {
    let mut engine = engine();
    let world = &mut engine.world;
    let ball = id(world, "ball");
    let before = state(world);
    let bad = set::<Transform>(ball, ".nowhere", 1.0);
    assert!(perform(world, bad, None, None).is_err());
    let bad = set::<Transform>(ball, ".translation", Vec3::ONE);
    assert!(perform(world, bad, None, None).is_err());
    assert_eq!(state(world), before);
    assert_eq!(world.resource::<History>().done().len(), 0);
    perform_plain(world, Command::show(&[ball], false));
    assert_eq!(
        world.get::<Visibility>(ball),
        Some(&Visibility { shown: false })
    );
    perform_plain(world, Command::show(&[ball], false));
    assert_eq!(
        world.resource::<History>().done().len(),
        1,
        "an equal value is no step"
    );
}
