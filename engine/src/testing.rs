//! What the engine's own tests share: random numbers and boxes, and errors counted in units in the last place.

use glam::{DVec3, Vec3};

use crate::geom::Aabb;

/// A small generator (xorshift); the same seed gives the same numbers.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in a range.
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// One of so many numbers from 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Uniform in the cube [-1, 1]^3.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::from([(); 3].map(|()| self.range(-1.0, 1.0)))
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.cube();
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}

/// Boxes of sizes up to 1, of which the least corners lie within a cube of this edge at `shift`.
pub fn boxes(count: usize, spread: f32, shift: f32, seed: u32) -> Vec<Aabb> {
    let mut random = Random::new(u64::from(seed));
    let mut point = || Vec3::from([(); 3].map(|()| random.unit() as f32));
    (0..count)
        .map(|_| {
            let min = point() * spread + shift;
            let max = min + point();
            Aabb { min, max }
        })
        .collect()
}

/// Errors of f32 values in ulps of the exact ones.
#[derive(Default)]
pub struct Ulps(Vec<f64>);

impl Ulps {
    pub fn add(&mut self, found: f32, exact: f64) {
        let size = exact.abs() as f32;
        let ulp = f64::from(size.next_up() - size);
        self.0.push((f64::from(found) - exact).abs() / ulp);
    }

    /// Median, 99th, 99.9th percentile and maximum.
    pub fn quantiles(&mut self) -> [f64; 4] {
        self.0.sort_by(f64::total_cmp);
        let last = (self.0.len() - 1) as f64;
        [0.5, 0.99, 0.999, 1.0].map(|share| self.0[(last * share) as usize])
    }
}
