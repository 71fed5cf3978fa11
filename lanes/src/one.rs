//! One lane: the numbers themselves.

use crate::{Double, Float, Int, Long, Mask, ROW};

impl Mask for bool {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits & 1 != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

macro_rules! memory {
    ($t:ty) => {
        #[inline(always)]
        fn load(from: &[$t], at: usize) -> Self {
            from[at]
        }
        #[inline(always)]
        fn store(self, to: &mut [$t], at: usize) {
            to[at] = self;
        }
        #[inline(always)]
        fn pack(self, mask: bool, to: &mut [$t], at: usize) {
            if mask {
                to[at] = self;
            }
        }
    };
}

macro_rules! functions {
    ($t:ident) => {
        #[inline(always)]
        fn sqrt(self) -> Self {
            $t::sqrt(self)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            $t::abs(self)
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            if self > other { self } else { other }
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            if self < other { self } else { other }
        }
    };
}

impl Int for u32 {
    type Mask = bool;
    #[inline(always)]
    fn splat(x: u32) -> Self {
        x
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
        f(0)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> u32 {
        self
    }
    memory!(u32);
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        u32::wrapping_add(self, other)
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        u32::wrapping_mul(self, other)
    }
    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        u32::reverse_bits(self)
    }
}

impl Long for u64 {
    type Int = u32;
    type Float = f32;
    #[inline(always)]
    fn splat(x: u64) -> Self {
        x
    }
    memory!(u64);
    #[inline(always)]
    fn from_int(x: u32) -> Self {
        u64::from(x)
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        u64::wrapping_add(self, other)
    }
    #[inline(always)]
    fn wrapping_mul(self, factor: u64) -> Self {
        u64::wrapping_mul(self, factor)
    }
    #[inline(always)]
    fn high(self) -> u32 {
        (self >> 32) as u32
    }
    #[inline(always)]
    fn low(self) -> u32 {
        self as u32
    }
}

impl Double for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    functions!(f64);
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        f64::from(u8::from(self <= other))
    }
}

impl Float for f32 {
    const LANES: usize = 1;
    type Mask = bool;
    type Int = u32;
    type Long = u64;
    type Double = f64;
    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        f(0)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self
    }
    memory!(f32);
    #[inline(always)]
    fn rows<'a>(mut row: impl FnMut(usize) -> &'a [f32; ROW]) -> [Self; ROW] {
        *row(0)
    }
    #[inline(always)]
    fn to_rows(columns: [Self; ROW], mut row: impl FnMut(usize, [f32; ROW])) {
        row(0, columns);
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f32::mul_add(self, a, b)
    }
    functions!(f32);
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }
    #[inline(always)]
    #[allow(clippy::float_cmp)] // what it is for
    fn equals(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn from_int(x: u32) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_int(self) -> u32 {
        self as u32
    }
    #[inline(always)]
    fn in_double<const K: usize, const M: usize>(inputs: [Self; K], f: impl Fn([f64; K]) -> [f64; M]) -> [Self; M] {
        let wide = f(crate::filled([0.0; K], |i| f64::from(inputs[i])));
        crate::filled([0.0; M], |i| wide[i] as f32)
    }
}
