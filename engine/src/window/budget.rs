//! A frame time that is kept by tracing fewer pixels, or more.
//!
//! The cost of rays goes with the pixels, so what pictures took foretells what they will take at another scale. What is
//! measured is noisy, and a size that swings is worse than a frame that is a little slow, so between "too slow" and "room
//! for more" lies a band in which nothing changes, wider than a step of the scale; medians decide, not single frames; and
//! more pixels that had to be taken back are tried again only after twice as many pictures as before.
//!
//! Scales come in steps: step 0 is every pixel, and each further one has 2^(-1/3) = 0.79 times the pixels of the one before.

use std::collections::VecDeque;

use glam::UVec2;

/// Pictures that are looked back at, and that more pixels wait for at least.
const SPAN: usize = 16;
/// So many pictures above so much of the time there is make it smaller: at once where it is bad, else when it is sure.
const TOO_SLOW: [(usize, f64); 3] = [(2, 6.0), (6, 1.5), (SPAN, 1.15)];
/// A smaller picture is to take at most so much of the time there is.
const SMALLER: f64 = 0.9;
/// A larger one too.
const LARGER: f64 = 0.85;
/// Pixels keep this share of a frame, whatever else takes time in it: fewer of them would not make that any faster.
const LEAST_SHARE: f64 = 0.25;
/// Most pictures that more pixels are waited for.
const MOST_PATIENCE: u32 = 1024;
/// Most samples that a frame adds to a picture that stands still.
const MOST_SAMPLES: u32 = 16;

/// What a picture from its start cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Milliseconds of rays for each of its pixels.
    pub of_a_pixel: f64,
    /// Milliseconds of the frame that do not go with the pixels.
    pub rest: f64,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Budget {
    target: f64,
    step: u32,
    /// No coarser than this.
    last_step: u32,
    /// The last pictures at this scale, the newest last.
    seen: VecDeque<Cost>,
    /// Pictures since the scale was changed.
    since: u32,
    /// The last change was to more pixels.
    has_risen: bool,
    /// Pictures that more pixels wait for.
    patience: u32,
}

impl Budget {
    /// Keeps frames at `target` milliseconds, from the step nearest to `scale` on, and none coarser than that of `least`.
    pub fn new(target: f64, scale: f64, least: f64) -> Self {
        let step_of = |scale: f64| (-6.0 * scale.log2()).round().max(0.0) as u32;
        Self {
            target,
            step: step_of(scale),
            last_step: step_of(least),
            seen: VecDeque::with_capacity(SPAN),
            since: 0,
            has_risen: false,
            patience: SPAN as u32,
        }
    }

    /// Milliseconds of a frame.
    pub fn target(&self) -> f64 {
        self.target
    }

    /// Traced pixels for each of the window's, along an axis.
    pub fn scale(&self) -> f64 {
        (f64::from(self.step) / -6.0).exp2()
    }

    /// Takes note of a picture.
    pub fn observe(&mut self, window: UVec2, cost: Cost) {
        if self.seen.len() == SPAN {
            self.seen.pop_front();
        }
        self.seen.push_back(cost);
        self.since += 1;
        if self.has_risen && self.since > 2 * self.patience {
            // They were right.
            (self.has_risen, self.patience) = (false, SPAN as u32);
        }
        let is_slow = |&(count, limit): &(usize, f64)| {
            self.load(window, count)
                .filter(|load| load * share(self.step) > limit)
        };
        if let Some(load) = TOO_SLOW.iter().find_map(is_slow) {
            let fits = |step: &u32| load * share(*step) <= SMALLER;
            let step = (self.step + 1..=self.last_step)
                .find(fits)
                .unwrap_or(self.last_step);
            if step > self.step {
                self.patience = if self.has_risen {
                    (2 * self.patience).min(MOST_PATIENCE)
                } else {
                    SPAN as u32
                };
                self.go_to(step);
            }
        } else if self.since >= self.patience
            && let Some(load) = self.load(window, SPAN)
            && let Some(step) = (0..self.step).find(|step| load * share(*step) <= LARGER)
        {
            self.go_to(step);
            self.has_risen = true;
        }
    }

    /// Samples that a frame can add to a picture that stands still, where a picture from its start takes `samples`.
    pub fn samples_when_still(&self, window: UVec2, samples: u32) -> u32 {
        let load = self.load(window, self.seen.len().max(1));
        let of_one = load.map(|load| load * share(self.step) / f64::from(samples.max(1)));
        of_one.map_or(1, |one| (1.0 / one).clamp(1.0, MOST_SAMPLES.into()) as u32)
    }

    fn go_to(&mut self, step: u32) {
        self.step = step;
        self.seen.clear();
        self.since = 0;
        self.has_risen = false;
    }

    /// The rays of every pixel of the window, as a multiple of the time there is for rays: by the median of the last
    /// `count` pictures, if there are as many.
    fn load(&self, window: UVec2, count: usize) -> Option<f64> {
        let first = self.seen.len().checked_sub(count)?;
        let pixels = window.as_dvec2().element_product();
        let load = |cost: &Cost| {
            let room = (self.target - cost.rest).max(LEAST_SHARE * self.target);
            cost.of_a_pixel * pixels / room
        };
        let mut loads: Vec<f64> = self.seen.range(first..).map(load).collect();
        loads.sort_by(f64::total_cmp);
        loads.get((count - 1) / 2).copied()
    }
}

/// Pixels of a step, of all.
fn share(step: u32) -> f64 {
    (f64::from(step) / -3.0).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: UVec2 = UVec2::new(1280, 720);

    /// A fixed sequence of numbers in [0, 1) (PCG's multiplier and increment, Knuth's for MMIX).
    struct Random(u64);

    impl Random {
        fn unit(&mut self) -> f64 {
            let next = self.0.wrapping_mul(6_364_136_223_846_793_005);
            self.0 = next.wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn range(&mut self, from: f64, to: f64) -> f64 {
            from + (to - from) * self.unit()
        }
    }

    /// A tracer that takes `full` milliseconds for the rays of a whole window, more or less, and now and then far more.
    struct Simulated {
        full: f64,
        rest: f64,
        noise: f64,
        /// Of its cost in its pixels; 1: it goes with them.
        exponent: f64,
        random: Random,
    }

    impl Simulated {
        fn new(seed: u64, full: f64) -> Self {
            let random = Random(seed);
            Self {
                full,
                rest: 0.0,
                noise: 0.0,
                exponent: 1.0,
                random,
            }
        }

        /// Milliseconds of a frame at this scale, without the noise.
        fn frame(&self, scale: f64) -> f64 {
            self.rest + self.full * (scale * scale).powf(self.exponent)
        }

        /// Scales of the next so many pictures.
        fn run(&mut self, budget: &mut Budget, pictures: usize) -> Vec<f64> {
            let one = |_| {
                let scale = budget.scale();
                let is_hiccup = self.random.unit() < 0.02;
                let noise = 1.0 + self.noise * self.random.range(-1.0, 1.0);
                let rays =
                    (self.frame(scale) - self.rest) * noise * if is_hiccup { 5.0 } else { 1.0 };
                let pixels = WINDOW.as_dvec2().element_product() * scale * scale;
                budget.observe(
                    WINDOW,
                    Cost {
                        of_a_pixel: rays / pixels,
                        rest: self.rest,
                    },
                );
                budget.scale()
            };
            (0..pictures).map(one).collect()
        }
    }

    fn changes(scales: &[f64]) -> usize {
        scales.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Whether the frame is where it should be: not too slow, and not much faster than need be.
    fn is_kept(budget: &Budget, frame: f64) -> bool {
        let is_fast_enough = frame <= 1.2 * budget.target || budget.step == budget.last_step;
        is_fast_enough && (frame >= 0.6 * budget.target || budget.step == 0)
    }

    #[test]
    fn any_cost_settles_at_its_target_and_stays_there() {
        let mut random = Random(7);
        for seed in 0..300 {
            let full = random.range(0.0, 11.0).exp2();
            let target = random.range(2.0, 7.0).exp2();
            let mut tracer = Simulated::new(seed, full);
            tracer.noise = 0.2;
            let mut budget = Budget::new(target, [0.5, 1.0][seed as usize % 2], 0.125);
            // Time for a few changes, each after the longest look back.
            tracer.run(&mut budget, 6 * SPAN);
            assert!(
                is_kept(&budget, tracer.frame(budget.scale())),
                "{full} ms at {target} ms: {budget:?}"
            );
            let scales = tracer.run(&mut budget, 2000);
            let case = format!("{full} ms at {target} ms: {:?}", budget.scale());
            assert!(changes(&scales) <= 2, "{case}: {} swings", changes(&scales));
            assert!(is_kept(&budget, tracer.frame(budget.scale())), "{case}");
        }
    }

    #[test]
    fn a_scene_that_grows_and_shrinks_is_followed_in_a_few_changes() {
        for seed in 0..40 {
            let mut random = Random(seed + 100);
            let mut tracer = Simulated::new(seed, 100.0);
            tracer.noise = 0.2;
            let mut budget = Budget::new(40.0, 1.0, 0.125);
            for phase in 0..12 {
                tracer.full = random.range(3.0, 10.0).exp2();
                tracer.rest = random.range(0.0, 20.0);
                let scales = tracer.run(&mut budget, 300);
                let frame = tracer.frame(budget.scale());
                let case = format!("seed {seed}, phase {phase}: {} ms full", tracer.full);
                assert!(is_kept(&budget, frame), "{case}: {frame} ms");
                assert!(changes(&scales) <= 5, "{case}: {scales:?}");
                let late = changes(&scales[100..]);
                assert!(late <= 2, "{case}: {late} changes after it had time");
            }
        }
    }

    #[test]
    fn what_is_far_too_slow_is_not_looked_at_for_long() {
        let mut tracer = Simulated::new(1, 2000.0);
        let mut budget = Budget::new(50.0, 1.0, 0.125);
        let scales = tracer.run(&mut budget, 2);
        assert!(tracer.frame(scales[1]) < 60.0, "{scales:?}");
    }

    /// Twice the pixels take eight times as long: every forecast is wrong.
    #[test]
    fn a_cost_that_defies_the_forecast_swings_ever_less() {
        let mut tracer = Simulated::new(3, 900.0);
        tracer.exponent = 3.0;
        let mut budget = Budget::new(40.0, 1.0, 0.125);
        let first = changes(&tracer.run(&mut budget, 2000));
        let later = changes(&tracer.run(&mut budget, 2000));
        assert!(first <= 16 && later <= 5, "{first}, then {later}");
    }

    #[test]
    fn what_pixels_do_not_cause_does_not_take_them_all() {
        let mut tracer = Simulated::new(4, 20.0);
        tracer.rest = 200.0;
        let mut budget = Budget::new(50.0, 1.0, 0.125);
        tracer.run(&mut budget, 200);
        let rays = tracer.frame(budget.scale()) - tracer.rest;
        assert!((8.0..=14.0).contains(&rays), "{rays} ms of rays");
    }

    #[test]
    fn a_larger_window_gets_the_same_number_of_pixels() {
        let mut budget = Budget::new(40.0, 1.0, 0.125);
        let cost = Cost {
            of_a_pixel: 39.0 / WINDOW.as_dvec2().element_product(),
            rest: 0.0,
        };
        (0..40).for_each(|_| budget.observe(WINDOW, cost));
        assert_eq!(budget.scale(), 1.0);
        (0..40).for_each(|_| budget.observe(2 * WINDOW, cost));
        assert!((0.4..=0.5).contains(&budget.scale()), "{budget:?}");
        (0..40).for_each(|_| budget.observe(WINDOW / 2, cost));
        assert_eq!(budget.scale(), 1.0);
    }

    #[test]
    fn time_that_is_left_goes_into_samples() {
        let mut budget = Budget::new(40.0, 1.0, 0.125);
        assert_eq!(budget.samples_when_still(WINDOW, 1), 1);
        let cost = |millis: f64| Cost {
            of_a_pixel: millis / WINDOW.as_dvec2().element_product(),
            rest: 10.0,
        };
        (0..SPAN).for_each(|_| budget.observe(WINDOW, cost(7.0)));
        assert_eq!(budget.samples_when_still(WINDOW, 1), 4);
        assert_eq!(budget.samples_when_still(WINDOW, 2), 8);
        assert_eq!(budget.samples_when_still(WINDOW / 4, 1), MOST_SAMPLES);
        assert_eq!(budget.samples_when_still(4 * WINDOW, 1), 1);
    }
}
