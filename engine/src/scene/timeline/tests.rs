use glam::{DQuat, DVec3};

use super::*;
use crate::Engine;
use crate::scene::load_text;
use crate::scene::schema::{Ease, Key, KeyValue, Loop, Rotation};
use crate::scene::tests::Chance;
use crate::time::Clock;
use crate::world::{GlobalTransform, SceneId};

fn keys(values: &[(f64, f64, Ease)]) -> Vec<Key> {
    values
        .iter()
        .map(|&(time, value, ease)| Key {
            time,
            value: KeyValue::Number(value),
            ease,
        })
        .collect()
}

fn number(curve: &Curve, secs: f64) -> f64 {
    match curve.at(secs) {
        Value::Number(value) => value,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_curve_meets_its_keys_exactly_with_every_ease() {
    for ease in [
        Ease::Step,
        Ease::Linear,
        Ease::In,
        Ease::Out,
        Ease::InOut,
        Ease::Smooth,
    ] {
        let points = [
            (0.5, 0.1, ease),
            (1.25, -3.7, ease),
            (2.0, 11.3, ease),
            (7.0, 0.3, ease),
        ];
        let curve = Curve::new(&keys(&points), Loop::Once).unwrap();
        for (time, value, _) in points {
            assert_eq!(
                number(&curve, time).to_bits(),
                value.to_bits(),
                "{ease:?} at {time}"
            );
        }
        assert_eq!(
            number(&curve, -5.0),
            0.1,
            "before the first key the first value holds"
        );
        assert_eq!(
            number(&curve, 99.0),
            0.3,
            "after the last key the last value holds"
        );
    }
}

#[test]
fn eases_have_their_known_middles() {
    let middle = |ease| {
        let curve = Curve::new(&keys(&[(0.0, 0.0, ease), (2.0, 8.0, ease)]), Loop::Once).unwrap();
        number(&curve, 1.0)
    };
    assert_eq!(middle(Ease::Step), 0.0);
    assert_eq!(middle(Ease::Linear), 4.0);
    assert_eq!(middle(Ease::In), 1.0);
    assert_eq!(middle(Ease::Out), 7.0);
    assert_eq!(middle(Ease::InOut), 4.0);
    assert_eq!(middle(Ease::Smooth), 4.0);
}

#[test]
fn smooth_curves_have_no_corner_at_keys_or_at_the_seam() {
    let s = Ease::Smooth;
    let points = [(0.0, 1.0, s), (1.0, 5.0, s), (3.0, -2.0, s), (4.0, 1.0, s)];
    let curve = Curve::new(&keys(&points), Loop::Repeat).unwrap();
    let h = 1e-6;
    for time in [1.0, 3.0, 4.0, 8.0] {
        let before = (number(&curve, time - h) - number(&curve, time - 2.0 * h)) / h;
        let after = (number(&curve, time + 2.0 * h) - number(&curve, time + h)) / h;
        assert!((before - after).abs() < 1e-3, "at {time}: {before} {after}");
    }
}

#[test]
fn loops_repeat_bit_for_bit() {
    let points = [
        (0.0, 0.1, Ease::Linear),
        (3.0, 0.7, Ease::InOut),
        (4.0, 0.2, Ease::Smooth),
    ];
    let repeat = Curve::new(&keys(&points), Loop::Repeat).unwrap();
    let back = Curve::new(&keys(&points), Loop::PingPong).unwrap();
    for i in 0..64 {
        let secs = f64::from(i) / 16.0;
        for round in 1..4 {
            let later = secs + f64::from(round) * 4.0;
            assert_eq!(
                number(&repeat, secs).to_bits(),
                number(&repeat, later).to_bits()
            );
        }
        assert_eq!(
            number(&back, secs).to_bits(),
            number(&back, 8.0 - secs).to_bits()
        );
    }
}

#[test]
fn euler_keys_turn_all_the_way_and_others_the_short_way() {
    let turn = |to: Rotation| {
        let key = |time, rotation| Key {
            time,
            value: KeyValue::Rotation(rotation),
            ease: Ease::Linear,
        };
        let from = match to {
            Rotation::Euler(_) => Rotation::Euler(DVec3::ZERO),
            Rotation::Quat(_) => Rotation::Quat(DQuat::IDENTITY),
        };
        let curve = Curve::new(&[key(0.0, from), key(4.0, to)], Loop::Once).unwrap();
        match curve.at(1.0) {
            Value::Rotation(quat) => quat * DVec3::X,
            other => panic!("{other:?}"),
        }
    };
    let quarter = turn(Rotation::Euler(DVec3::new(0.0, 360.0, 0.0)));
    assert!(quarter.distance(DVec3::NEG_Z) < 1e-12, "{quarter}");
    let short = turn(Rotation::Quat(-DQuat::from_rotation_y(0.4)));
    assert!(
        short.distance(DQuat::from_rotation_y(0.1) * DVec3::X) < 1e-12,
        "{short}"
    );
}

#[test]
fn rotations_stay_units_under_every_ease() {
    let mut chance = Chance(3);
    for ease in [Ease::Step, Ease::Linear, Ease::InOut, Ease::Smooth] {
        let keys: Vec<Key> = (0..6)
            .map(|i| {
                let axis = DVec3::new(chance.number(), chance.number(), 1.0).normalize();
                let quat = DQuat::from_axis_angle(axis, chance.number());
                Key {
                    time: f64::from(i),
                    value: KeyValue::Rotation(Rotation::Quat(quat)),
                    ease,
                }
            })
            .collect();
        let curve = Curve::new(&keys, Loop::Repeat).unwrap();
        for i in 0..100 {
            let Value::Rotation(quat) = curve.at(f64::from(i) * 0.07) else {
                panic!()
            };
            assert!((quat.length() - 1.0).abs() < 1e-12, "{ease:?}: {quat}");
        }
    }
}

const MOVING: &str = "(version: 1,
    entities: [
        (id: \"camera\", camera: (), transform: (eye: (0, 0, 9), target: (0, 0, 0))),
        (id: \"crane\", transform: (translation: (1, 2, 3), rotation: Euler(10, 20, 30), scale: 2), children: [
            (id: \"second\", camera: ()),
        ]),
        (id: \"arm\", transform: (matrix: ((1, 0.5, 0, 2), (0, 1, 0, 0), (0, 0, 1, 0))), children: [(id: \"moon\", sphere: (), transform: (translation: (3, 1, 0)))]),
    ],
    timeline: (length: 6,
        tracks: [
            (target: \"arm\", field: \"transform.rotation\", loop: Repeat, keys: [(0, Euler(0, 0, 0)), (3, Euler(0, 360, 0))]),
            (target: \"moon\", field: \"sphere.radius\", loop: PingPong, keys: [(0, 1), (1, 2, InOut)]),
        ],
        paths: [
            (target: \"camera\", look_at: \"moon\", loop: Repeat, keys: [(0, (0, 0, 9)), (2, (4, 1, 7)), (6, (0, 0, 9))]),
            (target: \"second\", look_at: \"moon\", keys: [(0, (0, 0, 1)), (6, (1, 0, 1))]),
        ]))";

fn engine() -> Engine {
    let mut engine = Engine::new();
    load_text(&mut engine.world, MOVING, std::path::Path::new("f.ron")).unwrap();
    engine.world.insert_resource(Clock::Frame(0));
    // Times of frames are exact in binary, so a loop later is exactly the same time.
    engine.world.resource_mut::<Time>().frames_per_sec = 32.0;
    engine
}

/// Bits of every pose of the world at a frame.
fn poses(engine: &mut Engine, frame: u64) -> Vec<(String, Vec<u64>)> {
    engine.world.insert_resource(Clock::Frame(frame));
    engine.frame();
    let mut query = engine.world.query::<(&SceneId, &GlobalTransform)>();
    let mut poses: Vec<_> = query
        .iter(&engine.world)
        .map(|(id, global)| {
            (
                id.0.clone(),
                global.0.to_cols_array().map(f64::to_bits).to_vec(),
            )
        })
        .collect();
    poses.sort();
    poses
}

#[test]
fn a_pose_depends_on_the_time_alone() {
    let mut straight = engine();
    let expected: Vec<_> = (0..60).map(|frame| poses(&mut straight, frame)).collect();
    let mut jumping = engine();
    let mut chance = Chance(11);
    for _ in 0..200 {
        let frame = chance.below(60);
        assert_eq!(
            poses(&mut jumping, frame as u64),
            expected[frame],
            "frame {frame}"
        );
    }
    for (frame, expected) in expected.iter().enumerate() {
        assert_eq!(
            &poses(&mut jumping, frame as u64 + 6 * 32),
            expected,
            "after a loop"
        );
    }
}

#[test]
fn paths_look_at_where_their_target_is_in_the_same_frame() {
    let mut engine = engine();
    for frame in [0, 1, 17, 45, 100, 170] {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let mut query = engine.world.query::<(&SceneId, &GlobalTransform)>();
        let global =
            |id: &str, world: &World, query: &mut QueryState<(&SceneId, &GlobalTransform)>| {
                query
                    .iter(world)
                    .find(|(found, _)| found.0 == id)
                    .unwrap()
                    .1
                    .0
            };
        let moon = global("moon", &engine.world, &mut query).translation;
        for id in ["camera", "second"] {
            let eye = global(id, &engine.world, &mut query);
            let forward = eye.transform_vector3(DVec3::NEG_Z).normalize();
            let wanted = (moon - eye.translation).normalize();
            assert!(
                forward.distance(wanted) < 1e-9,
                "{id} at frame {frame}: {forward} {wanted}"
            );
        }
    }
}

#[test]
fn a_frame_at_the_same_time_writes_nothing() {
    let mut engine = engine();
    engine.world.insert_resource(Clock::Paused);
    engine.frame();
    let ids: Vec<(Entity, String)> = engine
        .world
        .query::<(Entity, &SceneId)>()
        .iter(&engine.world)
        .map(|(e, id)| (e, id.0.clone()))
        .collect();
    let moon = ids.iter().find(|(_, id)| id == "moon").unwrap().0;
    fields::set(
        &mut engine.world,
        moon,
        "sphere.radius",
        &Value::Number(9.0),
    )
    .unwrap();
    engine.frame();
    assert_eq!(
        fields::get(&engine.world, moon, "sphere.radius"),
        Ok(Value::Number(9.0))
    );
}

/// A radius that a smooth curve carries below zero between its keys, and a moment when it is.
const OVERSHOOTING: &str = "(version: 1,
    entities: [(id: \"moon\", sphere: ())],
    timeline: (tracks: [
        (target: \"moon\", field: \"sphere.radius\", keys: [(0, 9), (1, 0.01, Smooth), (2, 0.01, Smooth), (3, 9, Smooth)]),
    ]))";

#[test]
fn a_value_out_of_range_gives_way_to_the_nearer_key_however_the_frame_was_reached() {
    let radius = |frames: &[u64]| {
        let mut engine = Engine::new();
        load_text(
            &mut engine.world,
            OVERSHOOTING,
            std::path::Path::new("f.ron"),
        )
        .unwrap();
        for &frame in frames {
            engine.world.insert_resource(Clock::Frame(frame));
            engine.frame();
        }
        let mut spheres = engine.world.query::<&crate::world::Sphere>();
        spheres.single(&engine.world).unwrap().radius
    };
    let per_sec = Engine::new().world.resource::<Time>().frames_per_sec as u64;
    let overshoot = per_sec * 3 / 2;
    assert_eq!(radius(&[overshoot]), 0.01);
    assert_eq!(radius(&[per_sec / 2, overshoot]), 0.01);
    assert_eq!(radius(&[0, overshoot - 1, overshoot]), 0.01);
}
