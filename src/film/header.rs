//! Metadata of a film.

use super::{Layout, PassSet, Units};
use crate::error::{Error, Result};

/// Metadata of a film: everything but its sums.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilmHeader {
    /// Pixels and planes.
    pub layout: Layout,
    /// Number of replicates.
    pub replicates: u32,
    /// Seed of the render.
    pub seed: u64,
    /// Units of the sums.
    pub units: Units,
    /// Passes in the film.
    pub passes: PassSet,
    /// Number of values that were not finite or too large; they count as zero.
    pub dropped: u64,
}

impl FilmHeader {
    /// Returns the number of sums of a replicate.
    pub(crate) fn values(&self) -> usize {
        self.layout.pixels() * self.layout.channels()
    }

    /// Checks that the passes of `other` can be added to this film.
    ///
    /// # Errors
    /// If the films differ in layout, replicates, seed or units, or share a pass.
    pub fn admits(&self, other: &FilmHeader) -> Result<()> {
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

    /// Adds the passes of another film of the same render to the set of passes.
    ///
    /// # Errors
    /// See [`FilmHeader::admits`]; this header is then unchanged.
    pub(crate) fn absorb(&mut self, other: &FilmHeader) -> Result<()> {
        self.admits(other)?;
        self.passes.union(&other.passes);
        self.dropped += other.dropped;
        Ok(())
    }
}
