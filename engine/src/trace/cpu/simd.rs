//! Sixteen lanes of f32 at once, or eight, and the choice of the processor's instructions that serve them.
//!
//! A [`Simd`] is a proof that its instructions are there: it comes from [`Instructions`] alone. What is generic over it
//! must be `#[inline(always)]` down to the arithmetic, so that [`Instructions::run`] compiles all of it for them.
//!
//! Lanes are our own, in `x86.rs` and `portable.rs`, on what the compiler names the instructions by. Of the crates,
//! `fearless_simd` 0.4 has no AVX-512, and `pulp` 0.22 gives masks no form that bits can be counted in; both would need the
//! same tokens and inlining. Everywhere but on x86-64 the portable lanes serve, four `glam::Vec4` (NEON, or SSE2).
//!
//! Nothing is ever fused (`mul_add`), and minima and maxima are comparisons, so all give the same bits.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, Div, Mul, Sub};
use std::sync::OnceLock;

pub use self::portable::Portable;
#[cfg(target_arch = "x86_64")]
pub use self::x86::prefetch;

/// Asks for the memory that something is in, where that can be asked for.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub fn prefetch<T>(_: &T) {}

/// Lanes.
pub const LANES: usize = 16;
/// A number a lane.
pub type Row = [f32; LANES];
/// A bit a lane, that of the first lowest.
pub type Mask = u16;

/// Names the instructions to use, if they are there.
const VARIABLE: &str = "ORRERY_CPU";
/// What it may name.
const NAMES: [&str; 3] = ["avx512", "avx2", "portable"];

/// The proof that some instructions are there, and what makes lanes.
pub trait Simd: Copy {
    /// Sixteen f32.
    type Floats: Floats;
    /// The same number in each lane.
    fn splat(self, x: f32) -> Self::Floats;
    /// A number a lane.
    fn load(self, row: &Row) -> Self::Floats;
    /// The same f64 in each lane.
    fn splat_wide(self, x: f64) -> <Self::Floats as Floats>::Wide;
    /// Eight f32.
    type Eight: Eight;
    /// The same number in each of eight lanes.
    fn splat_eight(self, x: f32) -> Self::Eight;
    /// A number each of eight lanes.
    fn load_eight(self, row: &[f32; 8]) -> Self::Eight;
    /// Lanes that hold these bits.
    fn equal_bits(self, row: &[u32; LANES], bits: u32) -> Mask;
}

/// Sixteen f32.
pub trait Floats:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Sixteen f64.
    type Wide: Wide<Narrow = Self>;
    /// Writes all lanes.
    fn store(self, row: &mut Row);
    /// Writes these lanes.
    fn store_where(self, mask: Mask, row: &mut Row);
    /// a < b ? a : b.
    fn min(self, b: Self) -> Self;
    /// a > b ? a : b.
    fn max(self, b: Self) -> Self;
    /// a < b.
    fn lt(self, b: Self) -> Mask;
    /// a <= b.
    fn le(self, b: Self) -> Mask;
    /// a == b.
    fn eq(self, b: Self) -> Mask;
    /// The least of all lanes.
    fn least(self) -> f32;
    /// The greatest of all lanes.
    fn greatest(self) -> f32;
    /// As f64.
    fn wide(self) -> Self::Wide;
}

/// Eight f32.
pub trait Eight: Copy + Sub<Output = Self> + Mul<Output = Self> {
    /// Writes all lanes.
    fn store(self, row: &mut [f32; 8]);
    /// a < b ? a : b.
    fn min(self, b: Self) -> Self;
    /// a > b ? a : b.
    fn max(self, b: Self) -> Self;
    /// a <= b, a bit a lane.
    fn le(self, b: Self) -> u32;
}

/// Sixteen f64.
pub trait Wide:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Sixteen f32.
    type Narrow;
    /// Rounded to nearest.
    fn narrow(self) -> Self::Narrow;
    /// Lanes that are zero.
    fn is_zero(self) -> Mask;
}

/// What is done with lanes.
pub trait Work {
    /// What comes of it.
    type Output;
    /// Does it; `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Instructions that this processor has.
#[derive(Clone, Copy, Debug)]
pub enum Instructions {
    /// AVX-512: foundation, byte and word, double and quad word, vector length.
    #[cfg(target_arch = "x86_64")]
    Avx512(x86::Avx512),
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Avx2),
    /// What every processor of its architecture has.
    Portable,
}

impl Default for Instructions {
    /// The widest there are, or those that the environment names.
    fn default() -> Self {
        static CHOSEN: OnceLock<Instructions> = OnceLock::new();
        *CHOSEN.get_or_init(|| {
            let named = std::env::var(VARIABLE).unwrap_or_default();
            let all = Self::all();
            let mut wanted = all.iter().filter(|one| one.name() == named);
            *wanted.next().unwrap_or(&all[0])
        })
    }
}

impl Instructions {
    /// All that are here, the widest first.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(x86::Avx512::new().map(Self::Avx512));
            all.extend(x86::Avx2::new().map(Self::Avx2));
        }
        all.push(Self::Portable);
        all
    }

    /// Whether what the environment names, if anything, is known.
    ///
    /// # Errors
    /// What it names, and what it may.
    pub fn check_named() -> Result<(), String> {
        let Some(named) = std::env::var_os(VARIABLE) else {
            return Ok(());
        };
        if named.is_empty() || NAMES.iter().any(|&name| named == name) {
            return Ok(());
        }
        Err(format!(
            "{VARIABLE} is `{}`, which names none of a processor's instructions: it may be {}",
            named.display(),
            NAMES.join(", ")
        ))
    }

    /// As the environment names them.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "avx2",
            Self::Portable => "portable",
        }
    }

    /// Does the work with them.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(simd) => simd.run(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.run(work),
            Self::Portable => work.run(Portable),
        }
    }
}

/// Numbers of the lanes of a mask, lowest first.
#[inline(always)]
pub fn lanes(mask: Mask) -> impl Iterator<Item = usize> {
    let mut rest = mask;
    std::iter::from_fn(move || {
        (rest != 0).then(|| {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            lane
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Every operation, in bits.
    struct Everything {
        a: Row,
        b: Row,
    }

    impl Work for Everything {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Vec<u32> {
            let (a, b) = (simd.load(&self.a), simd.load(&self.b));
            let mut bits = Vec::new();
            let mut note = |floats: S::Floats| {
                let mut row = [0.0; LANES];
                floats.store(&mut row);
                bits.extend(row.map(f32::to_bits));
            };
            for floats in [a + b, a - b, a * b, a / b, a.min(b), a.max(b)] {
                note(floats);
            }
            let (wide, other) = (a.wide(), b.wide());
            let third = simd.splat_wide(1.0 / 3.0);
            note((wide + other).narrow());
            note((wide * third - other / third).narrow());
            let mut row = self.b;
            (a * a).store_where(a.lt(b), &mut row);
            note(simd.load(&row));
            bits.extend([a.lt(b), a.le(b), a.eq(b), (wide - other).is_zero()].map(u32::from));
            let (low, high) = (&self.a[..8], &self.b[..8]);
            let eight = |row: &[f32]| simd.load_eight(row.try_into().expect("eight"));
            let (a, b) = (eight(low), eight(high));
            for eight in [a - b, a * b, a.min(b), a.max(simd.splat_eight(0.5))] {
                let mut row = [0.0; 8];
                eight.store(&mut row);
                bits.extend(row.map(f32::to_bits));
            }
            bits.push(a.le(b));
            let a = simd.load(&self.a);
            let ids = self.a.map(f32::to_bits);
            bits.push(simd.equal_bits(&ids, ids[3]).into());
            bits.extend([a.least(), a.greatest()].map(f32::to_bits));
            bits
        }
    }

    #[test]
    fn all_instructions_give_the_same_bits() {
        let mut random = Random::new(3);
        for _ in 0..2000 {
            let mut row = || [0.0; LANES].map(|_: f32| random.range(-2.0, 2.0) as f32);
            let (a, mut b) = (row(), row());
            b[3] = a[3];
            b[7] = -0.0;
            let all = Instructions::all();
            let answers = all.iter().map(|one| one.run(Everything { a, b }));
            let answers: Vec<Vec<u32>> = answers.collect();
            for (one, answer) in all.iter().zip(&answers) {
                assert_eq!(answer, &answers[answers.len() - 1], "{}", one.name());
            }
        }
    }

    #[test]
    fn lanes_are_named_in_order() {
        assert!(lanes(0b1000_0000_0010_0001).eq([0, 5, 15]));
        assert_eq!(lanes(0).count(), 0);
    }
}
