//! TEMP stand-in until branch `film` is merged.
#![allow(missing_docs)]
use crate::error::{Error, Result};
use crate::film::Film;
use std::path::Path;
pub fn write(path: &Path, provenance: &serde_json::Value, film: &Film) -> Result<()> {
    let text = serde_json::to_vec(&(provenance, film)).map_err(|e| Error::write(path, e))?;
    let mut file =
        tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")).join(".")).map_err(|e| Error::write(path, e))?;
    std::io::Write::write_all(&mut file, &text).map_err(|e| Error::write(path, e))?;
    file.persist(path).map_err(|e| Error::write(path, e))?;
    Ok(())
}
pub fn read(path: &Path) -> Result<(serde_json::Value, Film)> {
    let text = std::fs::read(path).map_err(|e| Error::read(path, e))?;
    serde_json::from_slice(&text).map_err(|e| Error::read(path, e))
}
