//! How `path` is executed. The choice changes its speed and no pixel.

use super::path;
use crate::scene::Scene;

/// Execution of the path tracer.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Execution {
    /// One path after the other.
    Scalar,
    /// Many paths together, from bounce to bounce; scalar in scenes that batches do not know.
    Batched,
}

impl Execution {
    /// Returns what `choice` means for `scene`; without a choice the faster execution.
    pub fn chosen(choice: Option<Execution>, scene: &Scene) -> Execution {
        let batches = choice != Some(Execution::Scalar) && path::knows(scene);
        if batches { Execution::Batched } else { Execution::Scalar }
    }
}
