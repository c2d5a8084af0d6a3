//! Motion after a million frames, and in a world.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3};

use super::*;
use crate::app::Engine;
use crate::time::Clock;
use crate::world::GlobalTransform;

fn all() -> (Orbit, Spin, Sway, PathMotion) {
    let orbit = Orbit {
        axis: DVec3::new(0.3, 2.0, -0.4),
        center: DVec3::new(1.0, 2.0, 3.0),
        radius: 2.5,
        period: 2.5,
        phase: 1.0,
    };
    let spin = Spin {
        axis: DVec3::new(1.0, -2.0, 0.5),
        period: -0.75,
        phase: 0.2,
    };
    let sway = Sway {
        period: 1.25,
        phase: 0.7,
        ..Sway::default()
    };
    let path = PathMotion {
        points: vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE],
        period: 3.75,
        start: 0.25,
        look_along: true,
        ..PathMotion::default()
    };
    (orbit, spin, sway, path)
}

fn rest() -> Transform {
    Transform {
        translation: DVec3::new(10.0, -3.0, 0.5),
        rotation: DQuat::from_rotation_z(0.3),
        scale: DVec3::new(1.0, 2.0, 3.0),
    }
}

fn pose_at(secs: f64) -> Transform {
    let (orbit, spin, sway, path) = all();
    Motions {
        orbit: Some(&orbit),
        spin: Some(&spin),
        sway: Some(&sway),
        path: Some(&path),
    }
    .pose(&rest(), secs)
}

#[test]
fn whole_periods_change_no_bit() {
    // 15 s hold a whole number of every period.
    for step in 0..200 {
        let secs = f64::from(step) * 0.0625;
        let (first, later) = (pose_at(secs), pose_at(secs + 15.0 * 1e6));
        let bits = |pose: &Transform| {
            let translation = pose.translation.to_array().map(f64::to_bits);
            (translation, pose.rotation.to_array().map(f64::to_bits))
        };
        assert_eq!(bits(&first), bits(&later), "at {secs} s");
    }
}

#[test]
fn rotations_stay_unit_for_a_million_frames() {
    for frame in (0..1_000_000).step_by(37) {
        let pose = pose_at(f64::from(frame) / 30.0);
        let error = (pose.rotation.length() - 1.0).abs();
        assert!(error <= 2.0 * f64::EPSILON, "frame {frame}: {error:e}");
    }
}

#[test]
fn motions_are_what_their_names_say() {
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} != {b}");
    let orbit = Orbit {
        radius: 2.0,
        period: 4.0,
        ..Orbit::default()
    };
    near(orbit.at(0.0), DVec3::X * 2.0);
    near(orbit.at(1.0), DVec3::NEG_Z * 2.0);
    let about_x = Orbit {
        axis: DVec3::X * 5.0,
        ..orbit
    };
    near(about_x.at(0.0), DVec3::Y * 2.0);
    near(about_x.at(1.0), DVec3::Z * 2.0);
    let spin = Spin {
        period: 4.0,
        ..Spin::default()
    };
    near(spin.at(1.0) * DVec3::X, DVec3::NEG_Z);
    let sway = Sway {
        phase: FRAC_PI_2,
        ..Sway::default()
    };
    near(sway.at(0.5), DVec3::NEG_Y);
    let line = PathMotion {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, 1.0)],
        closed: false,
        smooth: false,
        look_along: true,
        period: 4.0,
        start: 0.0,
    };
    for (secs, position, ahead) in [
        (0.5, DVec3::X * 0.5, DVec3::X),
        (1.5, DVec3::new(1.0, 0.0, 0.5), DVec3::Z),
        (2.5, DVec3::new(1.0, 0.0, 0.5), DVec3::NEG_Z),
        (3.5, DVec3::X * 0.5, DVec3::NEG_X),
    ] {
        let (found, turn) = line.at(secs);
        near(found, position);
        near(turn.unwrap() * DVec3::NEG_Z, ahead);
    }
}

#[test]
fn a_smooth_path_meets_its_points_without_a_kink() {
    for closed in [true, false] {
        let path = PathMotion {
            points: all().3.points,
            closed,
            ..PathMotion::default()
        };
        let count = if closed { 4 } else { 3 };
        for i in 0..count {
            let (start, before) = path.segment(i, 0.0);
            assert_eq!(start, path.points[i]);
            if i > 0 || closed {
                let (end, after) = path.segment((i + count - 1) % count, 1.0);
                assert!((end - start).length() < 1e-12, "{end} != {start}");
                assert!((before - after).length() < 1e-12, "{before} != {after}");
            }
        }
    }
}

#[test]
fn motion_starts_from_the_pose_it_finds() {
    let mut engine = Engine::new();
    engine.validate().unwrap();
    let entity = engine.world.spawn((all(), rest())).id();
    let late = engine.world.spawn(rest()).id();
    engine.frame();
    engine.world.entity_mut(late).insert(all());
    for frame in [0, 7, 100_000_000] {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let expected = pose_at(frame as f64 / 30.0);
        for entity in [entity, late] {
            assert_eq!(engine.world.get::<Rest>(entity), Some(&Rest(rest())));
            assert_eq!(engine.world.get::<Transform>(entity), Some(&expected));
            let global = engine.world.get::<GlobalTransform>(entity).unwrap();
            assert_eq!(global.0, expected.affine());
        }
    }
    let elsewhere = Transform::from_translation(DVec3::X * 1e7);
    engine.world.get_mut::<Rest>(entity).unwrap().0 = elsewhere;
    engine.frame();
    let moved = engine.world.get::<Transform>(entity).unwrap();
    assert!(moved.translation.x > 9e6, "{moved:?}");
}

#[test]
fn the_rest_pose_goes_with_the_last_motion() {
    let mut world = World::new();
    let entity = world.spawn((Spin::default(), Sway::default())).id();
    world.entity_mut(entity).remove::<Spin>();
    assert!(world.get::<Rest>(entity).is_some());
    world.entity_mut(entity).insert(Sway {
        phase: TAU,
        ..Sway::default()
    });
    assert!(world.get::<Rest>(entity).is_some());
    world.entity_mut(entity).remove::<Sway>();
    assert!(world.get::<Rest>(entity).is_none());
    let both = world.spawn((Spin::default(), Sway::default())).id();
    world.entity_mut(both).remove::<(Spin, Sway)>();
    assert!(world.get::<Rest>(both).is_none());
    world.despawn(both);
}

#[test]
fn only_what_moves_is_marked_changed() {
    let mut engine = Engine::new();
    let still = Orbit {
        period: 0.0,
        ..Orbit::default()
    };
    // Enough for several tasks; one thing in a hundred moves.
    let entities: Vec<Entity> = (0..3000)
        .map(|i| {
            let orbit = if i % 100 == 0 {
                Orbit::default()
            } else {
                still
            };
            engine.world.spawn(orbit).id()
        })
        .collect();
    let ticks = |engine: &Engine| -> Vec<_> {
        let ticks = |&e: &Entity| engine.world.entity(e).get_change_ticks::<Transform>();
        entities.iter().map(|e| ticks(e).unwrap().changed).collect()
    };
    engine.frame();
    let before = ticks(&engine);
    engine.frame();
    assert_eq!(before, ticks(&engine), "time stands still");
    engine.world.insert_resource(Clock::Frame(5));
    engine.frame();
    for (i, (before, after)) in before.iter().zip(ticks(&engine)).enumerate() {
        assert_eq!(*before != after, i % 100 == 0, "entity {i}");
    }
}
