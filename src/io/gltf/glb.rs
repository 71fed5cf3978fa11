//! The binary container: a header, a JSON chunk and an optional binary chunk [glTF20 §4.4]. The `gltf` crate has a
//! reader too, but it panics on a header length under 12.

use crate::error::{Error, Result};

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// First four bytes of a binary file.
pub(super) const MAGIC: &[u8] = b"glTF";

/// Splits a file that begins with [`MAGIC`] into the JSON chunk and the binary chunk, if there is one.
///
/// # Errors
/// A scene error if the header or the chunks do not fit the file's bytes.
pub(super) fn split(file: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let (Some(version), Some(length)) = (word(file, 4), word(file, 8)) else {
        return Err(Error::scene("the binary glTF header is cut off"));
    };
    if version != 2 {
        return Err(Error::scene(format!("binary glTF version {version} is not 2")));
    }
    if length < HEADER || length > file.len() {
        return Err(Error::scene(format!("the binary glTF header claims {length} bytes and there are {}", file.len())));
    }
    let (kind, json, rest) = chunk(&file[HEADER..length])?;
    if kind != JSON {
        return Err(Error::scene("the first chunk of the binary glTF is not JSON"));
    }
    // The specification requires unknown chunk types to be ignored.
    let binary = if rest.iter().all(|&byte| byte == 0) && rest.len() < CHUNK_HEADER {
        None
    } else {
        Some(chunk(rest)?).filter(|&(kind, ..)| kind == BIN)
    };
    Ok((json, binary.map(|(_, bytes, _)| bytes)))
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let word = bytes.get(at..at + 4)?;
    usize::try_from(u32::from_le_bytes(word.try_into().ok()?)).ok()
}

/// Returns type and contents of the first chunk, and the bytes after it.
fn chunk(bytes: &[u8]) -> Result<(&[u8], &[u8], &[u8])> {
    let cut = || Error::scene("a chunk of the binary glTF is cut off");
    let length = word(bytes, 0).ok_or_else(cut)?;
    let kind = bytes.get(4..CHUNK_HEADER).ok_or_else(cut)?;
    let (contents, rest) = bytes[CHUNK_HEADER..].split_at_checked(length).ok_or_else(cut)?;
    Ok((kind, contents, rest))
}
