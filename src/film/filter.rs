//! TEMP stand-in until branch `film` is merged.
#![allow(missing_docs)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    Box,
    Tent,
    Gaussian,
    #[default]
    BlackmanHarris,
}
