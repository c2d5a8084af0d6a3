//! The clock. Simulation time is a pure function of the tick, so frame N is the same on every run.

use bevy_ecs::prelude::*;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// Where the scene's time comes from.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// The next frame shows exactly this frame number (headless runs); stays until changed.
    Frame(u64),
    /// Follows the wall clock (windows).
    Wall,
    /// Stands still.
    Paused,
}

/// Scene time.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Seconds of scene time since its start.
    pub secs: f64,
    /// Seconds of scene time since the last frame.
    pub delta_secs: f64,
    /// Seconds of wall time since the last frame (camera flight, frame rate); never part of a picture.
    pub wall_delta_secs: f64,
    /// Frames run since the engine started.
    pub frame: u64,
    /// Frame numbers a second of scene time.
    pub frames_per_sec: f64,
}

impl Default for Time {
    fn default() -> Self {
        Self {
            secs: 0.0,
            delta_secs: 0.0,
            wall_delta_secs: 0.0,
            frame: 0,
            frames_per_sec: 30.0,
        }
    }
}

impl Time {
    /// The frame of the scene that is shown.
    pub fn number(&self) -> u64 {
        // Rounded: 7/30 s times 30 is a little less than 7.
        (self.secs * self.frames_per_sec + 1e-6) as u64
    }
}

/// Wall time of the last frame's start.
#[derive(Resource, Clone, Copy, Debug)]
struct LastFrame(std::time::Instant);

/// Adds the clock (set [`FrameSet::Input`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.insert_resource(Clock::Paused);
    engine.world.init_resource::<Time>();
    engine
        .world
        .insert_resource(LastFrame(std::time::Instant::now()));
    engine.add_systems(FrameSet::Input, advance);
}

/// Moves [`Time`] to this frame.
fn advance(clock: Res<Clock>, mut last: ResMut<LastFrame>, mut time: ResMut<Time>) {
    let now = std::time::Instant::now();
    let wall = now.duration_since(last.0).as_secs_f64();
    last.0 = now;
    let secs = match *clock {
        Clock::Frame(number) => number as f64 / time.frames_per_sec,
        // A long stall (a breakpoint, a slow first frame) must not throw the scene far ahead.
        Clock::Wall => time.secs + wall.min(0.25),
        Clock::Paused => time.secs,
    };
    time.delta_secs = secs - time.secs;
    time.secs = secs;
    time.wall_delta_secs = wall;
    time.frame += 1;
}
