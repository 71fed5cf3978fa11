//! Report files: JSON documents and tables.

use crate::error::{Error, Kind, Result};
use crate::io::atomic::write_atomically;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Writes a JSON document.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written.
pub(super) fn json(path: &Path, document: &impl Serialize) -> Result<()> {
    let json = serde_json::to_vec_pretty(document).map_err(|cause| unmade(path).because(cause))?;
    write_atomically(path, |file| file.write_all(&json))
}

/// Writes a table. Its header is the field names of the rows.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written.
pub(super) fn csv(path: &Path, rows: impl Iterator<Item = impl Serialize>) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    for row in rows {
        table.serialize(row).map_err(|cause| unmade(path).because(cause))?;
    }
    let table = table.into_inner().map_err(|cause| unmade(path).because(cause.into_error()))?;
    write_atomically(path, |file| file.write_all(&table))
}

fn unmade(path: &Path) -> Error {
    Error::new(Kind::Internal, format!("cannot make {}", path.display()))
}
