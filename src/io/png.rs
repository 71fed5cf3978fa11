//! TEMP stand-in until branch `film` is merged: not a PNG at all.
#![allow(missing_docs)]
use crate::error::{Error, Result};
use std::path::Path;
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Curve {
    #[default]
    Srgb,
    Filmic,
}
pub fn write(path: &Path, w: u32, h: u32, rgb: &[f32], alpha: Option<&[f32]>, stops: f32, curve: Curve) -> Result<()> {
    let text = format!("{w} {h} {} {} {stops} {curve:?}", rgb.len(), alpha.is_some());
    std::fs::write(path, text).map_err(|e| Error::write(path, e))
}
