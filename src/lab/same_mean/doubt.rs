//! Doubt about the errors of a picture.

use crate::film::pyramid::CHANNELS;
use crate::film::{ImageError, Reason};

/// Doubt about the errors of a picture's means, with a bound on the missed light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// The reason, as a sentence.
    pub sentence: &'static str,
    /// Bound on the contribution of unseen samples to a channel, as a sum over pixels; infinite if there is no bound.
    pub unseen: f64,
}

impl Doubt {
    /// Returns the doubt about a picture of `pixels` pixels, if there is one: light that its method samples rarely, or
    /// an undersampled heavy tail. Noise alone is no reason, since the test of the means accounts for it. The bound on
    /// unseen light fails with probability `level`.
    ///
    /// This is the only place that decides it, for all tests of equal means.
    pub fn of(error: &ImageError, pixels: usize, level: f64) -> Option<Doubt> {
        let by_luck = [Reason::RarePaths, Reason::HeavyTail, Reason::FewSamples];
        let reason =
            error.trust().reasons.iter().map(|distrust| distrust.reason).find(|reason| by_luck.contains(reason))?;
        // A sample is the mean of its channels. All of it may be in one channel.
        let unseen = error.unseen_share(pixels, level) * error.mean * (pixels * CHANNELS) as f64;
        Some(Doubt { sentence: reason.sentence(), unseen })
    }
}
