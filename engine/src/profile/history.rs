//! Frame times of the recent past and what is usually asked of them.

/// Frames a [`FrameHistory`] remembers: ten seconds at 60 frames a second.
pub const HISTORY_FRAMES: usize = 600;

/// A ring of frame times in milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameHistory {
    millis: Vec<f64>,
    /// Where the next one goes once the ring is full.
    next: usize,
}

impl FrameHistory {
    /// Adds a frame; the oldest one is forgotten once [`HISTORY_FRAMES`] are held.
    pub fn push(&mut self, millis: f64) {
        if self.millis.len() < HISTORY_FRAMES {
            self.millis.push(millis);
        } else {
            self.millis[self.next] = millis;
            self.next = (self.next + 1) % HISTORY_FRAMES;
        }
    }

    /// Frames held.
    pub fn len(&self) -> usize {
        self.millis.len()
    }

    /// True before the second frame.
    pub fn is_empty(&self) -> bool {
        self.millis.is_empty()
    }

    /// Milliseconds of the frames held, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        let (newer, older) = self.millis.split_at(self.next);
        older.iter().chain(newer).copied()
    }

    /// The frame time that a share `q` (0 to 1) of frames does not exceed, interpolated between ranks; 0 if empty.
    pub fn percentile(&self, q: f64) -> f64 {
        let mut sorted = self.millis.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        percentile_of_sorted(&sorted, q)
    }

    /// "1 % low": frames a second of the slowest hundredth of frames (at least one frame); 0 if empty.
    pub fn one_percent_low_fps(&self) -> f64 {
        let mut sorted = self.millis.clone();
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let slowest = &sorted[..sorted.len().div_ceil(100)];
        let total: f64 = slowest.iter().sum();
        if total > 0.0 {
            slowest.len() as f64 * 1e3 / total
        } else {
            0.0
        }
    }

    /// Mean frames a second; 0 if empty.
    pub fn mean_fps(&self) -> f64 {
        let total: f64 = self.millis.iter().sum();
        if total > 0.0 {
            self.millis.len() as f64 * 1e3 / total
        } else {
            0.0
        }
    }
}

/// The value at share `q` of ascending values, linear between ranks (numpy's default); 0 if empty.
pub fn percentile_of_sorted(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return 0.0;
    };
    let rank = q.clamp(0.0, 1.0) * last as f64;
    let below = rank.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (sorted[above] - sorted[below]) * (rank - below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_known_values() {
        let mut history = FrameHistory::default();
        for millis in (0..=100).rev() {
            history.push(f64::from(millis));
        }
        assert_eq!(history.percentile(0.5), 50.0);
        assert_eq!(history.percentile(0.95), 95.0);
        assert_eq!(history.percentile(1.0), 100.0);
        // 101 frames: the slowest hundredth, rounded up, is two frames of 100 and 99 ms.
        assert!((history.one_percent_low_fps() - 2e3 / 199.0).abs() < 1e-12);
    }

    #[test]
    fn the_ring_forgets_the_oldest() {
        let mut history = FrameHistory::default();
        for millis in 0..HISTORY_FRAMES + 3 {
            history.push(millis as f64);
        }
        assert_eq!(history.len(), HISTORY_FRAMES);
        let held: Vec<f64> = history.iter().collect();
        assert_eq!((held[0], held[1]), (3.0, 4.0));
        assert_eq!(*held.last().unwrap(), (HISTORY_FRAMES + 2) as f64);
    }

    #[test]
    fn an_empty_history_answers_zero() {
        let history = FrameHistory::default();
        assert_eq!(history.percentile(0.5), 0.0);
        assert_eq!(history.one_percent_low_fps(), 0.0);
        assert_eq!(history.mean_fps(), 0.0);
    }
}
