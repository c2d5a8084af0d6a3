//! Random numbers by counter: the numbers of an index never depend on which thread draws them, or when.

use glam::{DVec3, Vec3};

/// The numbers of one index of one stream.
#[derive(Clone, Debug)]
pub struct Draw(u64);

impl Draw {
    /// Those of `index` in the stream `seed`.
    pub fn of(seed: u64, index: u64) -> Self {
        Self(mix(
            mix(seed.wrapping_add(GOLDEN)) ^ index.wrapping_mul(GOLDEN)
        ))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in a range.
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Ten to a power that is uniform in a range.
    pub fn power(&mut self, from: f64, to: f64) -> f64 {
        10_f64.powf(self.range(from, to))
    }

    /// One of `count`, which is at least 1.
    pub fn below(&mut self, count: usize) -> usize {
        (((self.bits() >> 32) * count as u64) >> 32) as usize
    }

    /// Uniform in [-1, 1)^3.
    pub fn cube(&mut self) -> DVec3 {
        let mut side = || self.range(-1.0, 1.0);
        DVec3::new(side(), side(), side())
    }

    /// Uniform in the ball of radius 1.
    pub fn ball(&mut self) -> DVec3 {
        self.direction() * self.unit().cbrt()
    }

    /// A unit vector, every direction alike (Archimedes).
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let across = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(across * cos, across * sin, z)
    }

    /// [`Draw::direction`], rounded.
    pub fn direction_f32(&mut self) -> Vec3 {
        self.direction().as_vec3()
    }
}

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators" (OOPSLA 2014): SplitMix64's finaliser.
fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_over_streams_and_indices() {
        let mut sum = 0.0;
        let mut seen = std::collections::HashSet::new();
        for index in 0..10_000 {
            let mut draw = Draw::of(index % 7, index);
            assert!((draw.direction().length() - 1.0).abs() < 1e-12);
            sum += draw.unit();
            assert!(draw.below(3) < 3);
            assert!(seen.insert(draw.bits()), "{index}");
        }
        assert!((sum / 10_000.0 - 0.5).abs() < 0.02, "{sum}");
    }
}
