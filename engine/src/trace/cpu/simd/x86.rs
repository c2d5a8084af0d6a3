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

pub use self::avx2::Avx2;
pub use self::avx512::Avx512;
