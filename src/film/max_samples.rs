//! The largest sample of every pixel with its pass. Fireflies can thus be traced again, and the tail of the samples
//! estimated. The result does not depend on the order of passes and merges.

use rayon::prelude::*;

/// The largest sample of each pixel, packed so that the larger integer is kept. The upper half holds the f32 bits,
/// which order like the value since it is not negative. The lower half holds 2³² − 1 − pass, so that the earliest of
/// equal samples is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Peaks(Vec<u64>);

/// The largest sample of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Peak {
    /// Mean of the colour channels, above zero.
    pub(crate) value: f32,
    /// Pass of the sample; 2³² − 1 stands for that pass and all later ones.
    pub(crate) pass: u32,
}

impl Peaks {
    /// Returns an empty set for `pixels` pixels.
    pub(crate) fn new(pixels: usize) -> Self {
        Peaks(vec![0; pixels])
    }

    /// Adds a pass of `channels` values per pixel; the first three are colour.
    pub(crate) fn add(&mut self, pass: u64, values: &[f32], channels: usize) {
        let age = u64::from(u32::MAX - u32::try_from(pass).unwrap_or(u32::MAX));
        let pixels = self.0.par_iter_mut().zip(values.par_chunks_exact(channels));
        pixels.with_min_len(4096).for_each(|(peak, values)| {
            let value = (values[0] + values[1] + values[2]) * (1.0 / 3.0);
            if value > 0.0 && value.is_finite() {
                *peak = (*peak).max(u64::from(value.to_bits()) << 32 | age);
            }
        });
    }

    /// Merges the samples of another film of the same size.
    pub(crate) fn merge(&mut self, other: &Peaks) {
        keep_largest(&mut self.0, &other.0);
    }

    /// Returns the largest sample of a pixel, or `None` if no sample was above zero.
    pub(crate) fn at(&self, pixel: usize) -> Option<Peak> {
        let packed = self.0[pixel];
        let value = f32::from_bits((packed >> 32) as u32);
        (packed != 0).then_some(Peak { value, pass: u32::MAX - packed as u32 })
    }

    /// Returns the packed samples, pixel by pixel.
    pub(crate) fn packed(&self) -> &[u64] {
        &self.0
    }

    /// Returns the packed samples for [`keep_largest`].
    pub(crate) fn packed_mut(&mut self) -> &mut [u64] {
        &mut self.0
    }
}

/// Keeps the larger of each pair of packed samples. Returns whether every entry of `others` is empty or finite and
/// above zero.
pub(crate) fn keep_largest(peaks: &mut [u64], others: &[u64]) -> bool {
    let is_valid = |packed: u64| packed == 0 || (1..f32::INFINITY.to_bits()).contains(&((packed >> 32) as u32));
    peaks.iter_mut().zip(others).for_each(|(peak, &other)| *peak = (*peak).max(other));
    others.iter().all(|&other| is_valid(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peaks(passes: &[(u64, [f32; 4])]) -> Peaks {
        let mut peaks = Peaks::new(1);
        passes.iter().for_each(|(pass, values)| peaks.add(*pass, values, 4));
        peaks
    }

    #[test]
    fn largest_sample_is_kept_and_ties_go_to_the_earliest_pass() {
        let passes = [(3, [1.0, 2.0, 3.0, 9.0]), (7, [2.0, 2.0, 2.0, 0.0]), (1, [0.5, 0.5, 0.5, 99.0])];
        let all = peaks(&passes);
        assert_eq!(all.at(0), Some(Peak { value: 2.0, pass: 3 }));
        let mut merged = peaks(&passes[1..]);
        merged.merge(&peaks(&passes[..1]));
        assert_eq!(merged, all);
    }

    #[test]
    fn zero_negative_and_non_finite_samples_are_not_kept() {
        let dark = [(0, [0.0; 4]), (1, [-1.0; 4]), (2, [f32::NAN; 4]), (3, [f32::INFINITY; 4])];
        assert_eq!(peaks(&dark).at(0), None);
    }

    #[test]
    fn pass_numbers_saturate_and_invalid_values_are_refused() {
        let late = peaks(&[(1 << 40, [1.0; 4])]);
        assert_eq!(late.at(0).map(|p| p.pass), Some(u32::MAX));
        let mut read = Peaks::new(1);
        assert!(keep_largest(read.packed_mut(), late.packed()) && read == late);
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            assert!(!keep_largest(read.packed_mut(), &[u64::from(bad.to_bits()) << 32 | 5]), "{bad}");
        }
    }
}
