//! [`Frames`]: the last frames, and the slowest ones since they were last forgotten.
//!
//! Frames come in at their report; what a device tells of earlier ones finds them by number, here and among the slowest. A
//! frame that takes longer than a limit stops the recording, so that what led to it stays to be looked at.

use std::collections::VecDeque;
use std::time::Instant;

use bevy_ecs::prelude::*;

use super::align::ClockFit;
use super::frame::{Frame, Pass, micros_between};
use super::{FrameHistory, HISTORY_FRAMES};
use crate::trace::{DeviceClock, DeviceReport};

/// Slowest frames kept.
pub const WORST_FRAMES: usize = 12;
/// Frames at the start that are slow by nature, since trees are built and shaders compiled: they stop no recording and are not
/// among the slowest.
pub const SETTLING_FRAMES: u64 = 10;

/// See the module.
#[derive(Resource, Debug)]
pub struct Frames {
    /// Where the frames' time begins.
    epoch: Instant,
    recent: VecDeque<Frame>,
    worst: Vec<Frame>,
    clocks: [ClockFit; DeviceClock::ALL.len()],
    /// Milliseconds of work from which on a frame stops the recording.
    spike_limit: Option<f64>,
    stopped: Option<Stop>,
    /// Of a frame that was forgotten, to be filled anew.
    spare: Frame,
}

/// Why nothing is recorded any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Somebody asked for it.
    Asked,
    /// This frame took longer than the limit.
    Spike(u64),
}

impl Default for Frames {
    fn default() -> Self {
        Self {
            epoch: Instant::now(),
            recent: VecDeque::with_capacity(HISTORY_FRAMES),
            worst: Vec::new(),
            clocks: Default::default(),
            spike_limit: None,
            stopped: None,
            spare: Frame::default(),
        }
    }
}

impl Frames {
    /// Frames held, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Frame> + ExactSizeIterator {
        self.recent.iter()
    }

    /// The newest.
    pub fn latest(&self) -> Option<&Frame> {
        self.recent.back()
    }

    /// The slowest, the very slowest first.
    pub fn worst(&self) -> &[Frame] {
        &self.worst
    }

    /// A frame by its number, if it is still held.
    pub fn get(&self, id: u64) -> Option<&Frame> {
        let kept = self.worst.iter().find(|frame| frame.id == id);
        self.place(id).map(|at| &self.recent[at]).or(kept)
    }

    /// Where in the ring a frame is: numbers rise there.
    fn place(&self, id: u64) -> Option<usize> {
        self.recent.binary_search_by_key(&id, |frame| frame.id).ok()
    }

    /// Why nothing is recorded, if so.
    pub fn stopped(&self) -> Option<Stop> {
        self.stopped
    }

    /// Stops recording, or goes on.
    pub fn set_stopped(&mut self, stopped: bool) {
        self.stopped = stopped.then_some(Stop::Asked);
    }

    /// Milliseconds of work from which on a frame stops the recording.
    pub fn spike_limit(&self) -> Option<f64> {
        self.spike_limit
    }

    /// Has a frame that works for longer stop the recording; none: no frame does.
    pub fn set_spike_limit(&mut self, millis: Option<f64>) {
        self.spike_limit = millis;
    }

    /// Forgets the slowest, say after something was loaded.
    pub fn forget_worst(&mut self) {
        self.worst.clear();
    }

    /// The times of work of the frames held.
    pub fn work(&self) -> FrameHistory {
        let mut history = FrameHistory::default();
        for frame in &self.recent {
            history.push(frame.work_micros() * 1e-3);
        }
        history
    }

    /// A moment on the frames' axis, microseconds.
    pub(super) fn micros(&self, at: Instant) -> f64 {
        micros_between(self.epoch, at)
    }

    /// Of a frame that is no longer held, for its room.
    pub(super) fn take_spare(&mut self) -> Frame {
        std::mem::take(&mut self.spare)
    }

    /// Takes in the frame that has just ended; drops it if recording stands still.
    pub fn push(&mut self, frame: Frame) {
        if self.stopped.is_some() || self.latest().is_some_and(|last| last.id >= frame.id) {
            self.spare = frame;
            return;
        }
        if let Some(last) = self.recent.back_mut()
            && last.id + 1 == frame.id
        {
            last.interval_micros = frame.start_micros - last.start_micros;
        }
        if self.recent.len() == HISTORY_FRAMES
            && let Some(oldest) = self.recent.pop_front()
        {
            self.spare = oldest;
        }
        let id = frame.id;
        self.recent.push_back(frame);
        self.look_at(id);
    }

    /// Gives the passes of a device, and its rays, to the frame they are of.
    pub fn note_device(&mut self, report: &DeviceReport) {
        let clock = report.clock as usize;
        for pass in &report.passes {
            let host = [pass.submitted, pass.seen].map(|at| self.micros(at));
            self.clocks[clock].note(pass.micros, host);
        }
        let Some(at) = self.place(report.frame) else {
            return;
        };
        let frame = &mut self.recent[at];
        if let Some(offset) = self.clocks[clock].offset() {
            frame.passes.extend(report.passes.iter().map(|pass| Pass {
                name: pass.name.into(),
                start_micros: pass.micros[0] + offset.micros - frame.start_micros,
                micros: (pass.micros[1] - pass.micros[0]).max(0.0),
                error_micros: offset.error_micros,
            }));
            let order = |a: &Pass, b: &Pass| a.start_micros.total_cmp(&b.start_micros);
            frame.passes.sort_by(order);
        }
        if let Some(rays) = report.rays {
            frame.counters = frame.counters.with_rays_of(rays);
            frame.awaits_device = false;
        }
        self.look_at(report.frame);
    }

    /// Whether a frame is one of the slowest, or a spike, now that more of it is known.
    fn look_at(&mut self, id: u64) {
        let Some(frame) = self.place(id).map(|at| &self.recent[at]) else {
            return;
        };
        if id <= SETTLING_FRAMES {
            return;
        }
        let work = frame.work_micros();
        let is_known = self.worst.iter().any(|known| known.id == id);
        let least = self.worst.last().map_or(0.0, Frame::work_micros);
        if is_known || self.worst.len() < WORST_FRAMES || work > least {
            self.worst.retain(|known| known.id != id);
            let place = self
                .worst
                .partition_point(|known| known.work_micros() >= work);
            self.worst.insert(place, frame.clone());
            self.worst.truncate(WORST_FRAMES);
        }
        let is_spike = self.spike_limit.is_some_and(|limit| work > limit * 1e3);
        if is_spike && self.stopped.is_none() {
            self.stopped = Some(Stop::Spike(id));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::trace::{Counters, DevicePass};

    fn frame(id: u64, millis: f64) -> Frame {
        Frame {
            id,
            start_micros: id as f64 * 20e3,
            micros: millis * 1e3,
            ..Frame::default()
        }
    }

    #[test]
    fn the_slowest_stay_when_the_ring_has_forgotten_them() {
        let mut frames = Frames::default();
        let last = 3 * HISTORY_FRAMES as u64;
        for id in 1..=last {
            let slow = if id == 5 || id == 77 { 90.0 } else { 5.0 };
            frames.push(frame(id, slow + id as f64 * 1e-3));
        }
        assert_eq!(frames.iter().len(), HISTORY_FRAMES);
        assert_eq!(frames.worst().len(), WORST_FRAMES);
        let order: Vec<u64> = frames.worst().iter().take(3).map(|f| f.id).collect();
        assert_eq!(
            order,
            [77, last, last - 1],
            "those that settle do not count"
        );
        assert!(frames.get(77).is_some() && frames.get(78).is_none());
        assert_eq!(frames.get(last - 1).map(|f| f.interval_micros), Some(20e3));
        frames.forget_worst();
        assert!(frames.get(77).is_none());
    }

    #[test]
    fn a_spike_stops_the_recording_until_it_is_resumed() {
        let mut frames = Frames::default();
        frames.set_spike_limit(Some(30.0));
        for id in 1..=40 {
            frames.push(frame(id, if id == 3 || id == 25 { 31.0 } else { 5.0 }));
        }
        assert_eq!(frames.stopped(), Some(Stop::Spike(25)));
        assert_eq!(frames.latest().map(|f| f.id), Some(25));
        frames.set_stopped(false);
        frames.push(frame(41, 5.0));
        assert_eq!(frames.latest().map(|f| f.id), Some(41));
    }

    #[test]
    fn what_a_device_tells_late_finds_its_frame() {
        let mut frames = Frames::default();
        for id in 1..=20 {
            frames.push(frame(id, 5.0));
        }
        frames.set_spike_limit(Some(30.0));
        let submitted = frames.epoch + Duration::from_micros(15 * 20_000 + 1000);
        let pass = DevicePass {
            name: "whitted",
            submitted,
            seen: submitted + Duration::from_millis(48),
            micros: [7e9, 7e9 + 40e3],
        };
        let report = |frame| DeviceReport {
            frame,
            clock: DeviceClock::Tracer,
            passes: vec![pass],
            rays: Some(Counters {
                primary_rays: 64,
                ..Counters::default()
            }),
        };
        frames.note_device(&report(9999));
        frames.note_device(&report(15));
        let found = frames.get(15).expect("it is held");
        let [pass] = found.passes.as_slice() else {
            panic!("{:?}", found.passes);
        };
        assert!((pass.start_micros - 1000.0).abs() < 1e-2, "{pass:?}");
        assert!((pass.micros - 40e3).abs() < 1e-2, "{pass:?}");
        assert!((pass.error_micros - 8000.0).abs() < 1e-2, "{pass:?}");
        assert_eq!(found.counters.primary_rays, 64);
        assert_eq!(frames.worst()[0].id, 15, "its device made it slow");
        assert_eq!(frames.stopped(), Some(Stop::Spike(15)));
    }
}
