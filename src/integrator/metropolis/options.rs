//! Selection frequencies of the path space mutations.

use std::fmt;
use std::str::FromStr;

/// Relative selection frequency of each path space mutation, where it is applicable.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Mutations {
    /// Replaces any part of a path.
    pub bidirectional: f64,
    /// Perturbs the raster position; the path follows up to the first edge between smooth vertices.
    pub lens: f64,
    /// Perturbs the direction at the last smooth vertex before the mirrors and glass of a caustic.
    pub caustic: f64,
    /// Lens perturbation through several chains of mirrors and glass.
    pub multi_chain: f64,
    /// Replaces the vertices that the lens perturbation moves by a new camera subpath.
    pub lens_subpath: f64,
}

impl Default for Mutations {
    fn default() -> Self {
        Mutations { bidirectional: 1.0, lens: 1.0, caustic: 1.0, multi_chain: 1.0, lens_subpath: 1.0 }
    }
}

impl Mutations {
    pub(super) const NAMES: [&'static str; 5] = ["bidirectional", "lens", "caustic", "multi-chain", "lens-subpath"];

    fn weights(&self) -> [f64; 5] {
        [self.bidirectional, self.lens, self.caustic, self.multi_chain, self.lens_subpath]
    }
}

impl fmt::Display for Mutations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs: Vec<String> =
            Self::NAMES.iter().zip(self.weights()).map(|(name, weight)| format!("{name}={weight}")).collect();
        f.write_str(&pairs.join(","))
    }
}

impl From<Mutations> for String {
    fn from(mutations: Mutations) -> String {
        mutations.to_string()
    }
}

impl TryFrom<String> for Mutations {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Mutations {
    type Err = String;

    /// Parses `name=weight,…`. Mutations that are not named have weight 0. The bidirectional mutation must have a
    /// positive weight, since the others cannot reach every kind of path.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut weights = [0.0; 5];
        for part in text.split(',') {
            let (name, weight) = part.split_once('=').unwrap_or((part, "1"));
            let known = Self::NAMES.iter().position(|known| *known == name.trim());
            let index =
                known.ok_or_else(|| format!("'{name}' is no mutation: there are {}", Self::NAMES.join(", ")))?;
            let weight: f64 = weight.trim().parse().map_err(|_| format!("'{weight}' is not a number"))?;
            if !(0.0..=1e6).contains(&weight) {
                return Err(format!("the weight {weight} of {name} is not between 0 and 1e6"));
            }
            weights[index] = weight;
        }
        let [bidirectional, lens, caustic, multi_chain, lens_subpath] = weights;
        if bidirectional <= 0.0 {
            return Err("the bidirectional mutation must take part: the others alone do not reach every path".into());
        }
        Ok(Mutations { bidirectional, lens, caustic, multi_chain, lens_subpath })
    }
}
