//! How far a picture has come: whether one is due, whether the one there is still refines, or whether all rests.
//!
//! Where nothing changed, each frame adds the next samples of the sequence (`TraceSettings::refine_by`) to every pixel that has
//! fewer than `TraceSettings::refine_to`, one after the other, as a running mean; with the last one the picture is that of so many samples from the
//! start, but for the rounding of sums. Anything that changes starts over. Both f32 tracers ask here what to do.

use crate::frame::wire::{SAMPLES_CAPACITY, ViewRow};
use crate::frame::{Skip, TraceSettings};

/// What a frame has to trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// The picture shows the frame as well as it is to.
    Nothing,
    /// A picture from the start.
    Picture,
    /// The next samples of each pixel that has fewer than `limit`.
    Refinement {
        /// Samples that no pixel goes beyond.
        limit: u32,
        /// How many, one after the other.
        by: u32,
    },
}

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    has_changed: bool,
    /// Samples that every pixel has.
    taken: u32,
    limit: u32,
    /// Samples that a frame adds.
    by: u32,
    /// What is there is traced again where nothing is due.
    never_rests: bool,
}

impl Progress {
    /// Takes note of a frame, and of whether it shows something else than the last.
    pub fn note(&mut self, has_changed: bool, settings: &TraceSettings) {
        self.has_changed |= has_changed;
        self.limit = settings.refine_to.min(SAMPLES_CAPACITY);
        self.by = settings.refine_by.max(1);
        self.never_rests = !settings.skips.has(Skip::Still);
    }

    /// What is to be traced.
    pub fn due(&self) -> Due {
        if self.has_changed {
            Due::Picture
        } else if (1..self.limit).contains(&self.taken) {
            Due::Refinement {
                limit: self.limit,
                by: self.by.min(self.limit - self.taken),
            }
        } else {
            Due::Nothing
        }
    }

    /// What a frame traces, one after the other; nothing: it rests. One that never does traces again all that the picture has,
    /// so that it is what it was.
    pub fn steps(&self, view: &ViewRow) -> impl Iterator<Item = Due> + use<> {
        let due = self.due();
        let again = self.never_rests && due == Due::Nothing && self.taken > 0;
        let by = self.taken.saturating_sub(first_samples(view));
        let further = Due::Refinement {
            limit: self.taken,
            by,
        };
        let steps = [
            if again { Due::Picture } else { due },
            if again && by > 0 {
                further
            } else {
                Due::Nothing
            },
        ];
        steps.into_iter().filter(|step| *step != Due::Nothing)
    }

    /// Takes note that it was.
    pub fn done(&mut self, due: Due, view: &ViewRow) {
        match due {
            Due::Nothing => {}
            Due::Picture => {
                self.taken = first_samples(view);
                self.has_changed = false;
            }
            Due::Refinement { by, .. } => self.taken += by,
        }
    }

    /// Takes note that the picture is lost: the next one is traced from the start, whether anything changed or not.
    pub fn lose(&mut self) {
        self.has_changed = true;
        self.taken = 0;
    }

    /// Samples that every pixel of the picture has.
    pub fn samples(&self) -> u32 {
        self.taken
    }
}

/// Samples that every pixel of a new picture takes.
pub fn first_samples(view: &ViewRow) -> u32 {
    if is_adaptive(view) { 1 } else { view.samples }
}

/// Whether only some pixels take all samples.
pub fn is_adaptive(view: &ViewRow) -> bool {
    view.edge_contrast > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_refines_to_its_limit_rests_and_starts_over() {
        let view = ViewRow {
            samples: 2,
            ..Default::default()
        };
        let settings = TraceSettings {
            samples: 2,
            refine_to: 4,
            ..Default::default()
        };
        let mut progress = Progress::default();
        assert_eq!(progress.due(), Due::Nothing);
        for _ in 0..2 {
            let mut seen = Vec::new();
            for frame in 0..5 {
                progress.note(frame == 0, &settings);
                let due = progress.due();
                progress.done(due, &view);
                seen.push((due, progress.samples()));
            }
            let refined = |samples| (Due::Refinement { limit: 4, by: 1 }, samples);
            let expected = [
                (Due::Picture, 2),
                refined(3),
                refined(4),
                (Due::Nothing, 4),
                (Due::Nothing, 4),
            ];
            assert_eq!(seen, expected);
        }
    }

    #[test]
    fn a_picture_that_is_lost_is_due_from_the_start() {
        let view = ViewRow {
            samples: 2,
            ..Default::default()
        };
        for refine_to in [0, 4] {
            let settings = TraceSettings {
                samples: 2,
                refine_to,
                ..Default::default()
            };
            let mut progress = Progress::default();
            progress.note(true, &settings);
            progress.done(Due::Picture, &view);
            progress.note(false, &settings);
            assert_ne!(progress.due(), Due::Picture);
            progress.lose();
            progress.note(false, &settings);
            assert_eq!((progress.due(), progress.samples()), (Due::Picture, 0));
        }
    }
}
