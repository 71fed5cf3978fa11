//! Eight lanes in AVX2 registers.

// Calls of instructions that every processor has for which this module is compiled; nothing else is unsafe here.
#![allow(unsafe_code)]

use crate::{Double, Float, Int, Long, Mask, ROW};
use bytemuck::cast;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// Eight lanes of `f32`.
#[derive(Debug, Clone, Copy)]
pub struct Avx8(__m256);

/// Eight lanes of `u32`.
#[derive(Debug, Clone, Copy)]
pub struct Ints(__m256i);

/// Eight lanes of `u64`: the lower and the upper four.
#[derive(Debug, Clone, Copy)]
pub struct Longs(__m256i, __m256i);

/// Four lanes of `f64`.
#[derive(Debug, Clone, Copy)]
pub struct Doubles(__m256d);

/// Eight truth values: all bits of a lane, or none.
#[derive(Debug, Clone, Copy)]
pub struct Masks(__m256);

/// Calls an instruction. Its arguments are evaluated outside of the unsafe block.
macro_rules! avx {
    ($name:ident $(::<$imm:literal>)? ($a:expr)) => {{
        let a = $a;
        // SAFETY: this module is compiled only where every processor has AVX2 and FMA; values in, value out.
        unsafe { $name $(::<$imm>)? (a) }
    }};
    ($name:ident $(::<$imm:ident>)? $(::<$lit:literal>)? ($a:expr, $b:expr)) => {{
        let (a, b) = ($a, $b);
        // SAFETY: as above.
        unsafe { $name $(::<$imm>)? $(::<$lit>)? (a, b) }
    }};
    ($name:ident ($a:expr, $b:expr, $c:expr)) => {{
        let (a, b, c) = ($a, $b, $c);
        // SAFETY: as above.
        unsafe { $name(a, b, c) }
    }};
}

macro_rules! binary {
    ($t:ident, $($trait:ident $name:ident $instruction:ident),*) => { $(
        impl $trait for $t {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                $t(avx!($instruction(self.0, other.0)))
            }
        }
    )* };
}
binary!(Avx8, Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);
binary!(Doubles, Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);
binary!(Ints, BitAnd bitand _mm256_and_si256, BitOr bitor _mm256_or_si256, BitXor bitxor _mm256_xor_si256);
binary!(Masks, BitAnd bitand _mm256_and_ps, BitOr bitor _mm256_or_ps);

impl Neg for Avx8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Avx8(avx!(_mm256_xor_ps(self.0, cast([-0.0f32; 8]))))
    }
}

impl Neg for Doubles {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Doubles(avx!(_mm256_xor_pd(self.0, cast([-0.0f64; 4]))))
    }
}

impl Not for Masks {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Masks(avx!(_mm256_xor_ps(self.0, cast([u32::MAX; 8]))))
    }
}

impl Shl<u32> for Ints {
    type Output = Self;
    #[inline(always)]
    fn shl(self, by: u32) -> Self {
        Ints(avx!(_mm256_sll_epi32(self.0, count(by))))
    }
}

impl Shr<u32> for Ints {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Ints(avx!(_mm256_srl_epi32(self.0, count(by))))
    }
}

impl BitXor for Longs {
    type Output = Self;
    #[inline(always)]
    fn bitxor(self, other: Self) -> Self {
        Longs(avx!(_mm256_xor_si256(self.0, other.0)), avx!(_mm256_xor_si256(self.1, other.1)))
    }
}

impl Shr<u32> for Longs {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: u32) -> Self {
        Longs(avx!(_mm256_srl_epi64(self.0, count(by))), avx!(_mm256_srl_epi64(self.1, count(by))))
    }
}

/// Returns a shift count for all lanes; a constant one becomes part of the instruction.
#[inline(always)]
fn count(by: u32) -> __m128i {
    cast([u64::from(by), 0])
}

/// By mask: the lanes that are set, side by side, one byte each; then the others' numbers do not matter.
static PACKED: [u64; 256] = {
    let mut packed = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut next) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                packed[mask] |= (lane as u64) << (8 * next);
                next += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    packed
};

/// By mask of four 64-bit lanes: as [`PACKED`], in 32-bit halves.
static PACKED_LONGS: [u64; 16] = {
    let mut packed = [0; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut lane, mut next) = (0, 0);
        while lane < 4 {
            if mask >> lane & 1 == 1 {
                packed[mask] |= ((2 * lane) as u64 | ((2 * lane + 1) as u64) << 8) << (16 * next);
                next += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    packed
};

/// Returns eight values from `at` on.
#[inline(always)]
fn eight<T: Copy + Default>(from: &[T], at: usize) -> [T; 8] {
    let mut values = [T::default(); 8];
    values.copy_from_slice(&from[at..at + 8]);
    values
}

#[inline(always)]
fn order(bytes: u64) -> __m256i {
    avx!(_mm256_cvtepu8_epi32(cast::<[u64; 2], __m128i>([bytes, 0])))
}

#[inline(always)]
fn permuted(x: __m256i, bytes: u64) -> __m256i {
    avx!(_mm256_permutevar8x32_epi32(x, order(bytes)))
}

impl Mask for Masks {
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let each = cast::<[u32; 8], __m256i>([1, 2, 4, 8, 16, 32, 64, 128]);
        let bits = avx!(_mm256_and_si256(avx!(_mm256_set1_epi32(bits as i32)), each));
        Masks(cast(avx!(_mm256_cmpeq_epi32(bits, each))))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        avx!(_mm256_movemask_ps(self.0)) as u32
    }
}

impl Int for Ints {
    type Mask = Masks;
    #[inline(always)]
    fn splat(x: u32) -> Self {
        Ints(avx!(_mm256_set1_epi32(x as i32)))
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> u32) -> Self {
        Ints(cast(crate::filled([0u32; 8], f)))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> u32 {
        cast::<__m256i, [u32; 8]>(self.0)[lane]
    }
    #[inline(always)]
    fn load(from: &[u32], at: usize) -> Self {
        Ints(cast(eight(from, at)))
    }
    #[inline(always)]
    fn store(self, to: &mut [u32], at: usize) {
        to[at..at + 8].copy_from_slice(&cast::<__m256i, [u32; 8]>(self.0));
    }
    #[inline(always)]
    fn pack(self, mask: Masks, to: &mut [u32], at: usize) {
        Ints(permuted(self.0, PACKED[mask.bits() as usize])).store(to, at);
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        Ints(avx!(_mm256_add_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        Ints(avx!(_mm256_mullo_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn equals(self, other: Self) -> Masks {
        Masks(cast(avx!(_mm256_cmpeq_epi32(self.0, other.0))))
    }
    /// Bytes are reversed by one shuffle, and the bits within them by looking up both of their halves.
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        const HALVES: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
        const BYTES: [u8; 16] = [3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12];
        let twice = |table: [u8; 16]| cast::<[[u8; 16]; 2], __m256i>([table; 2]);
        let low = Ints::splat(0x0f0f_0f0f);
        let swapped = Ints(avx!(_mm256_shuffle_epi8(self.0, twice(BYTES))));
        let looked = |halves: Ints, table| Ints(avx!(_mm256_shuffle_epi8(table, halves.0)));
        let upper = looked(swapped & low, twice(HALVES.map(|half| half << 4)));
        looked((swapped >> 4) & low, twice(HALVES)) | upper
    }
}

/// Multiplies modulo 2⁶⁴ by products of halves.
#[inline(always)]
fn multiplied(x: __m256i, factor: u64) -> __m256i {
    let (low, high) =
        (avx!(_mm256_set1_epi64x((factor & 0xffff_ffff) as i64)), avx!(_mm256_set1_epi64x((factor >> 32) as i64)));
    let upper = avx!(_mm256_srl_epi64(x, count(32)));
    let cross = avx!(_mm256_add_epi64(avx!(_mm256_mul_epu32(x, high)), avx!(_mm256_mul_epu32(upper, low))));
    avx!(_mm256_add_epi64(avx!(_mm256_mul_epu32(x, low)), avx!(_mm256_sll_epi64(cross, count(32)))))
}

impl Long for Longs {
    type Int = Ints;
    type Float = Avx8;
    #[inline(always)]
    fn splat(x: u64) -> Self {
        let x = avx!(_mm256_set1_epi64x(x as i64));
        Longs(x, x)
    }
    #[inline(always)]
    fn load(from: &[u64], at: usize) -> Self {
        let [low, high] = cast::<[u64; 8], [__m256i; 2]>(eight(from, at));
        Longs(low, high)
    }
    #[inline(always)]
    fn store(self, to: &mut [u64], at: usize) {
        let (low, high) = (cast::<__m256i, [u64; 4]>(self.0), cast::<__m256i, [u64; 4]>(self.1));
        let to = &mut to[at..at + 8];
        to[..4].copy_from_slice(&low);
        to[4..].copy_from_slice(&high);
    }
    #[inline(always)]
    fn pack(self, mask: Masks, to: &mut [u64], at: usize) {
        let bits = mask.bits() as usize;
        let to = &mut to[at..at + 8];
        let low = permuted(self.0, PACKED_LONGS[bits & 15]);
        let high = permuted(self.1, PACKED_LONGS[bits >> 4]);
        to[..4].copy_from_slice(&cast::<__m256i, [u64; 4]>(low));
        let next = (bits & 15).count_ones() as usize;
        to[next..next + 4].copy_from_slice(&cast::<__m256i, [u64; 4]>(high));
    }
    #[inline(always)]
    fn from_int(x: Ints) -> Self {
        let low = avx!(_mm256_castsi256_si128(x.0));
        let high = avx!(_mm256_extracti128_si256::<1>(x.0));
        Longs(avx!(_mm256_cvtepu32_epi64(low)), avx!(_mm256_cvtepu32_epi64(high)))
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        Longs(avx!(_mm256_add_epi64(self.0, other.0)), avx!(_mm256_add_epi64(self.1, other.1)))
    }
    #[inline(always)]
    fn wrapping_mul(self, factor: u64) -> Self {
        Longs(multiplied(self.0, factor), multiplied(self.1, factor))
    }
    #[inline(always)]
    fn high(self) -> Ints {
        let both = avx!(_mm256_shuffle_ps::<0xdd>(cast::<__m256i, __m256>(self.0), cast::<__m256i, __m256>(self.1)));
        Ints(avx!(_mm256_permute4x64_epi64::<0xd8>(cast::<__m256, __m256i>(both))))
    }
    #[inline(always)]
    fn low(self) -> Ints {
        let both = avx!(_mm256_shuffle_ps::<0x88>(cast::<__m256i, __m256>(self.0), cast::<__m256i, __m256>(self.1)));
        Ints(avx!(_mm256_permute4x64_epi64::<0xd8>(cast::<__m256, __m256i>(both))))
    }
}

impl Double for Doubles {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Doubles(avx!(_mm256_set1_pd(x)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Doubles(avx!(_mm256_sqrt_pd(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Doubles(avx!(_mm256_andnot_pd(cast::<[f64; 4], __m256d>([-0.0; 4]), self.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Doubles(avx!(_mm256_max_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Doubles(avx!(_mm256_min_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        let mask = avx!(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0));
        Doubles(avx!(_mm256_and_pd(mask, cast::<[f64; 4], __m256d>([1.0; 4]))))
    }
}

impl Float for Avx8 {
    const LANES: usize = 8;
    type Mask = Masks;
    type Int = Ints;
    type Long = Longs;
    type Double = Doubles;
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Avx8(avx!(_mm256_set1_ps(x)))
    }
    #[inline(always)]
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
        Avx8(cast(crate::filled([0.0f32; 8], f)))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        cast::<__m256, [f32; 8]>(self.0)[lane]
    }
    #[inline(always)]
    fn load(from: &[f32], at: usize) -> Self {
        Avx8(cast(eight(from, at)))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32], at: usize) {
        to[at..at + 8].copy_from_slice(&cast::<__m256, [f32; 8]>(self.0));
    }
    #[inline(always)]
    fn pack(self, mask: Masks, to: &mut [f32], at: usize) {
        let packed = permuted(cast(self.0), PACKED[mask.bits() as usize]);
        Avx8(cast(packed)).store(to, at);
    }
    #[inline(always)]
    fn rows<'a>(mut row: impl FnMut(usize) -> &'a [f32; ROW]) -> [Self; ROW] {
        let zero = Avx8::splat(0.0);
        let columns = transposed(crate::filled([zero.0; 8], |lane| Avx8(cast(*row(lane))).0));
        crate::filled([zero; 8], |column| Avx8(columns[column]))
    }
    #[inline(always)]
    fn to_rows(columns: [Self; ROW], mut row: impl FnMut(usize, [f32; ROW])) {
        let rows = transposed(crate::filled([columns[0].0; 8], |column| columns[column].0));
        for (lane, values) in rows.into_iter().enumerate() {
            row(lane, cast(values));
        }
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Avx8(avx!(_mm256_fmadd_ps(self.0, a.0, b.0)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Avx8(avx!(_mm256_sqrt_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Avx8(avx!(_mm256_andnot_ps(cast::<[f32; 8], __m256>([-0.0; 8]), self.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Avx8(avx!(_mm256_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Avx8(avx!(_mm256_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let bits = avx!(_mm256_and_ps(cast::<[f32; 8], __m256>([-0.0; 8]), sign.0));
        Avx8(avx!(_mm256_or_ps(self.abs().0, bits)))
    }
    #[inline(always)]
    fn equals(self, other: Self) -> Masks {
        Masks(avx!(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn below(self, other: Self) -> Masks {
        Masks(avx!(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Masks {
        Masks(avx!(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn select(mask: Masks, yes: Self, no: Self) -> Self {
        Avx8(avx!(_mm256_blendv_ps(no.0, yes.0, mask.0)))
    }
    #[inline(always)]
    fn from_int(x: Ints) -> Self {
        Avx8(avx!(_mm256_cvtepi32_ps(x.0)))
    }
    #[inline(always)]
    fn to_int(self) -> Ints {
        Ints(avx!(_mm256_cvttps_epi32(self.0)))
    }
    #[inline(always)]
    fn in_double<const K: usize, const M: usize>(
        inputs: [Self; K],
        f: impl Fn([Doubles; K]) -> [Doubles; M],
    ) -> [Self; M] {
        let zero = Doubles::splat(0.0);
        let low =
            f(crate::filled([zero; K], |i| Doubles(avx!(_mm256_cvtps_pd(avx!(_mm256_castps256_ps128(inputs[i].0)))))));
        let high = f(crate::filled([zero; K], |i| {
            Doubles(avx!(_mm256_cvtps_pd(avx!(_mm256_extractf128_ps::<1>(inputs[i].0)))))
        }));
        let rounded = |x: Doubles| avx!(_mm256_cvtpd_ps(x.0));
        crate::filled([Avx8::splat(0.0); M], |i| Avx8(avx!(_mm256_set_m128(rounded(high[i]), rounded(low[i])))))
    }
}

/// Transposes eight rows of eight.
#[inline(always)]
fn transposed(rows: [__m256; 8]) -> [__m256; 8] {
    let [a, b, c, d, e, f, g, h] = rows;
    let [ab0, ab1] = interleaved(a, b);
    let [cd0, cd1] = interleaved(c, d);
    let [ef0, ef1] = interleaved(e, f);
    let [gh0, gh1] = interleaved(g, h);
    let [a0, a1, a2, a3] = joined([ab0, ab1], [cd0, cd1]);
    let [e0, e1, e2, e3] = joined([ef0, ef1], [gh0, gh1]);
    let lower = |a, b| avx!(_mm256_permute2f128_ps::<0x20>(a, b));
    let upper = |a, b| avx!(_mm256_permute2f128_ps::<0x31>(a, b));
    [
        lower(a0, e0),
        lower(a1, e1),
        lower(a2, e2),
        lower(a3, e3),
        upper(a0, e0),
        upper(a1, e1),
        upper(a2, e2),
        upper(a3, e3),
    ]
}

#[inline(always)]
fn interleaved(a: __m256, b: __m256) -> [__m256; 2] {
    [avx!(_mm256_unpacklo_ps(a, b)), avx!(_mm256_unpackhi_ps(a, b))]
}

/// Columns of four rows, in both halves.
#[inline(always)]
fn joined([a0, a1]: [__m256; 2], [c0, c1]: [__m256; 2]) -> [__m256; 4] {
    let low = |a, c| avx!(_mm256_shuffle_ps::<0x44>(a, c));
    let high = |a, c| avx!(_mm256_shuffle_ps::<0xee>(a, c));
    [low(a0, c0), high(a0, c0), low(a1, c1), high(a1, c1)]
}
