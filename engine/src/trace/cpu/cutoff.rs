//! Leaving out rays too faint to matter, within a bound that holds for every pixel.
//!
//! Hall and Greenberg ("A Testbed for Realistic Image Synthesis", 1983) end a path where its weight falls below a
//! threshold; many such ends may still add up to anything. Here each camera ray has a purse, the error it may make. A
//! reflected or refracted ray brings back at most its weight times the bound of its generation
//! ([`crate::frame::wire::ViewRow::bounds`]): where the purse holds that much, the ray is not followed and the
//! purse pays. A light adds at most what it does unshadowed, which is known before its shadow ray is traced: where the purse holds that, the light
//! is left out. What is left out of a sample is therefore at most the purse, and of a pixel, the mean of samples, too.
//! An adaptive picture takes its further samples where first samples differ: those have empty purses, so that the same
//! pixels take them, or a pixel could change by as much as those samples are worth.
//!
//! Twin of `shaders/shared/cutoff.wgsl`. Called by `light.rs` and `path.rs` at every surface.

use glam::Vec3;

use crate::frame::wire::ViewRow;
use crate::trace::progress::is_adaptive;

/// Least payment, as a share of what the purse holds: more than its last digits, so that no payment is lost in rounding.
const LEAST_PAYMENT: f32 = 1.0 / (1 << 18) as f32;

/// What a camera ray may still leave out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Purse {
    left: f32,
}

impl Purse {
    /// For the camera ray of a pixel's sample of this number. First samples of adaptive pictures leave out nothing: which
    /// pixels take more must not depend on what is left out.
    pub fn of_sample(view: &ViewRow, index: u32) -> Self {
        let finds_edges = index == 0 && is_adaptive(view);
        Self {
            left: if finds_edges { 0.0 } else { view.cutoff },
        }
    }

    /// Whether anything may be left out.
    #[inline]
    pub fn holds_any(&self) -> bool {
        self.left > 0.0
    }

    /// Pays for leaving out a ray that costs so much, if it can. What costs nothing is not bought: it ends by itself.
    pub fn buys(&mut self, cost: f32) -> bool {
        if cost <= 0.0 || cost > self.left {
            return false;
        }
        self.left -= cost.max(self.left * LEAST_PAYMENT);
        true
    }
}

/// The most that a ray of this weight and generation adds to a channel of its sample.
pub fn most_added(view: &ViewRow, weight: Vec3, generation: u32) -> f32 {
    if generation > view.max_generations {
        return 0.0;
    }
    let index = generation as usize - 1;
    weight.max_element() * view.bounds[index / 4][index % 4]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn a_purse_pays_no_more_than_it_held() {
        let mut random = Random::new(3);
        for most in [1.0_f32, 1e-3, 1e-9] {
            let mut purse = Purse { left: most };
            let mut left_out = 0.0;
            for _ in 0..3_000_000 {
                // Down to far below the purse's last digit.
                let cost = most * 10_f32.powf(random.range(-10.0, 0.0) as f32);
                if purse.buys(cost) {
                    left_out += f64::from(cost);
                }
            }
            let share = left_out / f64::from(most);
            assert!(share <= 1.01 && share > 0.1, "{share} of the purse");
            assert!(!purse.buys(0.0) && !purse.buys(most));
        }
    }
}
