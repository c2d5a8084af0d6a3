//! Time that comes round again: whole turns of a period, and what follows the end of a play.
//!
//! All are pure functions of the scene's seconds. f64 remainders are exact, so nothing adds up: after a
//! million periods a thing is where it was, bit for bit where the period is exact in f64.

use bevy_reflect::prelude::*;
use serde::{Deserialize, Serialize};

/// What follows the last key.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub enum Loop {
    /// The last value stays.
    #[default]
    Once,
    /// The first key again.
    Repeat,
    /// Back to the first key, then forth again.
    PingPong,
}

impl Loop {
    /// The time between `start` and `end` that `secs` stands for.
    pub fn wrap(self, secs: f64, start: f64, end: f64) -> f64 {
        let length = end - start;
        if !(length > 0.0) {
            return start;
        }
        match self {
            Self::Once => secs.clamp(start, end),
            Self::Repeat => start + (secs - start).rem_euclid(length),
            Self::PingPong => {
                let there_and_back = (secs - start).rem_euclid(2.0 * length);
                start + there_and_back.min(2.0 * length - there_and_back)
            }
        }
    }
}

/// Share of a period that has passed, in [0, 1); backwards, in (-1, 0], for a negative one. A period of zero,
/// or one that is not finite, stands still.
pub fn turn(secs: f64, period: f64) -> f64 {
    // Adding 0 makes -0 the same as 0.
    let turn = (secs.rem_euclid(period) + 0.0) / period;
    if turn.is_finite() { turn } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_periods_change_no_bit() {
        for period in [0.25, 3.0, 7.5, -2.0] {
            for secs in [0.0, 0.125, 1.75, 12.5] {
                let first = turn(secs, period);
                for count in [1.0, 1e3, 1e9] {
                    let later = turn(secs + count * period, period);
                    assert_eq!(first.to_bits(), later.to_bits(), "{secs} of {period}");
                }
            }
        }
    }

    #[test]
    fn no_period_stands_still() {
        for period in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(turn(5.0, period), 0.0, "{period}");
        }
        assert_eq!(turn(0.75, -1.0), -0.75);
    }

    #[test]
    fn plays_end_start_anew_or_come_back() {
        assert_eq!(Loop::Once.wrap(9.0, 1.0, 3.0), 3.0);
        assert_eq!(Loop::Repeat.wrap(3.5, 1.0, 3.0), 1.5);
        assert_eq!(Loop::PingPong.wrap(3.5, 1.0, 3.0), 2.5);
        assert_eq!(Loop::PingPong.wrap(5.5, 1.0, 3.0), 1.5);
        assert_eq!(Loop::Repeat.wrap(3.5, 1.0, 1.0), 1.0);
    }
}
