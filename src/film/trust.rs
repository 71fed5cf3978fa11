//! Whether the interval of an error is to be trusted, and why not, as data: console, reports, headers and targets go by this.

/// The verdict on an interval.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trust {
    /// Whether the interval holds what it says, as far as samples and what is known of the scene can tell.
    pub trusted: bool,
    /// Why not; none if it is trusted.
    pub reasons: Vec<Distrust>,
}

/// One reason not to trust an interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Distrust {
    /// What is wrong.
    pub reason: Reason,
    /// The figure that says so; infinite (`null` in JSON) where there is no bound.
    #[serde(deserialize_with = "super::error_estimate::null_is_infinite")]
    pub value: f64,
    /// What it must not be beyond.
    pub limit: f64,
}

/// What speaks against an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The method is blind to light of the scene.
    BlindMethod,
    /// The scene has paths that the method samples by luck, and what they may bring beyond what was seen is this share of the error.
    RarePaths,
    /// The tail of the samples may be so heavy that their second moments do not converge: the upper end of its shape's interval.
    HeavyTail,
    /// Single samples carry the error of their pixels, as a share of relMSE.
    FewSamples,
    /// Denominators are too noisy to divide by: the bias of that, as a share of relMSE.
    NoisyImage,
    /// The error may not be told from so few replicates.
    FewReplicates,
}

impl Trust {
    /// The verdict for those `reasons`.
    pub(super) fn unless(reasons: Vec<Distrust>) -> Self {
        Trust { trusted: reasons.is_empty(), reasons }
    }

    /// The reason that weighs most, in words.
    pub fn why_not(&self) -> Option<&'static str> {
        self.reasons.first().map(|distrust| distrust.reason.sentence())
    }
}

impl Reason {
    /// In words.
    pub fn sentence(self) -> &'static str {
        match self {
            Reason::BlindMethod => "the method does not see all light of the scene",
            Reason::RarePaths => "the scene has paths that the method meets by luck, and they may carry the error unseen",
            Reason::HeavyTail => "a few samples carry the error, and there may be larger ones to come",
            Reason::FewSamples => "single samples carry the error of a few pixels, and other pixels may have missed them",
            Reason::NoisyImage => "the image is too noisy to divide its error by",
            Reason::FewReplicates => "there are too few replicates to tell how far the error may be off",
        }
    }
}
