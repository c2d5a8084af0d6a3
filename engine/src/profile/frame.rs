//! [`Frame`]: what one frame cost, on the host and on the device, on one axis.
//!
//! Built by the profile's report at the end of each frame; passes of a device are added when they come back. Panels, files
//! and comparisons read nothing else.

use std::sync::Arc;

use crate::trace::{Counters, PassTime};

/// One run of one system, or of a step within one.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// The system's function, module paths left out: `propagate<GlobalTransform>`; or the step's name.
    pub name: Arc<str>,
    /// Microseconds from the frame's start.
    pub start_micros: f64,
    /// Microseconds it ran.
    pub micros: f64,
    /// Spans it lies within: 0 for a system.
    pub depth: u16,
}

impl Span {
    /// When it ended, microseconds from the frame's start.
    pub fn end_micros(&self) -> f64 {
        self.start_micros + self.micros
    }
}

/// A pass of the device for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// As its shader file or step is called.
    pub name: Arc<str>,
    /// Microseconds from the frame's start on the host's clock, at the earliest.
    pub start_micros: f64,
    /// Microseconds, by the device's timestamps.
    pub micros: f64,
    /// How much later on the host's clock it may have been, microseconds: the two clocks are known to agree this well.
    pub error_micros: f64,
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Its number, as the clock counts frames run.
    pub id: u64,
    /// Seconds of scene time it shows.
    pub secs: f64,
    /// When its first system began, microseconds since the profile began.
    pub start_micros: f64,
    /// From there to its report.
    pub micros: f64,
    /// Of that, what the display was waited for.
    pub wait_micros: f64,
    /// From its start to the next one's; 0 until that has begun.
    pub interval_micros: f64,
    /// Systems and their steps in order of their start, what lies within another after it.
    pub spans: Vec<Span>,
    /// What the device did for it, in order; empty until that has come back.
    pub passes: Vec<Pass>,
    /// What it counted; of rays on a device, 0 until they have come back.
    pub counters: Counters,
    /// The device has not told yet of its rays.
    pub awaits_device: bool,
}

impl Frame {
    /// Microseconds of the host's work: without the wait for the display.
    pub fn host_micros(&self) -> f64 {
        (self.micros - self.wait_micros).max(0.0)
    }

    /// Microseconds the device worked for it.
    pub fn device_micros(&self) -> f64 {
        self.passes.iter().map(|pass| pass.micros).sum()
    }

    /// Microseconds of work: host and device work side by side, and the slower one says how long a frame takes.
    pub fn work_micros(&self) -> f64 {
        self.host_micros().max(self.device_micros())
    }

    /// The last microsecond that anything of it took, from its start.
    pub fn end_micros(&self) -> f64 {
        let passes = self.passes.iter();
        let last = passes.map(|pass| pass.start_micros + pass.micros);
        last.fold(self.micros, f64::max)
    }

    /// How well the device's passes are aligned, the worst of them, microseconds; none: there are none.
    pub fn alignment_micros(&self) -> Option<f64> {
        let errors = self.passes.iter().map(|pass| pass.error_micros);
        errors.fold(None, |worst, error| {
            Some(worst.map_or(error, |worst: f64| worst.max(error)))
        })
    }

    /// Of each span, what it took without those within it, microseconds.
    pub fn self_micros(&self) -> Vec<f64> {
        let mut own: Vec<f64> = self.spans.iter().map(|span| span.micros).collect();
        let mut open: Vec<usize> = Vec::new();
        for (i, span) in self.spans.iter().enumerate() {
            open.truncate(span.depth.into());
            if let Some(&outer) = open.last() {
                own[outer] = (own[outer] - span.micros).max(0.0);
            }
            open.push(i);
        }
        own
    }
}

/// Orders spans by their start, the longer first, and gives each its depth. One that begins within another but ends after it
/// is cut to it: two readings of one clock a moment apart.
pub fn nest(spans: &mut [Span]) {
    spans.sort_by(|a, b| {
        let start = a.start_micros.total_cmp(&b.start_micros);
        start.then(b.micros.total_cmp(&a.micros))
    });
    let mut ends: Vec<f64> = Vec::new();
    for span in spans {
        while ends.last().is_some_and(|&end| span.start_micros >= end) {
            ends.pop();
        }
        span.depth = ends.len() as u16;
        if let Some(&end) = ends.last() {
            span.micros = span.micros.min(end - span.start_micros);
        }
        ends.push(span.end_micros());
    }
}

/// The step of a pass on the host, if it is known when it began; `start` is the frame's.
pub fn step(pass: &PassTime, start: std::time::Instant) -> Option<Span> {
    let began = pass.start?;
    Some(Span {
        name: pass.name.into(),
        start_micros: micros_between(start, began),
        micros: pass.millis * 1e3,
        depth: 0,
    })
}

/// From one moment to another, negative if that was before.
pub fn micros_between(from: std::time::Instant, to: std::time::Instant) -> f64 {
    let ahead = to.saturating_duration_since(from).as_secs_f64();
    let behind = from.saturating_duration_since(to).as_secs_f64();
    (ahead - behind) * 1e6
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A span at depth 0.
    pub fn span(name: &str, start_micros: f64, micros: f64) -> Span {
        Span {
            name: name.into(),
            start_micros,
            micros,
            depth: 0,
        }
    }

    #[test]
    fn spans_nest_by_time() {
        let mut spans = [
            span("step", 12.0, 5.0),
            span("next", 20.0, 3.0),
            span("inner", 13.0, 9.0),
            span("system", 10.0, 10.0),
            span("instant", 20.0, 0.0),
        ];
        nest(&mut spans);
        let found: Vec<_> = spans
            .iter()
            .map(|s| (&*s.name, s.depth, s.micros))
            .collect();
        let expected = [
            ("system", 0, 10.0),
            ("step", 1, 5.0),
            ("inner", 2, 4.0),
            ("next", 0, 3.0),
            ("instant", 1, 0.0),
        ];
        assert_eq!(found, expected);
        let frame = Frame {
            spans: spans.to_vec(),
            ..Frame::default()
        };
        assert_eq!(frame.self_micros(), [5.0, 1.0, 4.0, 3.0, 0.0]);
    }

    #[test]
    fn work_is_the_slower_side_without_the_wait() {
        let pass = Pass {
            name: "whitted".into(),
            start_micros: 50.0,
            micros: 90.0,
            error_micros: 7.0,
        };
        let mut frame = Frame {
            micros: 100.0,
            wait_micros: 60.0,
            ..Frame::default()
        };
        assert_eq!((frame.work_micros(), frame.end_micros()), (40.0, 100.0));
        assert_eq!(frame.alignment_micros(), None);
        frame.passes.push(pass);
        assert_eq!((frame.work_micros(), frame.end_micros()), (90.0, 140.0));
        assert_eq!(frame.alignment_micros(), Some(7.0));
    }
}
