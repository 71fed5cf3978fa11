//! Padded Owen-scrambled Sobol' points: every slot of every bounce uses the first one or two dimensions of the sequence
//! with its own scrambling [Burley20] and its own index shuffle. This is effective where few dimensions matter jointly.
//! At great depth the integrand is rough, and independent random numbers are cheaper.
//!
//! A replicate is one scrambling of the sequence. Passes of a replicate use its points in order. After a power of two
//! of passes each pair of dimensions is a scrambled (0, m, 2)-net, but not in between. Samples per pixel are therefore
//! rounded up to the replicates times a power of two.

use super::hash::mix64;
use super::{Address, IndependentSampler, Sampler, Slot, unit_f32};
use etendue_lanes::{Int, Long};

/// Bounces from this one on use independent random numbers. relMSE on the Cornell box is the same for 3, 4 and 8, and 8
/// % higher for 2.
const PADDED_BOUNCES: u32 = 4;

/// Point `index` of the sequence of one pixel in one replicate; in each lane of the pixel of its own.
#[derive(Debug, Clone, Copy)]
pub struct Sobol<L = u64> {
    /// Key of (seed, replicate, pixel).
    sequence: Address<L>,
    index: u32,
    deep: IndependentSampler<L>,
}

impl<L: Long> Sobol<L> {
    /// Returns point `index` of the sequence with key `sequence`.
    #[inline]
    pub fn new(sequence: Address<L>, index: u32) -> Self {
        let deep = IndependentSampler::new(sequence.with(L::splat(u64::from(index))));
        Sobol { sequence, index, deep }
    }

    /// Shuffles the index within its block [2ᵏ, 2ᵏ⁺¹), so that the first 2ᵐ points remain the first 2ᵐ points.
    ///
    /// [Burley20] shuffles by nested scrambling instead, which keeps neighbouring indices together in every slot. Two
    /// neighbours then fall into opposite halves of the domain in *every* slot at once. Integrands that are products
    /// over slots expose this correlation.
    #[inline]
    fn shuffled(&self, key: L) -> L::Int {
        if self.index < 2 {
            return L::Int::splat(self.index);
        }
        let bits = self.index.ilog2();
        let block = 1 << bits;
        permute(L::Int::splat(self.index ^ block), bits, key) | L::Int::splat(block)
    }
}

impl<L: Long> Sampler<L::Float> for Sobol<L> {
    #[inline]
    fn u1(&mut self, bounce: u32, slot: Slot) -> L::Float {
        if bounce >= PADDED_BOUNCES {
            return self.deep.u1(bounce, slot);
        }
        let keys = self.sequence.slot_bits(bounce, slot);
        let index = self.shuffled(keys);
        unit_f32(scramble_reversed(index, mix64(keys).low()).reverse_bits())
    }

    #[inline]
    fn u2(&mut self, bounce: u32, slot: Slot) -> [L::Float; 2] {
        if bounce >= PADDED_BOUNCES {
            return self.deep.u2(bounce, slot);
        }
        let keys = self.sequence.slot_bits(bounce, slot);
        let index = self.shuffled(keys);
        let scrambling = mix64(keys);
        let x = scramble_reversed(index, scrambling.high()).reverse_bits();
        let y = scramble_reversed(second_dimension_reversed(index), scrambling.low()).reverse_bits();
        [unit_f32(x), unit_f32(y)]
    }
}

/// Permutes the integers of `bits` > 0 bits: multiplication by odd integers, addition and xor-shifts are bijections.
#[inline]
fn permute<L: Long>(mut i: L::Int, bits: u32, key: L) -> L::Int {
    let mask = L::Int::splat((1u32 << bits) - 1);
    let shift = bits.div_ceil(2);
    for round in 0..3 {
        let k = (key >> (21 * round)).low();
        i = i.wrapping_mul((k << 1) | L::Int::splat(1)).wrapping_add(k >> 8) & mask;
        i = i ^ (i >> shift);
    }
    i
}

/// Nested uniform (Owen) scrambling of the bit-reversed integer `x`: each bit is flipped by a hash of the bits below
/// it. Multiplication by even integers and addition have this property [Burley20 §3]; constants as improved by N.
/// Vegdahl.
#[inline]
fn scramble_reversed<I: Int>(mut x: I, key: I) -> I {
    x = x ^ x.wrapping_mul(I::splat(0x3d20_adea));
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | I::splat(1));
    x = x ^ x.wrapping_mul(I::splat(0x0552_6c56));
    x ^ x.wrapping_mul(I::splat(0x53a2_2864))
}

/// Returns the second Sobol' coordinate of `index`, bit-reversed. Its generator matrix is Pascal's triangle modulo 2, a
/// product of five sparse factors.
#[inline]
fn second_dimension_reversed<I: Int>(index: I) -> I {
    let mut x = index ^ (index >> 16);
    x = x ^ ((x & I::splat(0xff00_ff00)) >> 8);
    x = x ^ ((x & I::splat(0xf0f0_f0f0)) >> 4);
    x = x ^ ((x & I::splat(0xcccc_cccc)) >> 2);
    x ^ ((x & I::splat(0xaaaa_aaaa)) >> 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second dimension by its direction numbers: v₁ = 2³¹, vᵢ₊₁ = vᵢ ⊕ (vᵢ ≫ 1).
    fn second_dimension(mut index: u32) -> u32 {
        let (mut x, mut v) = (0, 1u32 << 31);
        while index != 0 {
            if index & 1 == 1 {
                x ^= v;
            }
            v ^= v >> 1;
            index >>= 1;
        }
        x
    }

    #[test]
    fn the_fast_second_dimension_is_the_one_of_the_direction_numbers() {
        for i in (0..4096).chain((0..4096).map(|i| Address::new(1).bits(i) as u32)) {
            assert_eq!(second_dimension_reversed(i).reverse_bits(), second_dimension(i), "index {i}");
        }
    }

    /// Every elementary interval of area 2⁻ᵐ holds exactly one of the first 2ᵐ points, and one of the next 2ᵐ.
    #[test]
    fn the_first_and_the_next_power_of_two_points_are_nets() {
        let m = 8;
        for (sequence, block) in [(3, 0), (4, 0), (5, 1)] {
            let points: Vec<[f32; 2]> = (0..1u32 << m)
                .map(|i| Sobol::new(Address::new(sequence), (block << m) + i).u2(2, Slot::Direction))
                .collect();
            for k in 0..=m {
                let mut seen = vec![false; 1 << m];
                for [x, y] in &points {
                    let (cols, rows) = (1 << k, 1 << (m - k));
                    let cell = (x * cols as f32) as usize * rows + (y * rows as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true), "two points in one interval (k = {k})");
                }
            }
        }
    }

    #[test]
    fn slots_and_replicates_are_not_correlated() {
        let n = 1 << 12;
        let covariance = |f: &dyn Fn(u32) -> [f32; 2]| {
            (0..n).map(|i| f(i).map(|u| f64::from(u) - 0.5)).map(|[a, b]| a * b).sum::<f64>() / f64::from(n) * 12.0
        };
        let at = |s: u64, i: u32, slot| Sobol::new(Address::new(s), i).u2(0, slot)[0];
        // Under independence the correlation has a standard deviation of n^-1/2 = 0.0156; 5 σ at level 6e-7.
        let bound = 5.0 / f64::from(n).sqrt();
        assert!(covariance(&|i| [at(1, i, Slot::Direction), at(1, i, Slot::LightPoint)]).abs() < bound);
        assert!(covariance(&|i| [at(1, i, Slot::Direction), at(2, i, Slot::Direction)]).abs() < bound);
    }
}
