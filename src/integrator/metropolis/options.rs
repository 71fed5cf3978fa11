//! What Metropolis methods may be told.

use std::fmt;
use std::str::FromStr;

/// How often each mutation of path space is tried where it can be, relative to the others.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Mutations {
    /// Replaces any part of a path.
    pub bidirectional: f64,
    /// Moves the film position; what follows up to the first edge between smooth vertices goes along.
    pub lens: f64,
    /// Moves the direction of the last smooth vertex before mirrors and glass that throw light to where the camera sees it.
    pub caustic: f64,
    /// The lens perturbation on through several chains of mirrors and glass.
    pub multi_chain: f64,
    /// Replaces what the lens perturbation moves by a new walk from the camera.
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

    /// Reads `name=weight,…`; what is not named is not tried. The bidirectional mutation must be, since the others reach no new kind of
    /// path.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut weights = [0.0; 5];
        for part in text.split(',') {
            let (name, weight) = part.split_once('=').unwrap_or((part, "1"));
            let known = Self::NAMES.iter().position(|known| *known == name.trim());
            let index = known.ok_or_else(|| format!("'{name}' is no mutation: there are {}", Self::NAMES.join(", ")))?;
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

/// What the chains of a pass are like.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MetropolisOptions {
    /// Chains in a pass; `None` for as many as the image's size suggests.
    pub chains: Option<u32>,
    /// Probability of a step to anywhere in primary sample space.
    pub large_step: f64,
    /// Path lengths, in scattering events, up to which multiplexed chains each have one of their own; longer ones share theirs.
    pub lengths: u32,
    /// Mutations of path space.
    pub mutations: Mutations,
    /// How many times what is usual where it falls a sample of bidirectional path tracing may be worth before chains have the rest; 0 for
    /// no samples and everything to chains; `None` to let a pilot decide.
    pub limit: Option<f64>,
    /// Whether chains visit all parts of the image alike, dark or bright.
    pub two_stage: bool,
}

impl Default for MetropolisOptions {
    fn default() -> Self {
        MetropolisOptions {
            chains: None,
            large_step: 0.3,
            lengths: 8,
            mutations: Mutations::default(),
            limit: None,
            two_stage: false,
        }
    }
}
