//! Poses after a million frames: driven by time they are exact, whole periods bit for bit.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3, Quat};
use orrery_engine::world::{Orbit, Spin, Sway};

use super::course::Course;
use super::draw::Draw;
use super::tally::{Tally, Verdict, ulps};
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "drift";
/// Frames gone by.
const FRAMES: u64 = 1_000_000;
/// Frames a second; a power of two, so that times are exact.
const FRAMES_PER_SEC: f64 = 32.0;
/// Things that move.
const THINGS: u64 = 2000;
/// Largest error of a pose, in f32 ULPs.
const MOST_ULPS: f64 = 2.0;

/// Runs what adds up, then what does not.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let things = course.brief(THINGS);
    let mut added = Tally::default();
    for index in 0..course.brief(64) + 4 {
        let off = ulps(f64::from(norm_of_products(index)), 1.0);
        added.take(Verdict::of(off <= MOST_ULPS));
    }
    course.must_fail(&format!("{NAME}.f32_products"), &added, None);
    let mut poses = Tally::default();
    let mut periods = Tally::default();
    for index in 0..things {
        let off = pose_error(index);
        poses.take(if off <= MOST_ULPS {
            Verdict::Off(off)
        } else {
            Verdict::Wrong
        });
        periods.take(Verdict::of(returns(index)));
    }
    course.none_may_fail(&format!("{NAME}.poses"), &poses);
    course.none_may_fail(&format!("{NAME}.whole_periods"), &periods);
    Ok(())
}

/// The length of a unit quaternion that is multiplied by a small turn every frame.
fn norm_of_products(index: u64) -> f32 {
    let mut draw = Draw::of(1600, index);
    let step = Quat::from_axis_angle(draw.direction_f32(), 0.01);
    let turned = (0..FRAMES).fold(Quat::IDENTITY, |q, _| step * q);
    turned.length()
}

/// A spin whose period is a whole number of 64ths of a second.
fn spin(draw: &mut Draw) -> (Spin, u64) {
    let sixty_fourths = 1 + draw.below(4096) as u64;
    let spin = Spin {
        axis: draw.direction(),
        period: sixty_fourths as f64 / 64.0,
        phase: 0.0,
    };
    (spin, sixty_fourths)
}

/// How far a spin is off in the frames after the millionth, against whole numbers.
fn pose_error(index: u64) -> f64 {
    let mut draw = Draw::of(1700, index);
    let (spin, period) = spin(&mut draw);
    let frame = FRAMES + draw.below(10_000) as u64;
    let found = spin.at(frame as f64 / FRAMES_PER_SEC);
    // A frame is two 64ths.
    let turn = (2 * frame % period) as f64 / period as f64;
    let (sin, cos) = (0.5 * TAU * turn).sin_cos();
    let exact = DQuat::from_vec4((spin.axis.normalize() * sin).extend(cos));
    let parts = found.to_array().into_iter().zip(exact.to_array());
    // Errors of small components count against the whole, whose length is 1.
    let error = parts.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    ulps(1.0 + error, 1.0).max(ulps(found.length(), 1.0))
}

/// Whether everything is where it was after whole periods.
fn returns(index: u64) -> bool {
    let mut draw = Draw::of(1800, index);
    let (spin, _) = spin(&mut draw);
    let period = spin.period;
    let after = period * draw.below(FRAMES as usize) as f64;
    let orbit = Orbit {
        axis: draw.direction(),
        period,
        phase: draw.range(0.0, 6.0),
        ..Orbit::default()
    };
    let sway = Sway {
        amplitude: draw.cube(),
        period,
        phase: draw.range(0.0, 6.0),
    };
    let bits = |v: DVec3| v.to_array().map(f64::to_bits);
    spin.at(after) == spin.at(0.0)
        && bits(orbit.at(after)) == bits(orbit.at(0.0))
        && bits(sway.at(after)) == bits(sway.at(0.0))
}
