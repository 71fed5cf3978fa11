//! Independent uniform random numbers: the reference for all other samplers.

use super::{Address, Sampler, Slot, unit_f32};
use etendue_lanes::Long;

/// Hashes each address; all random numbers are independent.
#[derive(Debug, Clone, Copy)]
pub struct IndependentSampler<L = u64> {
    address: Address<L>,
}

impl<L: Long> IndependentSampler<L> {
    /// Returns the sampler of the sample with key `address`.
    #[inline]
    pub fn new(address: Address<L>) -> Self {
        IndependentSampler { address }
    }
}

impl<L: Long> Sampler<L::Float> for IndependentSampler<L> {
    #[inline]
    fn u1(&mut self, bounce: u32, slot: Slot) -> L::Float {
        unit_f32(self.address.slot_bits(bounce, slot).high())
    }

    #[inline]
    fn u2(&mut self, bounce: u32, slot: Slot) -> [L::Float; 2] {
        let bits = self.address.slot_bits(bounce, slot);
        [unit_f32(bits.high()), unit_f32(bits.low())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    /// χ² of pairs that differ in one part of the address only, each at level 1e-4: neighbours must not be correlated.
    #[test]
    fn numbers_of_neighbouring_addresses_are_uniform_together() {
        let of = |pass: u64, pixel: u64, bounce: u32| {
            IndependentSampler::new(Address::new(7).with(pass).with(pixel)).u1(bounce, Slot::Lobe)
        };
        type Pair = fn(u64) -> [(u64, u64, u32); 2];
        let pairs: [Pair; 3] = [
            |i| [(2 * i, 5, 0), (2 * i + 1, 5, 0)],
            |i| [(5, 2 * i, 0), (5, 2 * i + 1, 0)],
            |i| [(5, i, 0), (5, i, 1)],
        ];
        for pair in pairs {
            let mut cells = [0u32; 256];
            let n = 1 << 18;
            for i in 0..n {
                let [a, b] = pair(i).map(|(pass, pixel, bounce)| (of(pass, pixel, bounce) * 16.0) as usize);
                cells[a * 16 + b] += 1;
            }
            let expected = n as f64 / 256.0;
            let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
            let p = ChiSquared::new(255.0).expect("positive").sf(chi2);
            assert!(p > 1e-4, "chi2 {chi2}, p {p}");
        }
    }
}
