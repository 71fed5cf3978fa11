//! The random numbers of one step of a chain.

use crate::sampling::{Address, unit_f64};

/// Independent numbers, one after the other, from an address: those of another step do not move if this one takes more.
#[derive(Debug, Clone)]
pub struct Numbers {
    address: Address,
    taken: u64,
}

impl Numbers {
    /// The numbers that `address` has.
    pub fn new(address: Address) -> Self {
        Numbers { address, taken: 0 }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.taken += 1;
        self.address.bits(self.taken)
    }

    /// A number in [0, 1).
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        unit_f64(self.bits())
    }

    /// A whole number below `n`, which is not 0.
    #[inline]
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }

    /// An index, each with the probability of its share in `weights`; `None` if they sum to nothing.
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

    /// A stream of its own for something that addresses its numbers.
    #[inline]
    pub fn address(&mut self) -> Address {
        Address::new(self.bits())
    }
}
