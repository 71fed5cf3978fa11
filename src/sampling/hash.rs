//! Counter-based random bits: a number is a hash of its address, so there is no state to share or to lose.

use super::{SLOTS, Slot};

/// The finaliser of SplitMix64: a bijection whose output bits each depend on every input bit [Steele14].
#[inline]
pub fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// 2⁶⁴ divided by the golden ratio, odd: consecutive multiples are far apart.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The identity of one random stream: whatever is hashed into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Address(u64);

impl Address {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Address(mix64(seed.wrapping_add(GOLDEN)))
    }

    /// The sub-stream number `i`.
    #[inline]
    pub fn with(self, i: u64) -> Self {
        Address(mix64(self.0 ^ i.wrapping_mul(GOLDEN)).wrapping_add(GOLDEN))
    }

    /// 64 random bits, the `i`-th of this stream.
    #[inline]
    pub fn bits(self, i: u64) -> u64 {
        mix64(self.0.wrapping_add(i.wrapping_mul(GOLDEN)))
    }

    /// 64 random bits for `slot` at `bounce`.
    #[inline]
    pub fn slot_bits(self, bounce: u32, slot: Slot) -> u64 {
        self.bits(u64::from(bounce) * u64::from(SLOTS) + slot as u64)
    }
}

/// The number in [0, 1) whose binary digits are the top 24 of `bits`.
#[inline]
pub fn unit_f32(bits: u32) -> f32 {
    const SCALE: f32 = 1.0 / (1u32 << 24) as f32;
    (bits >> 8) as f32 * SCALE
}

/// The number in [0, 1) whose binary digits are the top 53 of `bits`.
#[inline]
pub fn unit_f64(bits: u64) -> f64 {
    const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
    (bits >> 11) as f64 * SCALE
}
