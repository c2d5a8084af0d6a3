//! How many pixels are traced for a window: all of them if that stays fluid, else fewer.

use glam::UVec2;

use crate::trace::Tracer;

/// Scales that are tried: few, so that the size does not flicker.
const STEPS: [f64; 6] = [0.25, 0.375, 0.5, 0.625, 0.75, 1.0];
/// Above this a picture takes too long to fly through.
const TOO_SLOW_MILLIS: f64 = 90.0;
/// At the next larger size a picture must stay below this.
const FLUID_MILLIS: f64 = 45.0;
/// Frames to look at before a change, so that one slow one of many changes nothing.
const PATIENCE: u32 = 8;

/// What a picture from its start took, if the frame has measured one.
pub fn whole_picture_millis(tracer: &dyn Tracer) -> Option<f64> {
    let millis = || tracer.pass_times().iter().map(|pass| pass.millis).sum();
    tracer.has_timed_whole().then(millis)
}

/// The scale of the traced picture.
#[derive(Clone, Copy, Debug)]
pub struct Resolution {
    scale: f64,
    fixed: bool,
    /// Of the pictures seen, in all.
    millis: f64,
    seen: u32,
    /// Since the last decision.
    frames: u32,
}

impl Resolution {
    /// A scale somebody chose, or one that starts at `guess` and follows the tracer's pace.
    pub fn new(chosen: Option<f64>, guess: f64) -> Self {
        Self {
            scale: chosen.unwrap_or(guess).clamp(0.05, 1.0),
            fixed: chosen.is_some(),
            millis: 0.0,
            seen: 0,
            frames: 0,
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

    /// Takes note of a frame, and of what a picture took that was traced from its start: another scale costs that
    /// much again. A frame that refines a picture or rests says nothing of it.
    pub fn observe(&mut self, whole_picture_millis: Option<f64>) {
        if self.fixed {
            return;
        }
        if let Some(millis) = whole_picture_millis.filter(|millis| *millis > 0.0) {
            self.millis += millis;
            self.seen += 1;
        }
        self.frames += 1;
        // A very slow picture is not waited for eight times.
        let waits = self.frames < PATIENCE && self.millis < 4.0 * TOO_SLOW_MILLIS;
        if self.seen == 0 || waits {
            return;
        }
        self.scale = next_scale(self.scale, self.millis / f64::from(self.seen));
        (self.millis, self.seen, self.frames) = (0.0, 0, 0);
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
    use crate::frame::{FrameScene, TraceSettings};
    use crate::trace::cpu::CpuTracer;

    /// Scales over time of a tracer whose full picture takes `full` milliseconds.
    fn settle(full: f64, start: f64) -> Vec<f64> {
        let mut resolution = Resolution::new(None, start);
        (0..400)
            .map(|_| {
                resolution.observe(Some(full * resolution.scale().powi(2)));
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

    /// Frames of a still scene: after a picture from the start, refinement and rest cost next to nothing.
    #[test]
    fn frames_that_cost_nothing_do_not_change_the_size_again_and_again() {
        for full in [10.0, 100.0, 1000.0] {
            let mut resolution = Resolution::new(None, 0.5);
            let (mut restarts, mut traced) = (0, None);
            for _ in 0..400 {
                let scale = resolution.scale();
                let is_new = traced.replace(scale) != Some(scale);
                restarts += u32::from(is_new);
                resolution.observe(is_new.then_some(full * scale.powi(2)));
            }
            assert!(restarts <= 4, "{full} ms: {restarts} pictures");
            let scale = resolution.scale();
            assert!(
                full * scale * scale <= TOO_SLOW_MILLIS,
                "{full} ms: {scale}"
            );
        }
    }

    #[test]
    fn only_pictures_from_the_start_are_measured() {
        let scene = FrameScene::default();
        let settings = TraceSettings {
            size: UVec2::splat(8),
            refine_to: 4,
            ..Default::default()
        };
        let mut tracer = CpuTracer::new();
        let mut measured = [false; 8];
        for frame in &mut measured {
            tracer.refit(&scene).unwrap();
            tracer.upload(&scene, &settings).unwrap();
            tracer.render().unwrap();
            *frame = whole_picture_millis(&tracer).is_some();
        }
        assert_eq!(measured, [0, 1, 2, 3, 4, 5, 6, 7].map(|frame| frame == 0));
    }

    #[test]
    fn a_chosen_scale_is_kept() {
        let mut resolution = Resolution::new(Some(0.8), 0.5);
        for _ in 0..50 {
            resolution.observe(Some(5000.0));
        }
        assert_eq!(
            resolution.traced(UVec2::new(1000, 501)),
            UVec2::new(800, 401)
        );
        assert_eq!(resolution.traced(UVec2::new(1, 1)), UVec2::ONE);
    }
}
