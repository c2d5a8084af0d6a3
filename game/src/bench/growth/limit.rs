//! The time that a run may take, shared out among its curves, and what was left out for want of it.

use std::time::{Duration, Instant};

use super::{FRAMES, PATIENCE, Quantity};
use crate::output::note;

/// Of a whole run. What is begun ends a little later.
const WHOLE: Duration = Duration::from_secs(160);

/// See the module.
pub struct Limit {
    /// When the run is to be over.
    over: Instant,
    /// What its curves are to be given, in all, from now on.
    shares: u32,
    /// When this curve is to be over.
    end: Instant,
    /// The curve's last point.
    last: Option<Last>,
    /// Sentences.
    pub left_out: Vec<String>,
}

struct Last {
    count: usize,
    before: Duration,
    frame: Duration,
}

/// How much of the time a curve is given; triangles take the longest to build.
fn share(quantity: Quantity) -> u32 {
    match quantity {
        Quantity::Triangles => 3,
        Quantity::Instances | Quantity::Lights | Quantity::Depth => 2,
        Quantity::Pixels => 1,
    }
}

impl Limit {
    /// Of a run on so many backends that begins now.
    pub fn new(backends: usize) -> Self {
        let now = Instant::now();
        let each: u32 = Quantity::ALL.into_iter().map(share).sum();
        Self {
            over: now + WHOLE,
            shares: each * backends as u32,
            end: now,
            last: None,
            left_out: Vec::new(),
        }
    }

    /// A curve begins: what others did not need is shared out again.
    pub fn start(&mut self, quantity: Quantity) {
        let now = Instant::now();
        let share = share(quantity);
        self.end = now + self.over.saturating_duration_since(now) * share / self.shares.max(1);
        self.shares = self.shares.saturating_sub(share);
        self.last = None;
    }

    /// When this curve is to be over.
    pub fn end(&self) -> Instant {
        self.end
    }

    /// Takes note of a point: what came before its frames were timed, and the milliseconds of one.
    pub fn note(&mut self, count: usize, before: Duration, frame: f64) {
        let frame = Duration::from_secs_f64(frame * 1e-3);
        self.last = Some(Last {
            count,
            before,
            frame,
        });
    }

    /// Whether a point of so many is not to be begun, since it would take too long if all grew with it; then it is told.
    pub fn is_too_long(&mut self, count: usize, name: &str) -> bool {
        let Some(last) = &self.last else {
            return false;
        };
        let expected = last.expected(count);
        let left = self.end.saturating_duration_since(Instant::now());
        if expected <= left {
            return false;
        }
        self.leave_out(format!(
            "{name} and more would take about {:.0} s, and {:.0} are left of what the curve is given",
            expected.as_secs_f64(),
            left.as_secs_f64()
        ));
        true
    }

    /// Something is left out, and why.
    pub fn leave_out(&mut self, why: String) {
        let sentence = format!("left out: {why}");
        note(&sentence);
        self.left_out.push(sentence);
    }
}

impl Last {
    fn expected(&self, count: usize) -> Duration {
        let growth = count as f64 / self.count as f64;
        let frames = self.frame.mul_f64(growth) * FRAMES.0 as u32;
        self.before.mul_f64(growth) + frames.max(PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_begun_where_it_will_fit() {
        let secs = Duration::from_secs;
        let mut limit = Limit::new(1);
        limit.start(Quantity::Triangles);
        assert!(limit.end() <= Instant::now() + WHOLE * 3 / 10);
        assert!(!limit.is_too_long(1000, "first"), "nothing is known");
        limit.note(1000, secs(1), 1.0);
        assert!(!limit.is_too_long(10_000, "second"), "10 s and patience");
        limit.note(10_000, secs(10), 1.0);
        assert!(limit.is_too_long(100_000, "third"), "100 s");
        limit.note(10_000, secs(1), 2000.0);
        assert!(limit.is_too_long(100_000, "third"), "3 frames of 20 s");
        assert_eq!(limit.left_out.len(), 2);
        assert!(limit.left_out[0].contains("third and more"));
        // The next curve has what is left.
        limit.start(Quantity::Pixels);
        assert!(!limit.is_too_long(100_000, "another"));
        assert!(limit.end() <= Instant::now() + WHOLE / 7);
    }
}
