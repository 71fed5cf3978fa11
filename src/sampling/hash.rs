//! Counter-based random bits: a random number is a hash of its address, so that samplers have no state.

use super::{SLOTS, Slot};
use etendue_lanes::{Float, Int, Long};

/// SplitMix64 finaliser: a bijection in which every output bit depends on every input bit [Steele14].
#[inline]
pub fn mix64<L: Long>(mut x: L) -> L {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// 2⁶⁴ divided by the golden ratio, rounded to an odd integer; consecutive multiples are far apart.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Key of one random stream in each lane: a hash of its identifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Address<L = u64>(L);

impl Address {
    /// Returns the stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Address(mix64(seed.wrapping_add(GOLDEN)))
    }

    /// Returns this stream in every lane.
    #[inline]
    pub fn in_lanes<L: Long>(self) -> Address<L> {
        Address(L::splat(self.0))
    }
}

impl<L: Long> Address<L> {
    /// Returns the stream of this key: see [`Address::key`].
    #[inline]
    pub fn from_key(key: L) -> Self {
        Address(key)
    }

    /// Returns the key of the stream.
    #[inline]
    pub fn key(self) -> L {
        self.0
    }

    /// Returns sub-stream `i`.
    #[inline]
    pub fn with(self, i: L) -> Self {
        Address(mix64(self.0 ^ i.wrapping_mul(GOLDEN)).wrapping_add(L::splat(GOLDEN)))
    }

    /// Returns the `i`-th 64 random bits of this stream.
    #[inline]
    pub fn bits(self, i: u64) -> L {
        mix64(self.0.wrapping_add(L::splat(i.wrapping_mul(GOLDEN))))
    }

    /// Returns 64 random bits for `slot` at `bounce`.
    #[inline]
    pub fn slot_bits(self, bounce: u32, slot: Slot) -> L {
        self.bits(u64::from(bounce) * u64::from(SLOTS) + slot as u64)
    }
}

/// Returns the number in [0, 1) whose binary digits are the top 24 of `bits`.
#[inline]
pub fn unit_f32<I: Int, F: Float<Int = I>>(bits: I) -> F {
    const SCALE: f32 = 1.0 / (1u32 << 24) as f32;
    F::from_int(bits >> 8) * F::splat(SCALE)
}

/// Returns the number in [0, 1) whose binary digits are the top 53 of `bits`.
#[inline]
pub fn unit_f64(bits: u64) -> f64 {
    const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
    (bits >> 11) as f64 * SCALE
}
