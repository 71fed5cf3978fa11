//! What a film is of, apart from its sums.

use super::{Layout, PassSet, Units};
use crate::error::{Error, Result};

/// What a film is of and which passes it holds: everything but its sums.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// Which pixels and planes.
    pub layout: Layout,
    /// How many replicates passes are dealt to.
    pub replicates: u32,
    /// The render's seed.
    pub seed: u64,
    /// The units of the sums.
    pub units: Units,
    /// Which passes.
    pub passes: PassSet,
    /// How many values were not finite or too large, and count as zero.
    pub dropped: u64,
}

impl Head {
    /// How many sums a replicate has.
    pub(crate) fn values(&self) -> usize {
        self.layout.pixels() * self.layout.channels()
    }

    /// Whether the passes of `other` can be added to those of this film.
    ///
    /// # Errors
    /// If the films differ in layout, replicates, seed or units, or hold a pass in common.
    pub fn admits(&self, other: &Head) -> Result<()> {
        let refuse = |what: String| Err(Error::scene(format!("the films cannot be merged: {what}")));
        if self.layout != other.layout {
            return refuse("they differ in image size, crop or planes".into());
        }
        if self.replicates != other.replicates {
            return refuse(format!("one has {} replicates, the other {}", self.replicates, other.replicates));
        }
        if self.seed != other.seed {
            return refuse(format!("one has seed {}, the other {}", self.seed, other.seed));
        }
        if self.units != other.units {
            return refuse("their sums are in different units".into());
        }
        if let Some(pass) = self.passes.first_common(&other.passes) {
            return refuse(format!("both hold pass {pass} (one has {}, the other {})", self.passes, other.passes));
        }
        Ok(())
    }

    /// Counts the passes of another film of the same render as held.
    ///
    /// # Errors
    /// See [`Head::admits`]; this one is then unchanged.
    pub(crate) fn absorb(&mut self, other: &Head) -> Result<()> {
        self.admits(other)?;
        self.passes.union(&other.passes);
        self.dropped += other.dropped;
        Ok(())
    }
}
