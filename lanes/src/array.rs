//! Arrays of lanes in plain Rust, for processors without a family of their own and as a second opinion in tests. LLVM
//! makes vector instructions of most of it.

use crate::{Double, Float, Int, Long, Mask, ROW};
use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// `K` lanes of `f32`.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Array<const K: usize>([f32; K]);

/// `K` lanes of `u32`.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Ints<const K: usize>([u32; K]);

/// `K` lanes of `u64`.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Longs<const K: usize>([u64; K]);

/// `K` lanes of `f64`.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Doubles<const K: usize>([f64; K]);

/// `K` truth values.
#[derive(Debug, Clone, Copy)]
pub struct Masks<const K: usize>([bool; K]);

macro_rules! binary {
    ($t:ident, $($trait:ident $name:ident |$a:ident, $b:ident| $result:expr),*) => { $(
        impl<const K: usize> $trait for $t<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                $t(from_fn(|i| { let ($a, $b) = (self.0[i], other.0[i]); $result }))
            }
        }
    )* };
}
macro_rules! unary {
    ($t:ident, $trait:ident $name:ident $op:tt) => {
        impl<const K: usize> $trait for $t<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self) -> Self {
                $t(self.0.map(|x| $op x))
            }
        }
    };
}
macro_rules! shift {
    ($t:ident, $($trait:ident $name:ident $op:tt),*) => { $(
        impl<const K: usize> $trait<u32> for $t<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, by: u32) -> Self {
                $t(self.0.map(|x| x $op by))
            }
        }
    )* };
}
binary!(Array, Add add |a, b| a + b, Sub sub |a, b| a - b, Mul mul |a, b| a * b, Div div |a, b| a / b);
binary!(Doubles, Add add |a, b| a + b, Sub sub |a, b| a - b, Mul mul |a, b| a * b, Div div |a, b| a / b);
binary!(Ints, BitAnd bitand |a, b| a & b, BitOr bitor |a, b| a | b, BitXor bitxor |a, b| a ^ b);
binary!(Longs, BitXor bitxor |a, b| a ^ b);
binary!(Masks, BitAnd bitand |a, b| a & b, BitOr bitor |a, b| a | b);
unary!(Array, Neg neg -);
unary!(Doubles, Neg neg -);
unary!(Masks, Not not !);
shift!(Ints, Shl shl <<, Shr shr >>);
shift!(Longs, Shr shr >>);

macro_rules! memory {
    ($t:ty) => {
        #[inline(always)]
        fn load(from: &[$t], at: usize) -> Self {
            let from = &from[at..at + K];
            Self(from_fn(|i| from[i]))
        }
        #[inline(always)]
        fn store(self, to: &mut [$t], at: usize) {
            to[at..at + K].copy_from_slice(&self.0);
        }
        #[inline(always)]
        fn pack(self, mask: Masks<K>, to: &mut [$t], at: usize) {
            let (to, mut next) = (&mut to[at..at + K], 0);
            for lane in 0..K {
                to[next] = self.0[lane];
                next += usize::from(mask.0[lane]);
            }
        }
    };
}

impl<const K: usize> Mask for Masks<K> {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Masks(from_fn(|i| bits >> i & 1 != 0))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..K).fold(0, |bits, i| bits | u32::from(self.0[i]) << i)
    }
}

impl<const K: usize> Int for Ints<K> {
    type Mask = Masks<K>;
    #[inline(always)]
    fn splat(x: u32) -> Self {
        Ints([x; K])
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> u32) -> Self {
        Ints(from_fn(f))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> u32 {
        self.0[lane]
    }
    memory!(u32);
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        Ints(from_fn(|i| self.0[i].wrapping_add(other.0[i])))
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        Ints(from_fn(|i| self.0[i].wrapping_mul(other.0[i])))
    }
    #[inline(always)]
    fn equals(self, other: Self) -> Masks<K> {
        Masks(from_fn(|i| self.0[i] == other.0[i]))
    }
}

impl<const K: usize> Long for Longs<K> {
    type Int = Ints<K>;
    type Float = Array<K>;
    #[inline(always)]
    fn splat(x: u64) -> Self {
        Longs([x; K])
    }
    memory!(u64);
    #[inline(always)]
    fn from_int(x: Ints<K>) -> Self {
        Longs(x.0.map(u64::from))
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        Longs(from_fn(|i| self.0[i].wrapping_add(other.0[i])))
    }
    #[inline(always)]
    fn wrapping_mul(self, factor: u64) -> Self {
        Longs(self.0.map(|x| x.wrapping_mul(factor)))
    }
    #[inline(always)]
    fn high(self) -> Ints<K> {
        Ints(self.0.map(|x| (x >> 32) as u32))
    }
    #[inline(always)]
    fn low(self) -> Ints<K> {
        Ints(self.0.map(|x| x as u32))
    }
}

impl<const K: usize> Double for Doubles<K> {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Doubles([x; K])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Doubles(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Doubles(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Doubles(from_fn(|i| Double::max(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Doubles(from_fn(|i| Double::min(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Doubles(from_fn(|i| self.0[i].at_most(other.0[i])))
    }
}

impl<const K: usize> Float for Array<K> {
    const LANES: usize = K;
    type Mask = Masks<K>;
    type Int = Ints<K>;
    type Long = Longs<K>;
    type Double = Doubles<K>;
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Array([x; K])
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Array(from_fn(f))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.0[lane]
    }
    memory!(f32);
    #[inline(always)]
    fn rows<'a>(row: impl FnMut(usize) -> &'a [f32; ROW]) -> [Self; ROW] {
        let rows: [&[f32; ROW]; K] = from_fn(row);
        from_fn(|column| Array(rows.map(|row| row[column])))
    }
    #[inline(always)]
    fn to_rows(columns: [Self; ROW], mut row: impl FnMut(usize, [f32; ROW])) {
        (0..K).for_each(|lane| row(lane, from_fn(|column| columns[column].0[lane])));
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Array(from_fn(|i| self.0[i].mul_add(a.0[i], b.0[i])))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Array(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Array(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Array(from_fn(|i| Float::max(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Array(from_fn(|i| Float::min(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Array(from_fn(|i| self.0[i].copysign(sign.0[i])))
    }
    #[inline(always)]
    fn equals(self, other: Self) -> Masks<K> {
        Masks(from_fn(|i| Float::equals(self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn below(self, other: Self) -> Masks<K> {
        Masks(from_fn(|i| self.0[i] < other.0[i]))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Masks<K> {
        Masks(from_fn(|i| self.0[i] <= other.0[i]))
    }
    #[inline(always)]
    fn select(mask: Masks<K>, yes: Self, no: Self) -> Self {
        Array(from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    fn from_int(x: Ints<K>) -> Self {
        Array(x.0.map(|x| x as f32))
    }
    #[inline(always)]
    fn to_int(self) -> Ints<K> {
        Ints(self.0.map(|x| x as u32))
    }
    #[inline(always)]
    fn in_double<const I: usize, const O: usize>(
        inputs: [Self; I],
        f: impl Fn([Doubles<K>; I]) -> [Doubles<K>; O],
    ) -> [Self; O] {
        f(inputs.map(|x| Doubles(x.0.map(f64::from)))).map(|x| Array(x.0.map(|x| x as f32)))
    }
}
