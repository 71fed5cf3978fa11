//! TEMP stand-in until branch `film` is merged: not an EXR at all.
#![allow(missing_docs)]
use crate::error::{Error, Result};
use crate::film::Crop;
use std::path::Path;
#[derive(Debug)]
pub struct Layer {
    pub name: String,
    pub values: Vec<f32>,
}
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    Text(String),
    Float(f32),
    Int(i32),
}
pub fn write(
    path: &Path,
    width: u32,
    height: u32,
    crop: Option<Crop>,
    layers: &[Layer],
    attributes: &[(String, Attribute)],
) -> Result<()> {
    let names: Vec<_> = layers.iter().map(|l| (&l.name, l.values.len())).collect();
    std::fs::write(path, format!("{width} {height} {crop:?} {names:?} {attributes:#?}")).map_err(|e| Error::write(path, e))
}
