use egui::{Pos2, Rect};
use glam::DVec3;

use super::*;
use crate::app::Engine;
use crate::editor::history::{self, Command, History};
use crate::frame::View;
use crate::world::{Orbit, Rest, Transform};

/// Looking along -Z from 10 units away.
fn sight() -> Sight {
    Sight {
        view: View {
            origin: DVec3::Z * 10.0,
            right: DVec3::X * 16.0 / 9.0,
            ..View::default()
        },
        window: Rect::from_min_size(Pos2::ZERO, egui::vec2(1280.0, 720.0)),
    }
}

fn engine() -> Engine {
    let mut engine = Engine::new();
    engine.world.init_resource::<History>();
    engine
}

/// Drags a handle from one place of the world to another, and what became of it.
fn drag(engine: &mut Engine, entity: Entity, what: (Handle, Mode), way: [DVec3; 2], snaps: bool) {
    engine.frame();
    let sight = sight();
    let world = &mut engine.world;
    let own_axes = what.1 == Mode::Scale;
    let frame = Frame::of(world, &sight, entity, own_axes).expect("it is before the eye");
    let [from, to] = way.map(|place| sight.place(place).expect("before the eye").0);
    let mut drag = Drag::begin(world, (what.0, frame, what.1), &[entity], from);
    for step in 1..=8 {
        let at = from + (to - from) * (step as f32 / 8.0);
        let fields = drag.fields(world, &sight, at, snaps);
        let group = Some("drag".to_owned());
        history::perform(world, Command::Set(fields), None, group).expect("it can be done");
    }
    world.resource_mut::<History>().close_group();
    engine.frame();
}

fn place(engine: &Engine, entity: Entity) -> DVec3 {
    engine
        .world
        .get::<GlobalTransform>(entity)
        .unwrap()
        .0
        .translation
}

#[test]
fn an_axis_moves_along_itself_whatever_its_parent_does() {
    let mut engine = engine();
    let parent = Transform {
        translation: DVec3::new(1.0, 0.0, 0.0),
        rotation: DQuat::from_rotation_z(0.7),
        scale: DVec3::new(2.0, 0.5, 1.0),
    };
    let parent = engine.world.spawn(parent).id();
    let local = Transform::from_translation(DVec3::new(0.2, 0.3, 0.0));
    let thing = engine.world.spawn((local, ChildOf(parent))).id();
    engine.frame();
    let start = place(&engine, thing);
    let way = [start, start + DVec3::X * 1.5];
    drag(
        &mut engine,
        thing,
        (Handle::Axis(0), Mode::Move),
        way,
        false,
    );
    let moved = place(&engine, thing) - start;
    assert!((moved - DVec3::X * 1.5).length() < 1e-3, "moved by {moved}");
    assert_eq!(engine.world.resource::<History>().done().len(), 1);
    history::undo(&mut engine.world);
    assert_eq!(engine.world.get::<Transform>(thing), Some(&local));
}

#[test]
fn moves_snap_relative_to_the_start() {
    let mut engine = engine();
    let start = DVec3::new(0.1, -0.3, 0.0);
    let thing = engine.world.spawn(Transform::from_translation(start)).id();
    let way = [start, start + DVec3::new(0.7, 0.45, 0.0)];
    drag(
        &mut engine,
        thing,
        (Handle::Plane(2), Mode::Move),
        way,
        true,
    );
    let moved = place(&engine, thing) - start;
    assert!(
        (moved - DVec3::new(0.75, 0.5, 0.0)).length() < 1e-9,
        "moved by {moved}"
    );
}

#[test]
fn turns_go_on_past_half_a_turn_and_snap() {
    let mut engine = engine();
    let thing = engine.world.spawn(Transform::IDENTITY).id();
    engine.frame();
    let sight = sight();
    let world = &mut engine.world;
    let frame = Frame::of(world, &sight, thing, false).unwrap();
    let at = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        sight.place(DVec3::new(cos, sin, 0.0)).unwrap().0
    };
    let mut drag = Drag::begin(
        world,
        (Handle::Axis(2), frame, Mode::Rotate),
        &[thing],
        at(0.0),
    );
    for degrees in (0..=250).step_by(10) {
        let fields = drag.fields(world, &sight, at(f64::from(degrees)), degrees == 250);
        history::perform(world, Command::Set(fields), None, Some("drag".into())).unwrap();
    }
    let turned = world.get::<Transform>(thing).unwrap().rotation;
    let wanted = DQuat::from_rotation_z(255_f64.to_radians());
    assert!(
        turned.dot(wanted).abs() > 1.0 - 1e-9,
        "{turned} is not {wanted}"
    );
}

#[test]
fn scale_goes_along_one_axis_or_all() {
    let mut engine = engine();
    let thing = engine.world.spawn(Transform::IDENTITY).id();
    engine.frame();
    let reach = sight().world_per_point(DVec3::ZERO) * REACH;
    let way = [DVec3::X * reach, DVec3::X * (2.0 * reach)];
    drag(
        &mut engine,
        thing,
        (Handle::Axis(0), Mode::Scale),
        way,
        false,
    );
    let scale = engine.world.get::<Transform>(thing).unwrap().scale;
    assert!(
        (scale - DVec3::new(2.0, 1.0, 1.0)).length() < 1e-3,
        "{scale}"
    );
}

#[test]
fn what_moves_by_itself_is_moved_where_it_rests() {
    let mut engine = engine();
    let orbit = Orbit::default();
    let thing = engine.world.spawn((Transform::IDENTITY, orbit)).id();
    engine.frame();
    let start = place(&engine, thing);
    let way = [start, start + DVec3::Y * 0.5];
    drag(
        &mut engine,
        thing,
        (Handle::Axis(1), Mode::Move),
        way,
        false,
    );
    let rest = engine.world.get::<Rest>(thing).unwrap().0.translation;
    assert!((rest - DVec3::Y * 0.5).length() < 1e-3, "{rest}");
}

#[test]
fn radius_and_cone_follow_the_mouse_exactly() {
    let mut engine = engine();
    let scaled = Transform {
        scale: DVec3::splat(2.0),
        ..Transform::IDENTITY
    };
    let ball = engine.world.spawn((Sphere { radius: 0.5 }, scaled)).id();
    let way = [DVec3::X, DVec3::X * 1.8];
    drag(&mut engine, ball, (Handle::Radius, Mode::Move), way, false);
    let radius = engine.world.get::<Sphere>(ball).unwrap().radius;
    assert!((radius - 0.9).abs() < 1e-4, "{radius}");
    // A lamp that shines to the right: its cone is seen in full width.
    let pose = Transform::looking_at(DVec3::ZERO, DVec3::X, DVec3::Y);
    let lamp = engine.world.spawn((SpotLight::default(), pose)).id();
    let rim = DVec3::new(1.0, 1.0, 0.0);
    drag(
        &mut engine,
        lamp,
        (Handle::Cone, Mode::Move),
        [DVec3::X + DVec3::Y * 0.5, rim],
        false,
    );
    let light = *engine.world.get::<SpotLight>(lamp).unwrap();
    assert!(
        (light.outer_angle.to_degrees() - 45.0).abs() < 1e-2,
        "{light:?}"
    );
    assert_eq!(light.inner_angle, SpotLight::default().inner_angle);
}

#[test]
fn handles_have_the_same_size_wherever_the_thing_is() {
    let mut engine = engine();
    let sight = sight();
    for distance in [1.0, 100.0] {
        let pose = Transform::from_translation(DVec3::Z * (10.0 - distance));
        let thing = engine.world.spawn(pose).id();
        engine.frame();
        let frame = Frame::of(&engine.world, &sight, thing, false).unwrap();
        let shown = handles(&frame, Mode::Move, &sight);
        let tip = shown[0].line.last().copied().unwrap();
        let (middle, tip) = (
            sight.place(frame.pivot).unwrap().0,
            sight.place(tip).unwrap().0,
        );
        assert!((middle.distance(tip) - REACH as f32).abs() < 0.1);
        assert_eq!(under(&shown, &sight, tip), Some(Handle::Axis(0)));
        assert_eq!(under(&shown, &sight, middle), Some(Handle::Middle));
        assert_eq!(under(&shown, &sight, Pos2::new(5.0, 5.0)), None);
    }
}
