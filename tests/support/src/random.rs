//! Random numbers for tests: each a pure function of a seed and an index, by the finaliser of SplitMix64 [Steele14].

use crate::deep;

/// A stream of independent uniform random numbers.
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Random { state: mix(seed) }
    }

    /// Uniform in [0, 1).
    pub fn f64(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.state) >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in [0, 1).
    pub fn f32(&mut self) -> f32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.state) >> 40) as f32 * 2f32.powi(-24)
    }

    /// Uniform in the unit cube of N dimensions.
    pub fn cube<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.f32())
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// `shallow` samples in everyday tests; a hundred times as many with `ETENDUE_TEST_DEEP=1`.
pub fn samples(shallow: u32) -> u32 {
    if deep() { 100 * shallow } else { shallow }
}
