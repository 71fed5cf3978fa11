//! Little-endian numbers at offsets of a file. What lies outside of the file is an error.

use crate::error::{Error, Result};

/// Bytes of a file or of a part of it.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    /// Returns the number of bytes.
    pub(super) fn len(self) -> usize {
        self.0.len()
    }

    /// Returns `count` bytes from offset `at`.
    pub(super) fn part(self, at: usize, count: usize) -> Result<Bytes<'a>> {
        let part = at.checked_add(count).and_then(|end| self.0.get(at..end));
        part.map(Bytes).ok_or_else(|| Error::scene("it ends too early"))
    }

    /// Returns the number of a length or offset that is stored in 64 bits.
    pub(super) fn length(self, at: usize) -> Result<usize> {
        usize::try_from(self.u64(at)?).map_err(|_| Error::scene("it ends too early"))
    }

    pub(super) fn u16(self, at: usize) -> Result<u16> {
        self.array(at).map(u16::from_le_bytes)
    }

    pub(super) fn u32(self, at: usize) -> Result<u32> {
        self.array(at).map(u32::from_le_bytes)
    }

    pub(super) fn i32(self, at: usize) -> Result<i32> {
        self.array(at).map(i32::from_le_bytes)
    }

    pub(super) fn f32(self, at: usize) -> Result<f32> {
        self.array(at).map(f32::from_le_bytes)
    }

    pub(super) fn u64(self, at: usize) -> Result<u64> {
        self.array(at).map(u64::from_le_bytes)
    }

    pub(super) fn i64(self, at: usize) -> Result<i64> {
        self.array(at).map(i64::from_le_bytes)
    }

    pub(super) fn f64(self, at: usize) -> Result<f64> {
        self.array(at).map(f64::from_le_bytes)
    }

    /// Returns the text from offset `at` to its first zero byte, at most `count` bytes.
    pub(super) fn text(self, at: usize, count: usize) -> Result<String> {
        let text = self.part(at, count)?.0;
        let end = text.iter().position(|&byte| byte == 0).unwrap_or(count);
        Ok(String::from_utf8_lossy(&text[..end]).into_owned())
    }

    fn array<const N: usize>(self, at: usize) -> Result<[u8; N]> {
        let bytes = self.0.get(at..).and_then(|rest| rest.first_chunk());
        bytes.copied().ok_or_else(|| Error::scene("it ends too early"))
    }
}
