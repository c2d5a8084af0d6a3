//! What tries came to: how many, how many failed, and how far off the others were.

use crate::bench::report::{Better, FAILURES, Row, Trial};

/// Steps of an ULP that errors below [`FINE`] are sorted into.
const STEPS: f64 = 20.0;
/// ULPs up to which errors are sorted evenly; beyond, eight bins for each doubling.
const FINE: f64 = 16.0;
/// Least share of the tries that must count.
const LEAST_SHARE: f64 = 0.25;
/// Bins of errors.
const BINS: usize = 800;

/// What one try came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The try was none: it does not count.
    Void,
    /// As it should be.
    Right,
    /// As it should not be.
    Wrong,
    /// Right but for an error in units in the last place.
    Off(f64),
}

impl Verdict {
    /// Right or wrong.
    pub fn of(is_right: bool) -> Self {
        if is_right { Self::Right } else { Self::Wrong }
    }
}

/// Many of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Tries that count.
    pub tried: u64,
    /// Those that do not: what was to be tried did not come about.
    pub void: u64,
    /// Those that went wrong.
    pub failed: u64,
    /// How long they took; 0: not measured.
    pub secs: f64,
    /// The largest error in ULPs.
    pub worst: Option<f64>,
    /// Errors by size; empty: none were measured.
    bins: Vec<u64>,
}

impl Tally {
    /// So many tries of which so many failed.
    pub fn counted(tried: u64, failed: u64) -> Self {
        Self {
            tried,
            failed,
            ..Self::default()
        }
    }

    /// Takes a try in.
    pub fn take(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Void => {
                self.void += 1;
                return;
            }
            Verdict::Right => {}
            Verdict::Wrong => self.failed += 1,
            Verdict::Off(ulps) => {
                if self.bins.is_empty() {
                    self.bins = vec![0; BINS];
                }
                self.bins[bin(ulps)] += 1;
                self.worst = Some(self.worst.unwrap_or(0.0).max(ulps));
            }
        }
        self.tried += 1;
    }

    /// Both together; times add up.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        self.tried += other.tried;
        self.void += other.void;
        self.failed += other.failed;
        self.secs += other.secs;
        self.worst = match (self.worst, other.worst) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        if self.bins.is_empty() {
            self.bins = other.bins;
        } else {
            let sums = self.bins.iter_mut().zip(other.bins);
            sums.for_each(|(sum, more)| *sum += more);
        }
        self
    }

    /// Takes another in, if there is one.
    pub fn extend(&mut self, other: Option<Self>) {
        if let Some(other) = other {
            *self = std::mem::take(self).with(other);
        }
    }

    /// The error that a share of the measured ones stays below, in ULPs, to a bin; beyond all where none was measured.
    pub fn percentile(&self, share: f64) -> f64 {
        let all: u64 = self.bins.iter().sum();
        if all == 0 {
            return f64::MAX;
        }
        let most = (all as f64 * share).ceil() as u64;
        let mut seen = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= most.max(1) {
                return end_of(bin).min(self.worst.unwrap_or(f64::MAX));
            }
        }
        f64::MAX
    }

    /// Whether enough of the tries count to say anything.
    pub fn is_telling(&self) -> bool {
        self.tried > 0 && self.tried as f64 >= LEAST_SHARE * (self.tried + self.void) as f64
    }

    /// A row of what failed.
    pub fn row(&self, name: String) -> Row {
        Row {
            trial: Some(self.trial()),
            ..Row::single(name, FAILURES, Better::Lower, self.failed as f64)
        }
    }

    /// A row of another number that came of these tries.
    pub fn row_of(&self, name: String, unit: &'static str, value: f64) -> Row {
        Row {
            trial: Some(self.trial()),
            ..Row::single(name, unit, Better::Lower, value)
        }
    }

    fn trial(&self) -> Trial {
        Trial {
            tried: self.tried,
            known_ppm: None,
            worst_ulp: self.worst,
            per_sec: (self.secs > 0.0).then(|| self.tried as f64 / self.secs),
        }
    }
}

fn bin(ulps: f64) -> usize {
    let bin = if ulps < FINE {
        ulps * STEPS
    } else {
        FINE * STEPS + (ulps / FINE).log2() * 8.0
    };
    (bin as usize).min(BINS - 1)
}

fn end_of(bin: usize) -> f64 {
    let next = (bin + 1) as f64;
    let fine = FINE * STEPS;
    if next <= fine {
        next / STEPS
    } else {
        FINE * ((next - fine) / 8.0).exp2()
    }
}

/// How far `found` is from `exact`, in units in the last place that `exact` has in f32.
pub fn ulps(found: f64, exact: f64) -> f64 {
    let near = (exact.abs() as f32).max(f32::MIN_POSITIVE);
    let unit = f64::from(near.next_up()) - f64::from(near);
    (found - exact).abs() / unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_errors() {
        let mut low = Tally::default();
        let mut high = Tally::default();
        for i in 0..1000 {
            low.take(Verdict::Off(f64::from(i) * 1e-3));
            high.take(Verdict::Off(1000.0));
        }
        assert!((low.percentile(0.5) - 0.5).abs() < 0.06);
        let both = low.with(high);
        assert_eq!(
            (both.tried, both.failed, both.worst),
            (2000, 0, Some(1000.0))
        );
        assert!((both.percentile(0.25) - 0.5).abs() < 0.06);
        assert_eq!(both.percentile(0.9), 1000.0);
    }

    #[test]
    fn tries_that_do_not_count_and_errors_that_were_not_measured_say_nothing() {
        let mut tally = Tally::default();
        assert!(!tally.is_telling());
        assert_eq!(tally.percentile(0.99), f64::MAX);
        tally.take(Verdict::Right);
        assert!(tally.is_telling());
        assert_eq!(tally.percentile(0.99), f64::MAX);
        for _ in 0..9 {
            tally.take(Verdict::Void);
        }
        assert!(!tally.is_telling());
    }

    #[test]
    fn an_ulp_is_that_of_the_exact_number() {
        assert_eq!(ulps(1.0 + f64::from(f32::EPSILON), 1.0), 1.0);
        assert_eq!(ulps(4.0, 4.0), 0.0);
    }
}
