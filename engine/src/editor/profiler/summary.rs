//! Figures over all frames held, taken anew a few times a second: sorting hundreds of frames in each would cost more than
//! what it tells.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::profile::{Blame, Frames, Profile, blame, costs, percentile_of_sorted};

/// How long figures stand.
const FRESH: Duration = Duration::from_millis(400);

/// What a name takes in the frames held, microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Usual {
    /// In the middle one.
    pub median: f64,
    /// In all but one of twenty.
    pub p95: f64,
    /// In the slowest.
    pub most: f64,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Summary {
    taken: Option<Instant>,
    /// Number of the newest frame and of frames held when it was taken.
    of: (u64, usize),
    /// Of every name, on the host or on the device.
    usual: HashMap<(Arc<str>, bool), Usual>,
    /// Of the slowest frames, in their order: who made them slow.
    blames: Vec<(u64, Option<Blame>)>,
    /// Work of a frame in milliseconds: median, 95 %, 99 %.
    work: [f64; 3],
    fps: f64,
    one_percent_low_fps: f64,
}

impl Summary {
    /// Brings the figures up to date if they are old.
    pub fn refresh(&mut self, frames: &Frames, profile: &Profile) {
        let of = (frames.latest().map_or(0, |f| f.id), frames.iter().len());
        let worst = frames.worst().iter().map(|frame| frame.id);
        let same_worst = worst.eq(self.blames.iter().map(|(id, _)| *id));
        let is_fresh = self.taken.is_some_and(|taken| taken.elapsed() < FRESH);
        if same_worst && (is_fresh || self.of == of) {
            return;
        }
        (self.taken, self.of) = (Some(Instant::now()), of);
        let mut taken: HashMap<(Arc<str>, bool), Vec<f64>> = HashMap::new();
        for frame in frames.iter() {
            for (name, micros) in costs(frame) {
                taken.entry(name).or_default().push(micros);
            }
        }
        self.usual = taken
            .into_iter()
            .map(|(name, mut micros)| {
                micros.resize(of.1, 0.0);
                micros.sort_unstable_by(f64::total_cmp);
                let [median, p95, most] =
                    [0.5, 0.95, 1.0].map(|q| percentile_of_sorted(&micros, q));
                (name, Usual { median, p95, most })
            })
            .collect();
        if !same_worst {
            let worst = frames.worst().iter();
            self.blames = worst.map(|f| (f.id, blame(f, frames.iter()))).collect();
        }
        let work = frames.work();
        self.work = [0.5, 0.95, 0.99].map(|q| work.percentile(q));
        self.fps = profile.history.mean_fps();
        self.one_percent_low_fps = profile.history.one_percent_low_fps();
    }

    /// What a name usually takes.
    pub fn usual(&self, name: &Arc<str>, on_device: bool) -> Usual {
        let key = (Arc::clone(name), on_device);
        self.usual.get(&key).copied().unwrap_or_default()
    }

    /// Who made one of the slowest frames slow.
    pub fn blame(&self, id: u64) -> Option<&Blame> {
        let (_, blame) = self.blames.iter().find(|(of, _)| *of == id)?;
        blame.as_ref()
    }

    /// Milliseconds of work that half of the frames, and all but one of twenty, stay below.
    pub fn lines(&self) -> [f64; 2] {
        [self.work[0], self.work[1]]
    }

    /// The headline.
    pub fn words(&self) -> String {
        let [median, p95, p99] = self.work;
        format!(
            "{:.0} FPS   1 % low {:.0}   work {median:.2} ms   95 % {p95:.2}   99 % {p99:.2}",
            self.fps, self.one_percent_low_fps
        )
    }
}
