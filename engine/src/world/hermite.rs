//! The cubic Hermite curve: between two values, by the velocities there.
//!
//! Read by the keys of the timeline and by those of clips.

use std::ops::{Add, Mul, Sub};

use glam::{DQuat, DVec3};

/// What a curve needs of its values.
pub trait Blend: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}
impl Blend for f64 {}
impl Blend for DVec3 {}
impl Blend for DQuat {}

/// The cubic from `p0` to `p1` with velocities `m0` and `m1` (a whole way's worth) at t = 0 and 1.
pub fn hermite<T: Blend>(p0: T, m0: T, p1: T, m1: T, t: f64) -> T {
    let (t2, t3) = (t * t, t * t * t);
    p0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + m0 * (t3 - 2.0 * t2 + t)
        + p1 * (3.0 * t2 - 2.0 * t3)
        + m1 * (t3 - t2)
}
