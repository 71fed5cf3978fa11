//! Buffer contents from data URIs, the binary chunk or files. Each file is read once.

use super::resource;
use crate::error::{Error, Result};
use ::gltf::json::{self, Root};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Contents of a buffer: the first `length` bytes of data that several buffers may share.
pub(super) struct Buffer {
    bytes: Arc<Vec<u8>>,
    length: usize,
}

impl Buffer {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// Reads the buffers of a file with this binary chunk; `None` for a buffer without a URI or a chunk.
///
/// # Errors
/// A scene error that names the buffer if its bytes cannot be read or are fewer than it claims.
pub(super) fn read_all(root: &Root, base: &Path, binary: Option<&[u8]>) -> Result<Vec<Option<Buffer>>> {
    let most = root.buffers.iter().map(|b| b.byte_length.0).max().unwrap_or_default();
    let mut files = Files { base, most, known: HashMap::new() };
    let mut read = |index: usize, buffer: &json::Buffer| -> Result<Option<Buffer>> {
        let bytes = match (&buffer.uri, binary) {
            (Some(uri), _) => files.read(uri)?,
            (None, Some(binary)) if index == 0 => Arc::new(binary.to_vec()),
            (None, _) => return Ok(None),
        };
        let (claimed, has) = (buffer.byte_length.0, bytes.len());
        let length = usize::try_from(claimed).ok().filter(|&length| length <= has);
        let length = length.ok_or_else(|| Error::scene(format!("it claims {claimed} bytes and has {has}")))?;
        Ok(Some(Buffer { bytes, length }))
    };
    let buffers = root.buffers.iter().enumerate();
    buffers.map(|(index, buffer)| read(index, buffer).map_err(|e| e.context(format!("buffer {index}")))).collect()
}

/// Returns the bytes of all buffers, with shared ones counted once.
pub(super) fn size(buffers: &[Option<Buffer>]) -> usize {
    let mut distinct: Vec<&Arc<Vec<u8>>> = buffers.iter().flatten().map(|b| &b.bytes).collect();
    distinct.sort_by_key(|bytes| Arc::as_ptr(bytes));
    distinct.dedup_by_key(|bytes| Arc::as_ptr(bytes));
    distinct.iter().map(|bytes| bytes.len()).sum()
}

/// Files beside the scene.
struct Files<'a> {
    base: &'a Path,
    /// Largest number of bytes that any buffer needs from a file.
    most: u64,
    known: HashMap<PathBuf, Arc<Vec<u8>>>,
}

impl Files<'_> {
    fn read(&mut self, uri: &str) -> Result<Arc<Vec<u8>>> {
        let path = resource::file_of(self.base, uri);
        if let Some(known) = path.as_ref().and_then(|path| self.known.get(path)) {
            return Ok(Arc::clone(known));
        }
        let bytes = Arc::new(resource::read_uri(self.base, uri, self.most)?);
        self.known.extend(path.map(|path| (path, Arc::clone(&bytes))));
        Ok(bytes)
    }
}
