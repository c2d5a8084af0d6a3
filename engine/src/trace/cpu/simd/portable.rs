//! Lanes for every processor: four vectors of four.

use std::ops::{Add, Div, Mul, Sub};

use glam::{DVec4, Vec4};

use super::{Eight, Floats, LANES, Mask, Row, Simd, Wide};

/// Needs nothing.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct Floats4([Vec4; 4]);

/// Eight f32.
#[derive(Clone, Copy)]
pub struct Two4([Vec4; 2]);

/// Sixteen f64.
#[derive(Clone, Copy)]
pub struct Wide4([DVec4; 4]);

impl Simd for Portable {
    type Floats = Floats4;
    type Eight = Two4;

    #[inline(always)]
    fn splat(self, x: f32) -> Floats4 {
        Floats4([Vec4::splat(x); 4])
    }

    #[inline(always)]
    fn load(self, row: &Row) -> Floats4 {
        Floats4([0, 4, 8, 12].map(|i| Vec4::from_slice(&row[i..i + 4])))
    }

    #[inline(always)]
    fn splat_wide(self, x: f64) -> Wide4 {
        Wide4([DVec4::splat(x); 4])
    }

    #[inline(always)]
    fn splat_eight(self, x: f32) -> Two4 {
        Two4([Vec4::splat(x); 2])
    }

    #[inline(always)]
    fn load_eight(self, row: &[f32; 8]) -> Two4 {
        Two4([0, 4].map(|i| Vec4::from_slice(&row[i..i + 4])))
    }

    #[inline(always)]
    fn equal_bits(self, row: &[u32; LANES], bits: u32) -> Mask {
        let mut mask = 0;
        for (lane, &other) in row.iter().enumerate() {
            mask |= Mask::from(other == bits) << lane;
        }
        mask
    }
}

macro_rules! lanewise {
    ($type:ident, $trait:ident, $name:ident) => {
        impl $trait for $type {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
                Self([a.$name(e), b.$name(f), c.$name(g), d.$name(h)])
            }
        }
    };
}

lanewise!(Floats4, Add, add);
lanewise!(Floats4, Sub, sub);
lanewise!(Floats4, Mul, mul);
lanewise!(Floats4, Div, div);
lanewise!(Wide4, Add, add);
lanewise!(Wide4, Sub, sub);
lanewise!(Wide4, Mul, mul);
lanewise!(Wide4, Div, div);

impl Floats4 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        let ([a, b, c, d], [e, g, h, i]) = (self.0, other.0);
        Self([f(a, e), f(b, g), f(c, h), f(d, i)])
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(Vec4, Vec4) -> u32) -> Mask {
        let ([a, b, c, d], [e, g, h, i]) = (self.0, other.0);
        (f(a, e) | f(b, g) << 4 | f(c, h) << 8 | f(d, i) << 12) as Mask
    }
}

impl Floats for Floats4 {
    type Wide = Wide4;

    #[inline(always)]
    fn store(self, row: &mut Row) {
        for (vector, place) in self.0.into_iter().zip(row.chunks_exact_mut(4)) {
            vector.write_to_slice(place);
        }
    }

    #[inline(always)]
    fn store_where(self, mask: Mask, row: &mut Row) {
        let mut all = [0.0; LANES];
        self.store(&mut all);
        for lane in super::lanes(mask) {
            row[lane] = all[lane];
        }
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.zip(b, |a, b| Vec4::select(a.cmplt(b), a, b))
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.zip(b, |a, b| Vec4::select(a.cmpgt(b), a, b))
    }

    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        self.mask(b, |a, b| a.cmplt(b).bitmask())
    }

    #[inline(always)]
    fn le(self, b: Self) -> Mask {
        self.mask(b, |a, b| a.cmple(b).bitmask())
    }

    #[inline(always)]
    fn eq(self, b: Self) -> Mask {
        self.mask(b, |a, b| a.cmpeq(b).bitmask())
    }

    #[inline(always)]
    fn least(self) -> f32 {
        let [a, b, c, d] = self.0;
        a.min(b).min(c.min(d)).min_element()
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        let [a, b, c, d] = self.0;
        a.max(b).max(c.max(d)).max_element()
    }

    #[inline(always)]
    fn wide(self) -> Wide4 {
        Wide4(self.0.map(|v| v.as_dvec4()))
    }
}

impl Sub for Two4 {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Two4 {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Two4 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        Self([f(a, c), f(b, d)])
    }
}

impl Eight for Two4 {
    #[inline(always)]
    fn store(self, row: &mut [f32; 8]) {
        for (vector, place) in self.0.into_iter().zip(row.chunks_exact_mut(4)) {
            vector.write_to_slice(place);
        }
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.zip(b, |a, b| Vec4::select(a.cmplt(b), a, b))
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.zip(b, |a, b| Vec4::select(a.cmpgt(b), a, b))
    }

    #[inline(always)]
    fn le(self, b: Self) -> u32 {
        let ([a, b], [c, d]) = (self.0, b.0);
        a.cmple(c).bitmask() | b.cmple(d).bitmask() << 4
    }
}

impl Wide for Wide4 {
    type Narrow = Floats4;

    #[inline(always)]
    fn narrow(self) -> Floats4 {
        Floats4(self.0.map(|v| v.as_vec4()))
    }

    #[inline(always)]
    fn is_zero(self) -> Mask {
        let [a, b, c, d] = self.0.map(|v| v.cmpeq(DVec4::ZERO).bitmask());
        (a | b << 4 | c << 8 | d << 12) as Mask
    }
}
