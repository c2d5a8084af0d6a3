//! How many samples a dispatch takes: as many as samples have taken time, so that a slow device is not taken for one that
//! hangs.
//!
//! Systems reset a GPU whose work does not end: Windows after two seconds (TdrDelay), Linux drivers after a few. A dispatch
//! is made for a fortieth of that by what a sample took on the mean; where those of a band are dearer than others (glass
//! below an empty sky), there is room for that. [`super::canvas`] cuts pictures into bands of so many samples.

/// What a dispatch is to take, in milliseconds.
const MILLIS: f64 = 50.0;
/// Most samples of a dispatch: they fill any GPU many times over.
const MOST: u32 = 1 << 20;
/// Fewest: a workgroup's rows across a narrow picture.
const FEWEST: u32 = 1 << 10;
/// Before anything is known. At a million samples a second, which is slow for a GPU, they take an eighth of a second.
const AT_FIRST: u32 = 1 << 17;

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    samples: u32,
    /// How often what was known has been forgotten.
    epoch: u64,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            samples: AT_FIRST,
            epoch: 0,
        }
    }
}

impl Pace {
    /// Samples of a dispatch.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Whether dispatches are smaller than those of a device that is not known yet.
    pub fn is_slow(&self) -> bool {
        self.samples < AT_FIRST
    }

    /// What pictures of now are to be noted with.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Takes note of what samples took that were traced in an epoch. What has come back late, of another kernel, says nothing.
    pub fn note(&mut self, epoch: u64, samples: u64, millis: f64) {
        if epoch == self.epoch && samples > 0 && millis > 0.0 {
            let fitting = samples as f64 / millis * MILLIS;
            self.samples = fitting.clamp(FEWEST.into(), MOST.into()) as u32;
        }
    }

    /// Takes note that samples will take something else: another kernel traces them.
    pub fn forget(&mut self) {
        self.samples = self.samples.min(AT_FIRST);
        self.epoch += 1;
    }

    /// For another device, in place of one that was lost: perhaps because a dispatch took too long.
    pub fn after_loss(self) -> Self {
        Self {
            samples: (self.samples / 4).max(FEWEST),
            epoch: self.epoch + 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dispatch_follows_what_samples_took() {
        let mut pace = Pace::default();
        assert_eq!(pace.samples(), AT_FIRST);
        // A million samples in ten seconds.
        pace.note(0, 1_000_000, 10_000.0);
        assert_eq!(pace.samples(), 5_000);
        pace.note(0, 2_000_000, 2.0);
        assert_eq!(pace.samples(), MOST);
        pace.forget();
        assert_eq!(pace.samples(), AT_FIRST);
        // A report of the kernel before.
        pace.note(0, 2_000_000, 2.0);
        assert_eq!(pace.samples(), AT_FIRST);
        pace.note(pace.epoch(), 100, 10_000.0);
        assert_eq!(pace.samples(), FEWEST);
        pace.forget();
        pace.note(pace.epoch(), 0, 5.0);
        pace.note(pace.epoch(), 5, 0.0);
        assert_eq!(pace.samples(), FEWEST);
        assert_eq!(pace.after_loss().samples(), FEWEST);
        assert_eq!(Pace::default().after_loss().samples(), AT_FIRST / 4);
    }
}
