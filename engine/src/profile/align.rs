//! Where a device's clock stands against the host's, and how well that is known.
//!
//! No clock is shared, but every pass says something: it began no earlier than it was submitted and was over no later than
//! its timestamps were seen. Each bounds the offset between the clocks from one side; together, over the last passes, they
//! leave an interval. A device that was idle begins at once, so the truth is near the lower end, where passes are put; the
//! interval's length is the error. (The idea of Cristian 1989, "Probabilistic clock synchronization".)

use std::collections::VecDeque;

/// Passes that bound the offset: few enough that two clocks part by less than the error meanwhile.
const WINDOW: usize = 128;

/// Bounds of host's time less device's time, microseconds.
#[derive(Clone, Debug, Default)]
pub struct ClockFit {
    bounds: VecDeque<[f64; 2]>,
}

/// How to take the device's time to the host's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// To add to the device's time, at the least.
    pub micros: f64,
    /// How much more it may be.
    pub error_micros: f64,
}

impl ClockFit {
    /// Takes note of a pass: begin and end on the device's clock; when it was submitted and when it was seen to be over on the
    /// host's.
    pub fn note(&mut self, device: [f64; 2], host: [f64; 2]) {
        let bound = [host[0] - device[0], host[1] - device[1]];
        if bound.iter().any(|bound| !bound.is_finite()) {
            return;
        }
        if self.bounds.len() == WINDOW {
            self.bounds.pop_front();
        }
        self.bounds.push_back(bound);
        // Clocks that have parted since the oldest were noted, or that began anew.
        while self
            .offset()
            .is_some_and(|offset| offset.error_micros < 0.0)
        {
            self.bounds.pop_front();
        }
    }

    /// The offset as of the last pass noted; none before the first.
    pub fn offset(&self) -> Option<Offset> {
        let least = self.bounds.iter().map(|bound| bound[0]).reduce(f64::max)?;
        let most = self.bounds.iter().map(|bound| bound[1]).reduce(f64::min)?;
        Some(Offset {
            micros: least,
            error_micros: most - least,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_offset_is_within_what_is_said_of_it() {
        let truth = -123_456.0;
        let mut fit = ClockFit::default();
        assert_eq!(fit.offset(), None);
        let mut random = 1_u64;
        let mut next = |most: f64| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            most * (random >> 40) as f64 / (1 << 24) as f64
        };
        let mut last = f64::INFINITY;
        for pass in 0..100 {
            let begin = 10_000.0 * f64::from(pass);
            let end = begin + next(3000.0);
            let host = [begin + truth - next(500.0), end + truth + next(9000.0)];
            fit.note([begin, end], host);
            let offset = fit.offset().expect("passes were noted");
            assert!(offset.micros <= truth, "{offset:?}");
            assert!(offset.micros + offset.error_micros >= truth, "{offset:?}");
            assert!(
                offset.error_micros <= last,
                "it is known no worse than before"
            );
            last = offset.error_micros;
        }
        assert!(last < 500.0, "{last}");
    }

    #[test]
    fn a_clock_that_begins_anew_is_followed() {
        let mut fit = ClockFit::default();
        for _ in 0..50 {
            fit.note([100.0, 200.0], [1100.0, 1300.0]);
        }
        fit.note([0.0, 10.0], [9000.0, 9050.0]);
        let expected = Offset {
            micros: 9000.0,
            error_micros: 40.0,
        };
        assert_eq!(fit.offset(), Some(expected));
        fit.note([f64::NAN, 10.0], [0.0, 0.0]);
        assert_eq!(fit.offset(), Some(expected));
    }
}
