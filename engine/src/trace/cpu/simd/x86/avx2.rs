//! Lanes of AVX2: two vectors of f32, four of f64.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::eight::Floats8;
use crate::trace::cpu::simd::{Floats, LANES, Mask, Row, Simd, Wide, Work, lanes};

/// AVX2 is there.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// None: it is not there.
    pub fn new() -> Option<Self> {
        let is_there = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt");
        is_there.then_some(Self(()))
    }

    /// Does the work with it.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
        fn run<W: Work>(simd: Avx2, work: W) -> W::Output {
            work.run(simd)
        }
        // SAFETY: the token says that all of these are there.
        unsafe { run(self, work) }
    }
}

/// Sixteen f32 of AVX2.
#[derive(Clone, Copy)]
pub struct Floats256([__m256; 2]);

/// Sixteen f64 of AVX2.
#[derive(Clone, Copy)]
pub struct Wide256([__m256d; 4]);

operator!(Floats256, Add, add, |a, b| [
    _mm256_add_ps(a[0], b[0]),
    _mm256_add_ps(a[1], b[1])
]);
operator!(Floats256, Sub, sub, |a, b| [
    _mm256_sub_ps(a[0], b[0]),
    _mm256_sub_ps(a[1], b[1])
]);
operator!(Floats256, Mul, mul, |a, b| [
    _mm256_mul_ps(a[0], b[0]),
    _mm256_mul_ps(a[1], b[1])
]);
operator!(Floats256, Div, div, |a, b| [
    _mm256_div_ps(a[0], b[0]),
    _mm256_div_ps(a[1], b[1])
]);
operator!(Wide256, Add, add, |a, b| [
    _mm256_add_pd(a[0], b[0]),
    _mm256_add_pd(a[1], b[1]),
    _mm256_add_pd(a[2], b[2]),
    _mm256_add_pd(a[3], b[3])
]);
operator!(Wide256, Sub, sub, |a, b| [
    _mm256_sub_pd(a[0], b[0]),
    _mm256_sub_pd(a[1], b[1]),
    _mm256_sub_pd(a[2], b[2]),
    _mm256_sub_pd(a[3], b[3])
]);
operator!(Wide256, Mul, mul, |a, b| [
    _mm256_mul_pd(a[0], b[0]),
    _mm256_mul_pd(a[1], b[1]),
    _mm256_mul_pd(a[2], b[2]),
    _mm256_mul_pd(a[3], b[3])
]);
operator!(Wide256, Div, div, |a, b| [
    _mm256_div_pd(a[0], b[0]),
    _mm256_div_pd(a[1], b[1]),
    _mm256_div_pd(a[2], b[2]),
    _mm256_div_pd(a[3], b[3])
]);

impl Simd for Avx2 {
    type Floats = Floats256;
    type Eight = Floats8;

    #[inline(always)]
    fn splat(self, x: f32) -> Floats256 {
        // SAFETY: the token.
        Floats256(unsafe { [_mm256_set1_ps(x); 2] })
    }

    #[inline(always)]
    fn load(self, row: &Row) -> Floats256 {
        let (low, high) = halves(row);
        // SAFETY: the token; eight numbers each.
        Floats256(unsafe {
            [
                _mm256_loadu_ps(low.as_ptr()),
                _mm256_loadu_ps(high.as_ptr()),
            ]
        })
    }

    #[inline(always)]
    fn splat_wide(self, x: f64) -> Wide256 {
        // SAFETY: the token.
        Wide256(unsafe { [_mm256_set1_pd(x); 4] })
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
        let (low, high) = halves(row);
        // SAFETY: the token; eight numbers each.
        unsafe {
            let bits = _mm256_set1_epi32(bits as i32);
            let low = _mm256_cmpeq_epi32(_mm256_loadu_si256(low.as_ptr().cast()), bits);
            let high = _mm256_cmpeq_epi32(_mm256_loadu_si256(high.as_ptr().cast()), bits);
            Floats256::bits(_mm256_castsi256_ps(low), _mm256_castsi256_ps(high))
        }
    }
}

/// The first eight and the others.
#[inline(always)]
fn halves<T>(row: &[T; LANES]) -> (&[T; 8], &[T; 8]) {
    let (low, high) = row.split_at(8);
    match (low.try_into(), high.try_into()) {
        (Ok(low), Ok(high)) => (low, high),
        _ => unreachable!("twice eight are sixteen"),
    }
}

impl Floats256 {
    /// The bits of two comparisons.
    #[inline(always)]
    fn bits(low: __m256, high: __m256) -> Mask {
        // SAFETY: vectors are made by tokens alone.
        unsafe { (_mm256_movemask_ps(low) | _mm256_movemask_ps(high) << 8) as Mask }
    }

    /// Its lanes.
    #[inline(always)]
    fn row(self) -> Row {
        let mut row = [0.0; LANES];
        self.store(&mut row);
        row
    }
}

impl Floats for Floats256 {
    type Wide = Wide256;

    #[inline(always)]
    fn store(self, row: &mut Row) {
        let [low, high] = self.0;
        // SAFETY: vectors are made by tokens alone; the first eight of sixteen numbers, and the others.
        unsafe {
            _mm256_storeu_ps(row.as_mut_ptr(), low);
            _mm256_storeu_ps(row[8..].as_mut_ptr(), high);
        }
    }

    #[inline(always)]
    fn store_where(self, mask: Mask, row: &mut Row) {
        let all = self.row();
        for lane in lanes(mask) {
            row[lane] = all[lane];
        }
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        let ([a, c], [b, d]) = (self.0, b.0);
        // SAFETY: vectors are made by tokens alone.
        Self(unsafe { [_mm256_min_ps(a, b), _mm256_min_ps(c, d)] })
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        let ([a, c], [b, d]) = (self.0, b.0);
        // SAFETY: as above.
        Self(unsafe { [_mm256_max_ps(a, b), _mm256_max_ps(c, d)] })
    }

    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        let ([a, c], [b, d]) = (self.0, b.0);
        // SAFETY: as above.
        unsafe {
            Self::bits(
                _mm256_cmp_ps::<_CMP_LT_OQ>(a, b),
                _mm256_cmp_ps::<_CMP_LT_OQ>(c, d),
            )
        }
    }

    #[inline(always)]
    fn le(self, b: Self) -> Mask {
        let ([a, c], [b, d]) = (self.0, b.0);
        // SAFETY: as above.
        unsafe {
            Self::bits(
                _mm256_cmp_ps::<_CMP_LE_OQ>(a, b),
                _mm256_cmp_ps::<_CMP_LE_OQ>(c, d),
            )
        }
    }

    #[inline(always)]
    fn eq(self, b: Self) -> Mask {
        let ([a, c], [b, d]) = (self.0, b.0);
        // SAFETY: as above.
        unsafe {
            Self::bits(
                _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b),
                _mm256_cmp_ps::<_CMP_EQ_OQ>(c, d),
            )
        }
    }

    #[inline(always)]
    fn least(self) -> f32 {
        self.row().into_iter().fold(f32::INFINITY, f32::min)
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        self.row().into_iter().fold(f32::NEG_INFINITY, f32::max)
    }

    #[inline(always)]
    fn wide(self) -> Wide256 {
        let [low, high] = self.0;
        // SAFETY: as above.
        Wide256(unsafe {
            [
                _mm256_cvtps_pd(_mm256_castps256_ps128(low)),
                _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(low)),
                _mm256_cvtps_pd(_mm256_castps256_ps128(high)),
                _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(high)),
            ]
        })
    }
}

impl Wide for Wide256 {
    type Narrow = Floats256;

    #[inline(always)]
    fn narrow(self) -> Floats256 {
        // SAFETY: vectors are made by tokens alone.
        Floats256(unsafe {
            let [a, b, c, d] = self.0;
            let low = _mm256_castps128_ps256(_mm256_cvtpd_ps(a));
            let high = _mm256_castps128_ps256(_mm256_cvtpd_ps(c));
            [
                _mm256_insertf128_ps::<1>(low, _mm256_cvtpd_ps(b)),
                _mm256_insertf128_ps::<1>(high, _mm256_cvtpd_ps(d)),
            ]
        })
    }

    #[inline(always)]
    fn is_zero(self) -> Mask {
        // SAFETY: as above.
        unsafe {
            let ([a, b, c, d], zero) = (self.0, _mm256_setzero_pd());
            let a = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(a, zero));
            let b = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(b, zero));
            let c = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(c, zero));
            let d = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(d, zero));
            (a | b << 4 | c << 8 | d << 12) as Mask
        }
    }
}
