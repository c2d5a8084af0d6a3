//! How many pixels are traced for a window: a share that was chosen, as many as a frame time allows, or all of them.
//!
//! A device that is slow by its kind (the processor, as itself or as software Vulkan) keeps a frame time unless told
//! otherwise; any other traces every pixel until it shows itself slow.

use glam::UVec2;

use super::budget::{Budget, Cost};
use super::work::Work;

/// The frame time that slow devices keep: slow enough for a picture, fast enough to fly.
pub const SLOW_TARGET_MILLIS: f64 = 50.0;
/// A frame above this is one of a slow device.
const SLOW_MILLIS: f64 = 2.0 * SLOW_TARGET_MILLIS;
/// As many such pictures in a row show that it is.
const SLOW_PICTURES: u32 = 4;
/// Where a slow device starts, and the coarsest that a picture becomes unless a frame time was asked for.
const COARSE: f64 = 0.25;
/// The coarsest that one becomes to keep a frame time that was asked for.
const COARSEST: f64 = 0.125;

/// The size of the traced picture, and what it refines by.
#[derive(Clone, Debug)]
pub struct Resolution {
    rule: Rule,
}

#[derive(Clone, Debug)]
enum Rule {
    /// Somebody chose the scale.
    Fixed(f64),
    /// A frame time is kept.
    Kept(Budget),
    /// Every pixel, until too many pictures in a row are slow: so many were.
    Watching(u32),
}

impl Resolution {
    /// A scale or a frame time that somebody chose; without either, what suits the device.
    pub fn new(scale: Option<f64>, target_millis: Option<f64>, is_slow: bool) -> Self {
        let start = if is_slow { COARSE } else { 1.0 };
        let rule = match (scale, target_millis) {
            (Some(scale), _) => Rule::Fixed(scale.clamp(0.05, 1.0)),
            (None, Some(target)) => Rule::Kept(Budget::new(target, start, COARSEST)),
            (None, None) if is_slow => Rule::Kept(slow_budget(start)),
            (None, None) => Rule::Watching(0),
        };
        Self { rule }
    }

    /// Traced pixels for each of the window's, along an axis.
    pub fn scale(&self) -> f64 {
        match &self.rule {
            Rule::Fixed(scale) => *scale,
            Rule::Kept(budget) => budget.scale(),
            Rule::Watching(_) => 1.0,
        }
    }

    /// The frame time that is kept, if one is.
    pub fn target_millis(&self) -> Option<f64> {
        match &self.rule {
            Rule::Kept(budget) => Some(budget.target()),
            Rule::Fixed(_) | Rule::Watching(_) => None,
        }
    }

    /// Size of the traced picture of a window.
    pub fn traced(&self, window: UVec2) -> UVec2 {
        (window.as_dvec2() * self.scale())
            .round()
            .as_uvec2()
            .max(UVec2::ONE)
    }

    /// Samples that a frame adds while nothing changes, where a new picture takes `samples`.
    pub fn samples_when_still(&self, window: UVec2, samples: u32) -> u32 {
        match &self.rule {
            Rule::Kept(budget) => budget.samples_when_still(window, samples),
            Rule::Fixed(_) | Rule::Watching(_) => 1,
        }
    }

    /// Takes note of a frame. One that refines a picture, or rests, says nothing of what another size would cost.
    pub fn observe(&mut self, window: UVec2, work: &Work) {
        let Some(picture) = work.picture else {
            return;
        };
        let pixels = picture.size.as_dvec2().element_product();
        match &mut self.rule {
            Rule::Fixed(_) => {}
            Rule::Kept(budget) => budget.observe(
                window,
                Cost {
                    of_a_pixel: picture.rays / pixels.max(1.0),
                    rest: work.rest,
                },
            ),
            Rule::Watching(slow) => {
                let is_slow = picture.rays + work.rest > SLOW_MILLIS;
                *slow = if is_slow { *slow + 1 } else { 0 };
                if *slow >= SLOW_PICTURES {
                    self.rule = Rule::Kept(slow_budget(1.0));
                }
            }
        }
    }
}

fn slow_budget(start: f64) -> Budget {
    Budget::new(SLOW_TARGET_MILLIS, start, COARSE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::PictureTime;

    const WINDOW: UVec2 = UVec2::new(1000, 501);

    /// A frame whose picture took so many milliseconds.
    fn work(resolution: &Resolution, full: f64) -> Work {
        let size = resolution.traced(WINDOW);
        let share = size.as_dvec2().element_product() / WINDOW.as_dvec2().element_product();
        Work {
            frame: full * share,
            rest: 0.0,
            picture: Some(PictureTime {
                size,
                rays: full * share,
            }),
        }
    }

    fn settle(resolution: &mut Resolution, full: f64) -> f64 {
        for _ in 0..100 {
            let work = work(resolution, full);
            resolution.observe(WINDOW, &work);
        }
        work(resolution, full).frame
    }

    #[test]
    fn a_fast_device_traces_every_pixel_until_it_shows_itself_slow() {
        let mut resolution = Resolution::new(None, None, false);
        settle(&mut resolution, 90.0);
        assert_eq!(
            (resolution.scale(), resolution.target_millis()),
            (1.0, None)
        );
        let frame = settle(&mut resolution, 400.0);
        assert!((30.0..=55.0).contains(&frame), "{frame} ms");
        assert_eq!(resolution.target_millis(), Some(SLOW_TARGET_MILLIS));
        settle(&mut resolution, 10.0);
        assert_eq!(resolution.scale(), 1.0);
    }

    #[test]
    fn a_slow_device_keeps_a_frame_time_and_any_device_one_that_was_asked_for() {
        let mut slow = Resolution::new(None, None, true);
        assert_eq!(slow.scale(), COARSE);
        let frame = settle(&mut slow, 300.0);
        assert!((30.0..=55.0).contains(&frame), "{frame} ms");
        settle(&mut slow, 9000.0);
        assert_eq!(slow.scale(), COARSE);
        for is_slow in [false, true] {
            let mut asked = Resolution::new(None, Some(8.0), is_slow);
            let frame = settle(&mut asked, 60.0);
            assert!((5.0..=8.8).contains(&frame), "{frame} ms");
        }
    }

    #[test]
    fn a_chosen_scale_is_kept() {
        let mut resolution = Resolution::new(Some(0.8), None, true);
        settle(&mut resolution, 5000.0);
        assert_eq!(resolution.traced(WINDOW), UVec2::new(800, 401));
        assert_eq!(resolution.traced(UVec2::ONE), UVec2::ONE);
        assert_eq!(resolution.samples_when_still(WINDOW, 1), 1);
    }
}
