//! Known values of every interpolation, blending, repeating, scrubbing, and clips in a world.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DQuat, DVec3};

use super::set::Moment;
use super::*;
use crate::app::Engine;
use crate::time::{Clock, Time};
use crate::world::{Camera, Loop, Morph, Projection, Transform, Visibility};

fn track(channel: Channel, interpolation: Interpolation, times: &[f64], values: &[f64]) -> Track {
    let track = Track {
        target: 0,
        channel,
        times: times.to_vec(),
        values: values.to_vec(),
        interpolation,
    };
    track.check().unwrap();
    track
}

fn at(track: &Track, secs: f64) -> Vec<f64> {
    let mut out = Vec::new();
    track.sample(secs, &mut out);
    out
}

fn near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

#[test]
fn keys_hold_step_go_straight_or_follow_the_curve() {
    let keys = [1.0, 2.0, 4.0];
    let weights = |interpolation| {
        let values = [0.0, 1.0, 4.0, 3.0, 8.0, -1.0];
        track(Channel::Weights, interpolation, &keys, &values)
    };
    let step = weights(Interpolation::Step);
    assert_eq!(step.width(), 2);
    for (secs, value) in [(0.0, [0.0, 1.0]), (1.5, [0.0, 1.0]), (2.0, [4.0, 3.0])] {
        assert_eq!(at(&step, secs), value, "{secs}");
    }
    let linear = weights(Interpolation::Linear);
    for (secs, value) in [
        (-9.0, [0.0, 1.0]),
        (1.25, [1.0, 1.5]),
        (2.0, [4.0, 3.0]),
        (3.0, [6.0, 1.0]),
        (9.0, [8.0, -1.0]),
    ] {
        assert_eq!(at(&linear, secs), value, "{secs}");
    }
    // Reached, value, left: the velocities of t^3 at 0, 1 and 3.
    let values = [0.0, 0.0, 0.0, 3.0, 1.0, 3.0, 27.0, 27.0, 27.0];
    let cubic = track(
        Channel::Weights,
        Interpolation::Cubic,
        &[0.0, 1.0, 3.0],
        &values,
    );
    assert_eq!(cubic.width(), 1);
    for secs in [0.0, 0.3, 1.0, 1.9, 2.7, 3.0] {
        assert!(near(&at(&cubic, secs), &[secs.powi(3)]), "{secs}");
    }
}

#[test]
fn two_keys_at_one_time_are_a_jump() {
    let times = [0.0, 1.0, 1.0, 2.0];
    let jump = track(
        Channel::Shown,
        Interpolation::Linear,
        &times,
        &[0.0, 1.0, 5.0, 6.0],
    );
    assert_eq!(at(&jump, 0.5), [0.5]);
    assert_eq!(at(&jump, 1.0), [5.0]);
    assert_eq!(at(&jump, 1.5), [5.5]);
}

#[test]
fn rotations_take_the_shorter_way() {
    let turn = DQuat::from_rotation_z;
    for sign in [1.0, -1.0] {
        let keys: Vec<f64> = [
            turn(0.1).to_array(),
            (turn(0.1 + FRAC_PI_2) * sign).to_array(),
        ]
        .concat();
        let track = track(Channel::Rotation, Interpolation::Linear, &[0.0, 2.0], &keys);
        for secs in [0.0, 0.5, 1.7, 2.0] {
            let found = DQuat::from_slice(&at(&track, secs));
            let expected = turn(0.1 + FRAC_PI_4 * secs);
            assert!(
                found.dot(expected).abs() > 1.0 - 1e-12,
                "{sign} {secs}: {found}"
            );
        }
    }
    // The cubic goes through the four numbers as they are, and stays a rotation.
    let still = [0.0; 4];
    let (a, b) = (turn(0.0).to_array(), turn(2.0).to_array());
    let keys = [still, a, still, still, b, still].concat();
    let cubic = track(Channel::Rotation, Interpolation::Cubic, &[0.0, 1.0], &keys);
    let found = DQuat::from_slice(&at(&cubic, 0.5));
    assert!(near(&found.to_array(), &turn(1.0).to_array()), "{found}");
    assert!(DQuat::from_slice(&at(&cubic, 0.21)).is_normalized());
}

#[test]
fn tracks_that_cannot_be_played_say_why() {
    let good = track(
        Channel::Scale,
        Interpolation::Linear,
        &[0.0, 1.0],
        &[1.0; 6],
    );
    for (times, values, why) in [
        (vec![], vec![], "no key"),
        (vec![1.0, 0.0], vec![1.0; 6], "fall"),
        (vec![0.0, f64::NAN], vec![1.0; 6], "not finite"),
        (vec![0.0, 1.0], vec![1.0; 7], "7 numbers for 2 keys"),
        (vec![0.0, 1.0], vec![f64::INFINITY; 6], "not finite"),
    ] {
        let bad = Track {
            times,
            values,
            ..good.clone()
        };
        let found = bad.check().unwrap_err();
        assert!(found.contains(why), "{found}");
    }
}

/// Two clips of one target: 0 keys translation and rotation, 1 the translation alone.
fn two_clips() -> ClipSet {
    let place = |x: f64| [x, 0.0, 0.0, x + 1.0, 0.0, 0.0];
    let turns = [
        DQuat::IDENTITY.to_array(),
        (-DQuat::from_rotation_y(1.0)).to_array(),
    ]
    .concat();
    let times = [0.0, 1.0];
    let linear = Interpolation::Linear;
    let clip = |tracks| Clip {
        name: String::new(),
        start: 0.0,
        end: 1.0,
        tracks,
    };
    let clips = vec![
        clip(vec![
            track(Channel::Translation, linear, &times, &place(0.0)),
            track(Channel::Rotation, linear, &times, &turns),
        ]),
        clip(vec![track(
            Channel::Translation,
            linear,
            &times,
            &place(10.0),
        )]),
    ];
    ClipSet::new(clips, |track| {
        let rest = match track.channel {
            Channel::Rotation => DQuat::IDENTITY.to_array().to_vec(),
            _ => vec![-1.0, 2.0, 3.0],
        };
        vec![ClipPlace { target: 0, rest }]
    })
}

#[test]
fn layers_blend_by_weight_and_the_rest_pose_has_what_is_missing() {
    let set = two_clips();
    let moment = |clip, secs, weight| Moment { clip, secs, weight };
    let mixed = |row: usize, moments: &[Moment]| {
        let mut out = Vec::new();
        set.mix(&set.keyed()[row], moments, &mut out);
        out
    };
    let (a, b) = (moment(0, 0.5, 1.0), moment(1, 1.0, 1.0));
    assert_eq!(set.keyed()[0].channel, Channel::Translation);
    assert_eq!(mixed(0, &[a]), [0.5, 0.0, 0.0]);
    assert_eq!(mixed(0, &[a, b]), [5.75, 0.0, 0.0]);
    assert_eq!(mixed(0, &[]), [-1.0, 2.0, 3.0]);
    assert_eq!(mixed(0, &[moment(0, 0.5, 0.25)]), [-0.625, 1.5, 2.25]);
    let heavy = [moment(0, 0.0, 3.0), moment(1, 0.0, 1.0)];
    assert_eq!(mixed(0, &heavy), [2.5, 0.0, 0.0]);
    // Half of a turn whose quaternion has the other sign; and one that only one of two clips keys.
    let half = DQuat::from_rotation_y(0.5);
    for moments in [
        vec![moment(0, 1.0, 0.5)],
        vec![moment(0, 1.0, 0.5), moment(1, 0.0, 0.5)],
    ] {
        let found = DQuat::from_slice(&mixed(1, &moments));
        assert!(found.dot(half).abs() > 1.0 - 1e-12, "{found}");
    }
}

/// An engine with a player of one layer over four kinds of target, which are one entity.
fn scene() -> (Engine, Entity, Entity) {
    let times = [0.0, 2.0];
    let linear = Interpolation::Linear;
    let turns = [
        DQuat::IDENTITY.to_array(),
        DQuat::from_rotation_x(PI * 0.9).to_array(),
    ]
    .concat();
    let tracks = vec![
        track(
            Channel::Translation,
            linear,
            &times,
            &[0.0, 0.0, 0.0, 4.0, 2.0, 0.0],
        ),
        track(Channel::Rotation, linear, &times, &turns),
        track(Channel::Weights, linear, &times, &[0.0, 1.0, 1.0, 0.5]),
        track(Channel::VerticalFov, linear, &times, &[1.0, 2.0]),
        track(Channel::Shown, Interpolation::Step, &times, &[1.0, 0.0]),
    ];
    let clips = vec![Clip {
        name: "a".into(),
        start: 0.0,
        end: 2.0,
        tracks,
    }];
    let clips = ClipSet::new(clips, |track| {
        vec![ClipPlace {
            target: 0,
            rest: vec![1.0; track.width()],
        }]
    });
    let mut engine = Engine::new();
    let camera = Camera::default();
    let morph = Morph {
        weights: vec![0.0; 2],
        ..Morph::default()
    };
    let scale = DVec3::new(1.0, 2.0, 3.0);
    let pose = Transform {
        scale,
        ..Transform::IDENTITY
    };
    let target = engine
        .world
        .spawn((pose, morph, camera, Visibility::default()))
        .id();
    let layers = vec![ClipLayer::default()];
    let targets = vec![target];
    let player = engine
        .world
        .spawn(ClipPlayer {
            clips: Arc::new(clips),
            targets,
            layers,
        })
        .id();
    engine.validate().unwrap();
    (engine, player, target)
}

type State = (Transform, Vec<f64>, Projection, bool);

fn state(engine: &Engine, target: Entity) -> State {
    let target = engine.world.entity(target);
    (
        *target.get::<Transform>().unwrap(),
        target.get::<Morph>().unwrap().weights.clone(),
        target.get::<Camera>().unwrap().projection,
        target.get::<Visibility>().unwrap().shown,
    )
}

fn go(engine: &mut Engine, frame: u64) {
    engine.world.insert_resource(Clock::Frame(frame));
    engine.frame();
}

#[test]
fn a_player_writes_every_channel_and_scrubs_back_to_the_same_bits() {
    let (mut engine, _, target) = scene();
    go(&mut engine, 15);
    let half = state(&engine, target);
    assert_eq!(half.0.translation, DVec3::new(1.0, 0.5, 0.0));
    assert_eq!(half.0.scale, DVec3::new(1.0, 2.0, 3.0), "no clip keys it");
    assert_eq!(half.1, [0.25, 0.875]);
    assert_eq!(half.2, Projection::Perspective { vertical_fov: 1.25 });
    assert!(half.3);
    let bits = format!("{half:?}");
    for frame in [37, 1000, 2, 59, 76, 61] {
        go(&mut engine, frame);
        assert_ne!(format!("{:?}", state(&engine, target)), bits);
    }
    // The clip is 60 frames long and repeats.
    for frame in [15, 75, 60_015] {
        go(&mut engine, frame);
        assert_eq!(
            format!("{:?}", state(&engine, target)),
            bits,
            "frame {frame}"
        );
    }
}

#[test]
fn a_scene_that_stands_can_be_edited_and_its_players_too() {
    let (mut engine, player, target) = scene();
    go(&mut engine, 15);
    let moved = Transform::from_translation(DVec3::X * 9.0);
    engine.world.entity_mut(target).insert(moved);
    go(&mut engine, 15);
    assert_eq!(
        state(&engine, target).0,
        moved,
        "the same time writes nothing"
    );
    let changed = |engine: &mut Engine| {
        let since = engine.world.read_change_tick();
        engine.frame();
        let ticks = engine
            .world
            .entity(target)
            .get_change_ticks::<Transform>()
            .unwrap();
        ticks.is_changed(since, engine.world.change_tick())
    };
    assert!(!changed(&mut engine));
    let layer = |engine: &mut Engine, edit: fn(&mut ClipLayer)| {
        edit(&mut engine.world.get_mut::<ClipPlayer>(player).unwrap().layers[0]);
    };
    layer(&mut engine, |layer| {
        (layer.start, layer.paused) = (0.5, true)
    });
    assert!(changed(&mut engine));
    assert_eq!(
        state(&engine, target).0.translation,
        DVec3::new(1.0, 0.5, 0.0)
    );
    go(&mut engine, 37);
    assert_eq!(
        state(&engine, target).0.translation,
        DVec3::new(1.0, 0.5, 0.0)
    );
    assert!(!changed(&mut engine));
    engine.world.entity_mut(target).insert(moved);
    go(&mut engine, 38);
    assert_eq!(
        state(&engine, target).0,
        moved,
        "what is paused writes nothing"
    );
    layer(&mut engine, |layer| {
        (layer.paused, layer.repeat, layer.speed) = (false, Loop::Once, -0.5);
    });
    go(&mut engine, 15);
    assert_eq!(
        state(&engine, target).0.translation,
        DVec3::new(0.5, 0.25, 0.0)
    );
    engine
        .world
        .get_mut::<ClipPlayer>(player)
        .unwrap()
        .layers
        .clear();
    engine.frame();
    assert_eq!(
        state(&engine, target).0.translation,
        DVec3::ONE,
        "the rest pose"
    );
    assert_eq!(engine.world.resource::<Time>().secs, 0.5);
}

#[test]
fn targets_that_are_gone_and_layers_that_make_no_sense_stop_nobody() {
    let (mut engine, player, target) = scene();
    let mut layers = engine.world.get_mut::<ClipPlayer>(player).unwrap();
    layers.layers.extend([
        ClipLayer {
            clip: 7,
            ..ClipLayer::default()
        },
        ClipLayer {
            speed: f64::NAN,
            ..ClipLayer::default()
        },
        ClipLayer {
            weight: f64::INFINITY,
            ..ClipLayer::default()
        },
    ]);
    go(&mut engine, 15);
    assert_eq!(
        state(&engine, target).0.translation,
        DVec3::new(1.0, 0.5, 0.0)
    );
    engine.world.despawn(target);
    go(&mut engine, 20);
}
