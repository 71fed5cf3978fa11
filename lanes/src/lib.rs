//! Lanes of numbers for kernels that are written once, generic over [`Float`], and run at any number of lanes.
//!
//! Three families exist: `f32` itself (one lane, the reference), [`Avx8`] (eight lanes in AVX2 registers, where the
//! build targets them) and [`Array`] (any number of lanes, elsewhere). [`Native`] names the fastest family of the build.
//! All operations are those of IEEE 754 with one rounding each, so that a kernel returns the same bits in every family.
//!
//! Use it where profiles show that a computation over many values dominates. LLVM does not vectorise such kernels by
//! itself, and arrays take 15 % more time than registers on the Cornell box. The crate `wide` takes as long as arrays
//! there, since it multiplies 64-bit integers lane by lane. This is why the crate exists. Its `unsafe` code is in
//! `avx8.rs`, calls of AVX2 instructions in builds that target AVX2, and in `prefetch.rs`.

mod array;
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
mod avx8;
mod one;
mod prefetch;
mod vector;

pub use array::Array;
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
pub use avx8::Avx8;
pub use prefetch::prefetch;
pub use vector::Vec3;

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// The fastest family of the build.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
pub type Native = Avx8;
/// The fastest family of the build.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
pub type Native = Array<8>;

/// Largest number of lanes.
pub const MOST_LANES: usize = 32;

/// Length of the rows that [`Float::rows`] transposes.
pub const ROW: usize = 8;

/// One truth value per lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Returns the mask of the lowest bits of `bits`, lane 0 lowest.
    fn from_bits(bits: u32) -> Self;
    /// Returns the lanes as bits, lane 0 lowest.
    fn bits(self) -> u32;
    /// Whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Returns `yes` in the lanes that are set, else `no`.
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        (self & yes) | (!self & no)
    }
}

/// One `u32` per lane.
pub trait Int:
    Copy
    + Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// Truth values of comparisons.
    type Mask: Mask;
    /// The same value in every lane.
    fn splat(x: u32) -> Self;
    /// Returns the lane values `f(0)`, `f(1)` and so on.
    fn from_fn(f: impl FnMut(usize) -> u32) -> Self;
    /// Returns the value of `lane`.
    fn lane(self, lane: usize) -> u32;
    /// Loads consecutive values from `at` on. Panics beyond the end.
    fn load(from: &[u32], at: usize) -> Self;
    /// Stores to consecutive places from `at` on. Panics beyond the end.
    fn store(self, to: &mut [u32], at: usize);
    /// Stores the lanes of `mask` side by side from `at` on. It may overwrite as many places as there are lanes. Panics
    /// if these reach beyond the end.
    fn pack(self, mask: Self::Mask, to: &mut [u32], at: usize);
    /// Addition modulo 2³².
    fn wrapping_add(self, other: Self) -> Self;
    /// Multiplication modulo 2³².
    fn wrapping_mul(self, other: Self) -> Self;
    /// Whether lanes are equal.
    fn equals(self, other: Self) -> Self::Mask;
    /// Reverses the order of the bits of each lane.
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        let swap = |x: Self, by: u32, low: u32| ((x >> by) & Self::splat(low)) | ((x & Self::splat(low)) << by);
        let x = swap(swap(swap(self, 1, 0x5555_5555), 2, 0x3333_3333), 4, 0x0f0f_0f0f);
        let x = swap(x, 8, 0x00ff_00ff);
        (x >> 16) | (x << 16)
    }
}

/// One `u64` per lane.
pub trait Long: Copy + Debug + BitXor<Output = Self> + Shr<u32, Output = Self> {
    /// Integers of half the width.
    type Int: Int;
    /// Numbers of half the width.
    type Float: Float<Int = Self::Int, Long = Self>;
    /// The same value in every lane.
    fn splat(x: u64) -> Self;
    /// Loads consecutive values from `at` on. Panics beyond the end.
    fn load(from: &[u64], at: usize) -> Self;
    /// Stores to consecutive places from `at` on. Panics beyond the end.
    fn store(self, to: &mut [u64], at: usize);
    /// See [`Int::pack`].
    fn pack(self, mask: <Self::Int as Int>::Mask, to: &mut [u64], at: usize);
    /// Zero-extends.
    fn from_int(x: Self::Int) -> Self;
    /// Addition modulo 2⁶⁴.
    fn wrapping_add(self, other: Self) -> Self;
    /// Multiplication by a constant modulo 2⁶⁴.
    fn wrapping_mul(self, factor: u64) -> Self;
    /// Returns the upper halves.
    fn high(self) -> Self::Int;
    /// Returns the lower halves.
    fn low(self) -> Self::Int;
}

/// One `f64` per lane, for half of the lanes of a [`Float`] or for its only one.
pub trait Double:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The same value in every lane.
    fn splat(x: f64) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The larger of two; `other` if one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; `other` if one is NaN.
    fn min(self, other: Self) -> Self;
    /// Returns 1 where `self` ≤ `other`, else 0.
    fn at_most(self, other: Self) -> Self;
}

/// One `f32` per lane.
pub trait Float:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Number of lanes: at most [`MOST_LANES`].
    const LANES: usize;
    /// Truth values of comparisons.
    type Mask: Mask;
    /// Integers of the same width.
    type Int: Int<Mask = Self::Mask>;
    /// Integers of twice the width.
    type Long: Long<Int = Self::Int, Float = Self>;
    /// Numbers of twice the width.
    type Double: Double;

    /// The same value in every lane.
    fn splat(x: f32) -> Self;
    /// Returns the lane values `f(0)`, `f(1)` and so on.
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self;
    /// Returns the value of `lane`.
    fn lane(self, lane: usize) -> f32;
    /// Loads consecutive values from `at` on. Panics beyond the end.
    fn load(from: &[f32], at: usize) -> Self;
    /// Stores to consecutive places from `at` on. Panics beyond the end.
    fn store(self, to: &mut [f32], at: usize);
    /// See [`Int::pack`].
    fn pack(self, mask: Self::Mask, to: &mut [f32], at: usize);
    /// Returns the columns of the rows `row(0)`, `row(1)` and so on, one row a lane.
    fn rows<'a>(row: impl FnMut(usize) -> &'a [f32; ROW]) -> [Self; ROW];
    /// Calls `row` with each lane and the row of its values in `columns`, the inverse of [`Float::rows`].
    fn to_rows(columns: [Self; ROW], row: impl FnMut(usize, [f32; ROW]));
    /// Returns `self` × `a` + `b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The larger of two; `other` if one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; `other` if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Whether lanes are equal; false for NaN.
    fn equals(self, other: Self) -> Self::Mask;
    /// Whether `self` < `other`; false for NaN.
    fn below(self, other: Self) -> Self::Mask;
    /// Whether `self` ≤ `other`; false for NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Whether `self` > `other`; false for NaN.
    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        other.below(self)
    }
    /// Returns `yes` in the lanes of `mask`, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Converts integers below 2³¹.
    fn from_int(x: Self::Int) -> Self;
    /// Truncates numbers from 0 to 2³¹, exclusive.
    fn to_int(self) -> Self::Int;
    /// Returns f(inputs), computed in f64 and rounded.
    fn in_double<const K: usize, const M: usize>(
        inputs: [Self; K],
        f: impl Fn([Self::Double; K]) -> [Self::Double; M],
    ) -> [Self; M];
    /// 1 / self.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }
    /// Returns the first `count` lanes as a mask.
    #[inline(always)]
    fn first(count: usize) -> Self::Mask {
        Self::Mask::from_bits(((1u64 << count.min(Self::LANES)) - 1) as u32)
    }
}

/// Overwrites `values` by f(0), f(1) and so on. It is always inlined, which `std::array::from_fn` and `map` are not:
/// calls of them take a tenth of the time of a kernel.
#[inline(always)]
pub fn filled<T: Copy, const N: usize>(mut values: [T; N], mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut i = 0;
    while i < N {
        values[i] = f(i);
        i += 1;
    }
    values
}

/// Calls `f` with the index of each bit that is set, the lowest first.
#[inline(always)]
pub fn for_each_bit(mut bits: u32, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[cfg(test)]
mod tests;
