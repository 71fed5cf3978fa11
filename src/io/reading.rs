//! Options of scene readers, and bounded reading of files.

use crate::error::{Error, Kind, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Options for reading a scene file.
#[derive(Debug, Clone, Copy)]
pub struct ReadOptions<'a> {
    /// Time of the animations in seconds; `None` reads the scene at rest.
    pub seconds: Option<f64>,
    /// The only animation that is played, by name or number from 0; `None` plays all together.
    pub animation: Option<&'a str>,
    /// Memory limit of decoded images in bytes, and separately of the lights of emissive meshes.
    pub memory: u64,
}

impl Default for ReadOptions<'_> {
    /// The scene at rest, with 4 GiB.
    fn default() -> Self {
        ReadOptions { seconds: None, animation: None, memory: 1 << 32 }
    }
}

/// Reads at most `limit` bytes of a regular file. Devices and pipes are rejected, since reading them might never end.
///
/// # Errors
/// An error with the path if the file cannot be read or does not fit into memory.
pub(super) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let file = std::fs::metadata(path).map_err(|e| Error::read(path, e))?;
    if !file.is_file() {
        return Err(Error::scene(format!("cannot read {}: it is not a regular file", path.display())));
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(file.len().min(limit)).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(length).map_err(|e| {
        Error::new(Kind::Memory, format!("{} does not fit into memory ({length} bytes)", path.display())).because(e)
    })?;
    File::open(path).and_then(|f| f.take(limit).read_to_end(&mut bytes)).map_err(|e| Error::read(path, e))?;
    Ok(bytes)
}
