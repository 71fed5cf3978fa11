//! Random numbers of one step of a chain.

use crate::sampling::{Address, unit_f64};

/// Sequence of independent random numbers at an address. The number of draws in one step does not affect other steps.
#[derive(Debug, Clone)]
pub struct Numbers {
    address: Address,
    taken: u64,
}

impl Numbers {
    /// Creates the sequence of `address`.
    pub fn new(address: Address) -> Self {
        Numbers { address, taken: 0 }
    }

    /// Returns 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.taken += 1;
        self.address.bits(self.taken)
    }

    /// Returns a uniform random number in [0, 1).
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        unit_f64(self.bits())
    }

    /// Returns a uniform random integer below `n`, which is not 0.
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }

    /// Samples an index with probability proportional to its weight; `None` if the weights sum to zero.
    #[inline]
    pub fn choose(&mut self, weights: impl Iterator<Item = f64> + Clone) -> Option<usize> {
        let total: f64 = weights.clone().sum();
        let mut left = self.uniform() * total;
        let mut chosen = None;
        for (i, weight) in weights.enumerate().filter(|&(_, weight)| weight > 0.0) {
            chosen = Some(i);
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
        chosen
    }

    /// Returns the address of a separate random stream.
    #[inline]
    pub fn address(&mut self) -> Address {
        Address::new(self.bits())
    }
}
