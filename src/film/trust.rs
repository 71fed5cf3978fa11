//! Whether the interval of an error is reliable, with the reasons. Console, reports, headers and targets use this
//! verdict.

/// Verdict on an interval.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trust {
    /// Whether the interval is reliable, as far as the samples and prior knowledge of the scene can tell.
    pub trusted: bool,
    /// Reasons against it; empty if it is trusted.
    pub reasons: Vec<Distrust>,
}

/// One reason to distrust an interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Distrust {
    /// The kind of problem.
    pub reason: Reason,
    /// The measured value; infinite (`null` in JSON) without a bound.
    #[serde(deserialize_with = "super::relmse::null_is_infinite")]
    pub value: f64,
    /// The limit that `value` violates.
    pub limit: f64,
}

/// Problems that make an interval unreliable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The method cannot sample some of the light of the scene.
    BlindMethod,
    /// No sample has found light. Where there is light, all of it was missed.
    NoLight,
    /// The method samples some paths of the scene only by chance. The value is their possible unseen contribution, as a
    /// share of the error.
    RarePaths,
    /// The tail of the samples may be too heavy for finite second moments. The value is the upper end of the interval
    /// of the tail shape.
    HeavyTail,
    /// Single samples dominate the error of their pixels. The value is their share of relMSE.
    FewSamples,
    /// Noisy denominators bias the relative error. The value is that bias as a share of relMSE.
    NoisyImage,
    /// Too few replicates to estimate the error.
    FewReplicates,
}

impl Trust {
    /// Returns the verdict for `reasons`: trusted if there are none.
    pub(super) fn unless(reasons: Vec<Distrust>) -> Self {
        Trust { trusted: reasons.is_empty(), reasons }
    }

    /// Returns the most important reason as a sentence.
    pub fn why_not(&self) -> Option<&'static str> {
        self.reasons.first().map(|distrust| distrust.reason.sentence())
    }
}

impl Reason {
    /// Returns the reason as a sentence.
    pub fn sentence(self) -> &'static str {
        match self {
            Reason::BlindMethod => "the method does not see all light of the scene",
            Reason::NoLight => "the image is black, since no sample has found light",
            Reason::RarePaths => {
                "the scene has paths that the method meets by luck, and they may carry the error unseen"
            }
            Reason::HeavyTail => "a few samples carry the error, and there may be larger ones to come",
            Reason::FewSamples => {
                "single samples carry the error of a few pixels, and other pixels may have missed them"
            }
            Reason::NoisyImage => "the image is too noisy to divide its error by",
            Reason::FewReplicates => "there are too few replicates to tell how far the error may be off",
        }
    }
}
