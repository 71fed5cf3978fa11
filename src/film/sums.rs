//! Exact sums of quantised values: one i64 each, and a sparse table of overflow. The pair (low 64 bits as i64, rest in
//! units of 2⁶⁴) is unique for each integer. Equal sums are therefore equal bit for bit, whatever the order of
//! additions and merges.

use rayon::prelude::*;
use std::collections::BTreeMap;

/// Values of 2¹⁸⁰ units and above are dropped. Below this limit 2¹⁰ values fit a sum.
const LIMIT: f64 = f64::from_bits((1023 + 180) << 52);
/// Number of values in a parallel chunk.
const PART: usize = 1 << 16;
const TWO_32: f64 = 4_294_967_296.0;
const TWO_62: f64 = 4_611_686_018_427_387_904.0;
const TWO_64: f64 = 18_446_744_073_709_551_616.0;

/// An array of exact sums.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Sums {
    low: Vec<i64>,
    /// By index; in units of 2⁶⁴; never zero.
    high: BTreeMap<u64, i128>,
}

/// Overflow of the i64 sums in a pass: carries by index in units of 2⁶⁴, and the number of dropped values.
#[derive(Debug, Default)]
pub(crate) struct Spill {
    /// (index, carry).
    pub(crate) carries: Vec<(u64, i128)>,
    /// Values that were not finite or beyond the limit.
    pub(crate) dropped: u64,
}

impl Spill {
    /// Concatenates the carries and adds the counts.
    pub(crate) fn join(mut self, mut other: Spill) -> Spill {
        self.carries.append(&mut other.carries);
        Spill { carries: self.carries, dropped: self.dropped + other.dropped }
    }
}

impl Sums {
    /// Returns `length` zeros.
    pub(crate) fn new(length: usize) -> Self {
        Sums { low: vec![0; length], high: BTreeMap::new() }
    }

    /// Returns the low 64 bits of every sum.
    pub(crate) fn low(&self) -> &[i64] {
        &self.low
    }

    /// Returns the low 64 bits of every sum, for [`add_rounded`] and [`add_all`].
    pub(crate) fn low_mut(&mut self) -> &mut [i64] {
        &mut self.low
    }

    /// Returns the part above 64 bits, by index, in units of 2⁶⁴.
    pub(crate) fn high(&self) -> &BTreeMap<u64, i128> {
        &self.high
    }

    /// Adds the carries of additions to [`Sums::low_mut`].
    pub(crate) fn carry(&mut self, carries: impl IntoIterator<Item = (u64, i128)>) {
        for (index, carry) in carries {
            let high = self.high.entry(index).or_insert(0);
            *high += carry;
            if *high == 0 {
                self.high.remove(&index);
            }
        }
    }

    /// Adds all sums of another array of the same length.
    pub(crate) fn merge(&mut self, other: &Sums) {
        let parts = self.low.par_chunks_mut(PART).zip(other.low.par_chunks(PART)).enumerate();
        let carries: Vec<_> =
            parts.flat_map_iter(|(part, (sums, values))| add_all(sums, values, part * PART)).collect();
        self.carry(carries);
        self.carry(other.high.iter().map(|(&index, &high)| (index, high)));
    }

    /// Returns the f64 nearest to one sum, in units.
    pub(crate) fn value(&self, index: usize) -> f64 {
        nearest(i128::from(self.low[index]), self.above(index))
    }

    /// Returns the f64 nearest to the exact total of several sums.
    pub(crate) fn total<'a>(parts: impl Iterator<Item = (&'a Sums, usize)>) -> f64 {
        let (low, high) = parts.fold((0, 0), |(low, high), (s, i)| (low + i128::from(s.low[i]), high + s.above(i)));
        nearest(low, high)
    }

    fn above(&self, index: usize) -> i128 {
        if self.high.is_empty() { 0 } else { self.high.get(&(index as u64)).copied().unwrap_or(0) }
    }
}

/// Returns `low` + 2⁶⁴ `high` as f64, a function of the value alone: the nearest f64 if the value fits an i128.
fn nearest(low: i128, high: i128) -> f64 {
    match high.checked_mul(1 << 64).and_then(|shifted| shifted.checked_add(low)) {
        Some(number) => number as f64,
        None => {
            let carry = (low - i128::from(low as i64)) >> 64;
            (high + carry) as f64 * TWO_64 + (low as i64) as f64
        }
    }
}

/// Adds `values`, the low 64 bits of other sums, to `sums`, of which the first has index `first`. Returns the carries
/// by index.
pub(crate) fn add_all(sums: &mut [i64], values: &[i64], first: usize) -> Vec<(u64, i128)> {
    let pairs = sums.iter_mut().zip(values).zip(first as u64..);
    let carries = pairs.map(|((sum, &value), index)| (index, add(sum, value)));
    carries.filter(|&(_, carry)| carry != 0).collect()
}

/// Adds `value` and returns the carry.
#[inline]
fn add(sum: &mut i64, value: i64) -> i128 {
    let (wrapped, overflows) = sum.overflowing_add(value);
    *sum = wrapped;
    if overflows { i128::from(value.signum()) } else { 0 }
}

/// Adds a value, given as `scaled` = value · 2³² / unit, rounded stochastically to a whole number of units. The upper
/// 32 bits of `hash` are the random number. The bias is below 2⁻³² of a unit. Carries and dropped values go to `spill`.
#[inline]
pub(crate) fn add_rounded(sum: &mut i64, scaled: f64, hash: u64, index: u64, spill: &mut Spill) {
    if scaled.abs() < TWO_62 {
        // Truncating an f32 below 2⁻⁸ units loses less than 2⁻³² of a unit; then floor(x + u).
        let fraction = (hash >> 32) as i64;
        let whole = (scaled as i64 + fraction) >> 32;
        let carry = add(sum, whole);
        if carry != 0 {
            spill.carries.push((index, carry));
        }
    } else {
        add_large(sum, scaled / TWO_32, index, spill);
    }
}

/// Adds a value of at least 2³⁰ units. An f32 of that size is already a whole number of units.
#[cold]
fn add_large(sum: &mut i64, units: f64, index: u64, spill: &mut Spill) {
    if units.is_nan() || units.abs() >= LIMIT {
        spill.dropped += 1;
        return;
    }
    let high = (units / TWO_64).floor();
    // In [0, 2⁶⁴) and exact: both have the 24 significant bits of an f32.
    let low = (units - high * TWO_64) as u64 as i64;
    let carry = high as i128 + i128::from(low < 0) + add(sum, low);
    if carry != 0 {
        spill.carries.push((index, carry));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    fn add_all(values: &[f64], random: &mut Random) -> Sums {
        let (mut sums, mut spill) = (Sums::new(1), Spill::default());
        for value in values {
            add_rounded(&mut sums.low[0], value * TWO_32, random.bits(), 0, &mut spill);
        }
        sums.carry(spill.carries);
        sums
    }

    #[test]
    fn huge_values_are_exact_and_cancel() {
        let huge = [f64::from(f32::MAX), TWO_62 * 2.0, TWO_64, -TWO_64, 3.0 * TWO_62, -5.0 * TWO_62, 7.0];
        let sums = add_all(&huge, &mut Random::new(1));
        let expected = nearest(7, (f64::from(f32::MAX) / TWO_64) as i128);
        assert!((sums.value(0) - expected).abs() < f64::EPSILON * expected);
        let back: Vec<f64> = huge.iter().chain(&huge.map(|x| -x)).copied().collect();
        assert_eq!(add_all(&back, &mut Random::new(1)), Sums::new(1));
    }

    /// Integers of any size, added in any order and split in any way, give the same two parts.
    #[test]
    fn sums_are_independent_of_order_and_grouping() {
        let mut random = Random::new(2);
        let mut values: Vec<f64> = (0..400)
            .map(|_| ((random.normal() * 1e6).round()) * 2_f64.powi((random.uniform() * 100.0) as i32))
            .collect();
        values.extend([TWO_62 * 1.5; 9]);
        let forward = add_all(&values, &mut Random::new(3));
        let mut merged = add_all(&values[..150], &mut Random::new(4));
        merged.merge(&add_all(&values[150..], &mut Random::new(5)));
        values.reverse();
        assert_eq!(add_all(&values, &mut Random::new(6)), forward);
        assert_eq!(merged, forward);
        assert!(!forward.high.is_empty());
    }

    /// 10⁶ values of ±0.3 units: the rounded sum is binomial, so its mean is within 5 σ (level 6e-7).
    #[test]
    fn rounding_of_dim_values_is_unbiased() {
        let n = 1_000_000;
        for value in [0.3, -0.3, 1e-4] {
            let mean = add_all(&vec![value; n], &mut Random::new(7)).value(0) / n as f64;
            let p = value.rem_euclid(1.0);
            assert!((mean - value).abs() < 5.0 * (p * (1.0 - p) / n as f64).sqrt(), "{value}: {mean}");
        }
    }

    #[test]
    fn values_outside_the_fixed_point_range_are_dropped_and_counted() {
        let (mut sum, mut spill) = (0, Spill::default());
        for value in [f64::NAN, f64::INFINITY, -LIMIT * TWO_32] {
            add_rounded(&mut sum, value, 0, 0, &mut spill);
        }
        assert_eq!((sum, spill.dropped, spill.carries.len()), (0, 3, 0));
    }
}
