//! What is wrong with pictures that were made all the same: said once, for all of them together.

use orrery_engine::trace::{Counters, Picture};

use crate::output::note;

/// Sums over pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Defects {
    /// Entries into a medium that the list of media had no room for.
    media_overflows: u64,
    /// Rays ended for crossing too many surfaces of equal index.
    straight_overflows: u64,
    /// Pixels with an infinity or NaN in some channel.
    non_finite: u64,
}

impl Defects {
    /// Adds a picture's, with the counters of that very picture.
    pub fn add(&mut self, picture: &Picture, counters: &Counters) {
        self.media_overflows += counters.media_overflows;
        self.straight_overflows += counters.straight_overflows;
        let broken = picture.pixels.iter().filter(|pixel| !pixel.is_finite());
        self.non_finite += broken.count() as u64;
    }

    /// Says what there is, if anything.
    pub fn tell(&self) {
        for sentence in self.sentences() {
            note(format_args!("note: {sentence}"));
        }
    }

    fn sentences(&self) -> Vec<String> {
        let kinds = [
            (
                self.media_overflows,
                "times a ray was inside of more media than are kept track of: glass is not quite right there",
            ),
            (
                self.straight_overflows,
                "rays crossed too many surfaces of equal index and were ended: black there",
            ),
            (self.non_finite, "pixels are not finite numbers"),
        ];
        let there = kinds.into_iter().filter(|&(count, _)| count > 0);
        there
            .map(|(count, what)| format!("{count} {what}"))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{UVec2, Vec3};

    #[test]
    fn defects_of_all_pictures_add_up() {
        let mut picture = Picture::new(UVec2::new(4, 1));
        let mut defects = Defects::default();
        defects.add(&picture, &Counters::default());
        assert_eq!(defects.sentences(), [""; 0]);
        picture.pixels[1] = Vec3::new(0.0, f32::NAN, 0.0);
        let counters = Counters {
            media_overflows: 2,
            straight_overflows: 1,
            ..Counters::default()
        };
        defects.add(&picture, &counters);
        defects.add(&picture, &counters);
        let sentences = defects.sentences();
        let starts = ["4 times", "2 rays", "2 pixels"];
        assert_eq!(sentences.len(), starts.len());
        for (sentence, start) in sentences.iter().zip(starts) {
            assert!(sentence.starts_with(start), "{sentence}");
        }
    }
}
