//! TEMP stand-in until branch `film` is merged.
#![allow(missing_docs)]
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct RelMse {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct ImageError {
    pub relmse: RelMse,
    pub rmse: f64,
    pub mean: f64,
    pub mean_standard_error: f64,
    pub epsilon: f64,
    pub replicates: u32,
}
