//! Lanes of AVX-512 and AVX2.
//!
//! Unsafe, since the compiler lets instructions be used only where it knows that they are there. They are: a token of
//! either kind is made after the processor was asked, vectors are made by tokens alone, and whatever is done needs one of
//! them. Memory is read and written through references to arrays of the very size, unaligned.

#![allow(unsafe_code)]

/// The operators of a type, one instruction for each of its vectors.
macro_rules! operator {
    ($type:ident, $trait:ident, $name:ident, |$a:ident, $b:ident| $all:expr) => {
        impl $trait for $type {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self.0, other.0);
                // SAFETY: vectors are made by tokens alone.
                Self(unsafe { $all })
            }
        }
    };
}

mod avx2;
mod avx512;
mod eight;

pub use self::avx2::Avx2;
pub use self::avx512::Avx512;

/// Asks for the memory that something is in, so that it is near when it is read.
#[inline(always)]
pub fn prefetch<T>(of: &T) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    let first = std::ptr::from_ref(of).cast::<i8>();
    let last = size_of::<T>().saturating_sub(1);
    // SAFETY: SSE is everywhere here, and the addresses are those of the first and the last byte of something.
    unsafe {
        for line in (0..last).step_by(64) {
            _mm_prefetch::<_MM_HINT_T0>(first.add(line));
        }
        _mm_prefetch::<_MM_HINT_T0>(first.add(last));
    }
}
