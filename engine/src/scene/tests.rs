//! The scene file from outside: every kind of problem with its place, round trips, hostile input.

use super::*;

mod blind;
mod clips;
mod components;
mod hostile;
mod manual;
mod meshes;
mod moving;
mod problems;
mod roundtrip;
mod textures;

/// A small xorshift: tests need chance that is the same on every run.
pub(super) struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Often round, sometimes any f64 of a sane size.
    pub fn number(&mut self) -> f64 {
        let fine = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        match self.below(4) {
            0 => (fine * 20.0).round() - 10.0,
            1 => ((fine - 0.5) * 2000.0).round() / 100.0,
            2 => (fine - 0.5) * 1e7,
            _ => fine - 0.5,
        }
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// A folder with a mesh that scenes of tests may name.
pub(super) fn assets() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes")
}
