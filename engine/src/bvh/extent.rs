//! [`Extent`]: a box in vector registers, in which refits and builders compute.

use glam::Vec3A;

use crate::geom::Aabb;

/// A box in two registers; the fourth lanes mean nothing.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Least corner.
    pub min: Vec3A,
    /// Greatest corner.
    pub max: Vec3A,
}

impl From<Aabb> for Extent {
    fn from(bounds: Aabb) -> Self {
        Self {
            min: bounds.min.into(),
            max: bounds.max.into(),
        }
    }
}

impl From<Extent> for Aabb {
    fn from(extent: Extent) -> Self {
        Self {
            min: extent.min.into(),
            max: extent.max.into(),
        }
    }
}

impl Extent {
    /// Holds nothing; the neutral element of [`Extent::union`].
    pub const EMPTY: Self = Self {
        min: Vec3A::MAX,
        max: Vec3A::MIN,
    };

    /// The least box around the corners of a triangle.
    #[inline]
    pub fn of_triangle([a, b, c]: [Vec3A; 3]) -> Self {
        Self {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }

    /// The least box around both.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Half the surface; meaningless when empty.
    #[inline]
    pub fn half_area(self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// [`Aabb::grown`], the same bits, without branches.
    ///
    /// With u = 2^-24, x - u (1 + 2u) |x| rounds to the number next to x (Rump, Zimmermann, Boldo and
    /// Melquiond 2009, "Computing predecessor and successor in rounding to nearest"); where that fails, near
    /// underflow, 1e-20 is more.
    #[inline]
    #[must_use]
    pub fn grown(self) -> Self {
        const NEXT: f32 = f32::EPSILON / 2.0 * (1.0 + f32::EPSILON);
        let least = Vec3A::splat(1e-20);
        let step = |x: Vec3A| (x.abs() * NEXT).max(least);
        Self {
            min: self.min - step(self.min),
            max: self.max + step(self.max),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn growth_is_that_of_the_plain_box() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from_bits(state ^ state >> 15)
        };
        let special = [0.0, -0.0, 1e-20, -1e-13, 1.0, f32::MAX, f32::MIN, 1e-45];
        let mut corners: Vec<f32> = special.into_iter().collect();
        corners.extend((0..300_000).map(|_| random()).filter(|x| x.is_finite()));
        for corner in corners.windows(3) {
            let [min, max] = [Vec3::from_slice(corner), -Vec3::from_slice(corner)];
            let plain = Aabb { min, max };
            let grown = Aabb::from(Extent::from(plain).grown());
            assert_eq!(grown, plain.grown(), "{plain:?}");
        }
    }
}
