//! Eight f32 in a vector of AVX: of either token, since what has AVX-512 has AVX2.

use std::arch::x86_64::*;
use std::ops::{Mul, Sub};

use crate::trace::cpu::simd::Eight;

/// Eight f32.
#[derive(Clone, Copy)]
pub struct Floats8(__m256);

operator!(Floats8, Sub, sub, |a, b| _mm256_sub_ps(a, b));
operator!(Floats8, Mul, mul, |a, b| _mm256_mul_ps(a, b));

impl Floats8 {
    /// The same number in each lane.
    ///
    /// # Safety
    /// AVX2 must be there.
    #[inline(always)]
    pub unsafe fn splat(x: f32) -> Self {
        // SAFETY: the caller's.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    /// A number a lane.
    ///
    /// # Safety
    /// AVX2 must be there.
    #[inline(always)]
    pub unsafe fn load(row: &[f32; 8]) -> Self {
        // SAFETY: the caller's; eight numbers.
        Self(unsafe { _mm256_loadu_ps(row.as_ptr()) })
    }
}

impl Eight for Floats8 {
    #[inline(always)]
    fn store(self, row: &mut [f32; 8]) {
        // SAFETY: vectors are made by tokens alone; eight numbers.
        unsafe { _mm256_storeu_ps(row.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        // SAFETY: vectors are made by tokens alone.
        Self(unsafe { _mm256_min_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_max_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn le(self, b: Self) -> u32 {
        // SAFETY: as above.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, b.0)) as u32 }
    }
}
