//! TEMP stand-in until branch `gltf` is merged.
use crate::error::{Error, Result};
use crate::scene::description::Description;
use std::path::Path;

/// TEMP
///
/// # Errors
/// TEMP
pub fn load(path: &Path) -> Result<Description> {
    let text = std::fs::read(path).map_err(|e| Error::read(path, e))?;
    let _: serde_json::Value = serde_json::from_slice(&text).map_err(|e| Error::read(path, e))?;
    Ok(Description::default())
}
