//! How many pixels are traced for a window: all of them if that stays fluid, else fewer.

use glam::UVec2;

/// Scales that are tried: few, so that the size does not flicker.
const STEPS: [f64; 6] = [0.25, 0.375, 0.5, 0.625, 0.75, 1.0];
/// Above this a picture takes too long to fly through.
const TOO_SLOW_MILLIS: f64 = 90.0;
/// At the next larger size a picture must stay below this.
const FLUID_MILLIS: f64 = 45.0;
/// Pictures to look at before a change, so that one slow frame changes nothing.
const PATIENCE: u32 = 8;

/// The scale of the traced picture.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    scale: f64,
    fixed: bool,
    millis: f64,
    seen: u32,
}

impl Resolution {
    /// A scale somebody chose, or one that starts at `guess` and follows the tracer's pace.
    pub fn new(chosen: Option<f64>, guess: f64) -> Self {
        Self {
            scale: chosen.unwrap_or(guess).clamp(0.05, 1.0),
            fixed: chosen.is_some(),
            millis: 0.0,
            seen: 0,
        }
    }

    /// Traced pixels for each of the window's, along an axis.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Size of the traced picture of a window.
    pub fn traced(&self, window: UVec2) -> UVec2 {
        (window.as_dvec2() * self.scale)
            .round()
            .as_uvec2()
            .max(UVec2::ONE)
    }

    /// Takes note of what the last picture took.
    pub fn observe(&mut self, millis: f64) {
        if self.fixed || millis <= 0.0 {
            return;
        }
        self.millis += millis;
        self.seen += 1;
        // A very slow picture is not waited for eight times.
        if self.seen < PATIENCE && self.millis < 4.0 * TOO_SLOW_MILLIS {
            return;
        }
        self.scale = next_scale(self.scale, self.millis / f64::from(self.seen));
        (self.millis, self.seen) = (0.0, 0);
    }
}

/// The scale to go on with when pictures at `scale` take `millis`; cost goes with the pixels.
fn next_scale(scale: f64, millis: f64) -> f64 {
    let cost_at = |other: f64| millis * (other / scale).powi(2);
    if millis > TOO_SLOW_MILLIS {
        let smaller = STEPS
            .iter()
            .rev()
            .copied()
            .find(|&step| step < scale && cost_at(step) <= TOO_SLOW_MILLIS * 0.75);
        return smaller.unwrap_or(STEPS[0].min(scale));
    }
    let larger = STEPS.iter().copied().find(|&step| step > scale);
    larger
        .filter(|&step| cost_at(step) < FLUID_MILLIS)
        .unwrap_or(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scales over time of a tracer whose full picture takes `full` milliseconds.
    fn settle(full: f64, start: f64) -> Vec<f64> {
        let mut resolution = Resolution::new(None, start);
        (0..400)
            .map(|_| {
                resolution.observe(full * resolution.scale().powi(2));
                resolution.scale()
            })
            .collect()
    }

    #[test]
    fn a_fast_tracer_gets_every_pixel() {
        assert_eq!(settle(10.0, 0.5).last(), Some(&1.0));
    }

    #[test]
    fn a_slow_tracer_stays_fluid_and_the_size_comes_to_rest() {
        for full in [100.0, 150.0, 300.0, 600.0, 1000.0, 1400.0] {
            let scales = settle(full, 1.0);
            let last = *scales.last().unwrap();
            assert!(
                full * last * last <= TOO_SLOW_MILLIS,
                "{full} ms: scale {last}"
            );
            assert!(
                scales[200..].iter().all(|s| *s == last),
                "{full} ms: the size flickers"
            );
        }
    }

    #[test]
    fn a_chosen_scale_is_kept() {
        let mut resolution = Resolution::new(Some(0.8), 0.5);
        for _ in 0..50 {
            resolution.observe(5000.0);
        }
        assert_eq!(
            resolution.traced(UVec2::new(1000, 501)),
            UVec2::new(800, 401)
        );
        assert_eq!(resolution.traced(UVec2::new(1, 1)), UVec2::ONE);
    }
}
