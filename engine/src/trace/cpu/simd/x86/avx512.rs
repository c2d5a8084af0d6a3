//! Lanes of AVX-512: a vector of f32, two of f64.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::eight::Floats8;
use crate::trace::cpu::simd::{Floats, LANES, Mask, Row, Simd, Wide, Work};

/// AVX-512 is there.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    /// None: it is not there.
    pub fn new() -> Option<Self> {
        let is_there = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt");
        is_there.then_some(Self(()))
    }

    /// Does the work with it.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx2,avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
        fn run<W: Work>(simd: Avx512, work: W) -> W::Output {
            work.run(simd)
        }
        // SAFETY: the token says that all of these are there.
        unsafe { run(self, work) }
    }
}

/// Sixteen f32 of AVX-512.
#[derive(Clone, Copy)]
pub struct Floats512(__m512);

/// Sixteen f64 of AVX-512.
#[derive(Clone, Copy)]
pub struct Wide512([__m512d; 2]);

operator!(Floats512, Add, add, |a, b| _mm512_add_ps(a, b));
operator!(Floats512, Sub, sub, |a, b| _mm512_sub_ps(a, b));
operator!(Floats512, Mul, mul, |a, b| _mm512_mul_ps(a, b));
operator!(Floats512, Div, div, |a, b| _mm512_div_ps(a, b));
operator!(Wide512, Add, add, |a, b| [
    _mm512_add_pd(a[0], b[0]),
    _mm512_add_pd(a[1], b[1])
]);
operator!(Wide512, Sub, sub, |a, b| [
    _mm512_sub_pd(a[0], b[0]),
    _mm512_sub_pd(a[1], b[1])
]);
operator!(Wide512, Mul, mul, |a, b| [
    _mm512_mul_pd(a[0], b[0]),
    _mm512_mul_pd(a[1], b[1])
]);
operator!(Wide512, Div, div, |a, b| [
    _mm512_div_pd(a[0], b[0]),
    _mm512_div_pd(a[1], b[1])
]);
impl Simd for Avx512 {
    type Floats = Floats512;
    type Eight = Floats8;

    #[inline(always)]
    fn splat(self, x: f32) -> Floats512 {
        // SAFETY: the token.
        Floats512(unsafe { _mm512_set1_ps(x) })
    }

    #[inline(always)]
    fn load(self, row: &Row) -> Floats512 {
        // SAFETY: the token; sixteen numbers.
        Floats512(unsafe { _mm512_loadu_ps(row.as_ptr()) })
    }

    #[inline(always)]
    fn splat_wide(self, x: f64) -> Wide512 {
        // SAFETY: the token.
        Wide512(unsafe { [_mm512_set1_pd(x); 2] })
    }

    #[inline(always)]
    fn splat_eight(self, x: f32) -> Floats8 {
        // SAFETY: the token.
        unsafe { Floats8::splat(x) }
    }

    #[inline(always)]
    fn load_eight(self, row: &[f32; 8]) -> Floats8 {
        // SAFETY: the token.
        unsafe { Floats8::load(row) }
    }

    #[inline(always)]
    fn equal_bits(self, row: &[u32; LANES], bits: u32) -> Mask {
        // SAFETY: the token; sixteen numbers.
        unsafe {
            let row = _mm512_loadu_si512(row.as_ptr().cast());
            _mm512_cmpeq_epi32_mask(row, _mm512_set1_epi32(bits as i32))
        }
    }
}

impl Floats for Floats512 {
    type Wide = Wide512;

    #[inline(always)]
    fn store(self, row: &mut Row) {
        // SAFETY: vectors are made by tokens alone; sixteen numbers.
        unsafe { _mm512_storeu_ps(row.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn store_where(self, mask: Mask, row: &mut Row) {
        // SAFETY: as above.
        unsafe { _mm512_mask_storeu_ps(row.as_mut_ptr(), mask, self.0) }
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        // SAFETY: vectors are made by tokens alone.
        Self(unsafe { _mm512_min_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_max_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        // SAFETY: as above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, b.0) }
    }

    #[inline(always)]
    fn le(self, b: Self) -> Mask {
        // SAFETY: as above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, b.0) }
    }

    #[inline(always)]
    fn eq(self, b: Self) -> Mask {
        // SAFETY: as above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, b.0) }
    }

    #[inline(always)]
    fn least(self) -> f32 {
        // SAFETY: as above.
        unsafe { _mm512_reduce_min_ps(self.0) }
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        // SAFETY: as above.
        unsafe { _mm512_reduce_max_ps(self.0) }
    }

    #[inline(always)]
    fn wide(self) -> Wide512 {
        // SAFETY: as above.
        unsafe {
            let low = _mm512_castps512_ps256(self.0);
            let high = _mm512_extractf32x8_ps::<1>(self.0);
            Wide512([_mm512_cvtps_pd(low), _mm512_cvtps_pd(high)])
        }
    }
}

impl Wide for Wide512 {
    type Narrow = Floats512;

    #[inline(always)]
    fn narrow(self) -> Floats512 {
        // SAFETY: vectors are made by tokens alone.
        unsafe {
            let [low, high] = self.0;
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(low));
            Floats512(_mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(high)))
        }
    }

    #[inline(always)]
    fn is_zero(self) -> Mask {
        // SAFETY: as above.
        unsafe {
            let ([low, high], zero) = (self.0, _mm512_setzero_pd());
            Mask::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(low, zero))
                | Mask::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(high, zero)) << 8
        }
    }
}
