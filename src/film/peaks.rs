//! The largest sample of every pixel and the pass that it came from: a firefly can be traced again, and the tail of the
//! samples be judged. Which ones are kept does not depend on the order of passes and merges.

use rayon::prelude::*;

/// The largest sample of each pixel, packed so that the larger number is the one to keep: above the bits of its value as
/// f32, which order like numbers since it is not negative, below 2³² − 1 − pass, so that of equals the earliest stays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Peaks(Vec<u64>);

/// The largest sample of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Peak {
    /// The mean of its lanes, above zero.
    pub(crate) value: f32,
    /// The pass it belongs to; 2³² − 1 for all passes from there on.
    pub(crate) pass: u32,
}

impl Peaks {
    /// None yet, for so many pixels.
    pub(crate) fn new(pixels: usize) -> Self {
        Peaks(vec![0; pixels])
    }

    /// Takes in a pass whose pixels have `channels` values each, the first three of them colour.
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

    /// Takes in all passes of another film of the same size.
    pub(crate) fn merge(&mut self, other: &Peaks) {
        keep_largest(&mut self.0, &other.0);
    }

    /// The largest sample of a pixel; `None` where none was above zero.
    pub(crate) fn at(&self, pixel: usize) -> Option<Peak> {
        let packed = self.0[pixel];
        let value = f32::from_bits((packed >> 32) as u32);
        (packed != 0).then_some(Peak { value, pass: u32::MAX - packed as u32 })
    }

    /// As they are packed, pixel by pixel.
    pub(crate) fn packed(&self) -> &[u64] {
        &self.0
    }

    /// The same, for [`keep_largest`].
    pub(crate) fn packed_mut(&mut self) -> &mut [u64] {
        &mut self.0
    }
}

/// Takes the larger of each two packed samples; whether all of `others` are none or finite ones above zero.
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
    fn the_largest_and_of_equals_the_earliest_stays_in_any_order() {
        let passes = [(3, [1.0, 2.0, 3.0, 9.0]), (7, [2.0, 2.0, 2.0, 0.0]), (1, [0.5, 0.5, 0.5, 99.0])];
        let all = peaks(&passes);
        assert_eq!(all.at(0), Some(Peak { value: 2.0, pass: 3 }));
        let mut merged = peaks(&passes[1..]);
        merged.merge(&peaks(&passes[..1]));
        assert_eq!(merged, all);
    }

    #[test]
    fn what_is_no_light_leaves_nothing() {
        let dark = [(0, [0.0; 4]), (1, [-1.0; 4]), (2, [f32::NAN; 4]), (3, [f32::INFINITY; 4])];
        assert_eq!(peaks(&dark).at(0), None);
    }

    #[test]
    fn late_passes_and_bad_files_are_told_apart() {
        let late = peaks(&[(1 << 40, [1.0; 4])]);
        assert_eq!(late.at(0).map(|p| p.pass), Some(u32::MAX));
        let mut read = Peaks::new(1);
        assert!(keep_largest(read.packed_mut(), late.packed()) && read == late);
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            assert!(!keep_largest(read.packed_mut(), &[u64::from(bad.to_bits()) << 32 | 5]), "{bad}");
        }
    }
}
