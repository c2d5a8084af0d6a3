//! What a device tells of its passes: which frame they were for, and when, by its own clock.
//!
//! Tracers and the screen hand it to the profile, which finds each pass its frame by the frame's number and its place among
//! the host's spans by when it was submitted and when it was seen to be over.

use std::time::Instant;

use super::Counters;

/// Whose clock timestamps are of: a picture may be traced on one device and shown on another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceClock {
    /// The tracer's.
    Tracer,
    /// The screen's.
    Screen,
}

impl DeviceClock {
    /// All.
    pub const ALL: [Self; 2] = [Self::Tracer, Self::Screen];
}

/// What a device did for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceReport {
    /// The frame's number.
    pub frame: u64,
    /// Of the passes.
    pub clock: DeviceClock,
    /// In order; empty: the device has no timestamps.
    pub passes: Vec<DevicePass>,
    /// Rays, and what was left out of them; none: it traced none.
    pub rays: Option<Counters>,
}

/// Bytes written to one of a tracer's buffers for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Upload {
    /// As the buffer is called.
    pub buffer: &'static str,
    /// How many.
    pub bytes: u64,
}

/// A pass of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DevicePass {
    /// As its shader file or step is called.
    pub name: &'static str,
    /// It began no earlier than this on the host's clock.
    pub submitted: Instant,
    /// It was over no later than this on the host's clock.
    pub seen: Instant,
    /// Begin and end on the device's own clock, microseconds from wherever that starts.
    pub micros: [f64; 2],
}
