//! A bound on what a file may unfold to, so that a small one cannot take all memory, or time for ever.
//!
//! glTF lets parts be used again and again: a thousand primitives may share one accessor, a thousand nodes one mesh of a
//! thousand parts. Honest files share too, so that what is read and placed may take many times the bytes of the file.

use crate::error::{Error, Result};
use std::cell::Cell;

/// What every file may unfold to, in bytes.
const FREE: u64 = 1 << 26;
/// What a file may unfold to beyond that, as a multiple of its bytes. Each index of one byte becomes 16 bytes of triangles,
/// each component of one byte 4 bytes: files in which nothing is shared stay below a third of it.
const TIMES: u64 = 64;

/// The bytes that are still allowed.
pub(super) struct Budget(Cell<u64>);

impl Budget {
    /// The budget of a file of `size` bytes, its buffers included.
    pub(super) fn of(size: usize) -> Self {
        Budget(Cell::new((size as u64).saturating_mul(TIMES).saturating_add(FREE)))
    }

    /// Takes `count` times `bytes` from it.
    ///
    /// # Errors
    /// A scene error if there are not as many left.
    pub(super) fn spend(&self, count: usize, bytes: usize) -> Result<()> {
        let left = (count as u64).checked_mul(bytes as u64).and_then(|cost| self.0.get().checked_sub(cost));
        let what = || Error::scene(format!("the file unfolds to more than {FREE} bytes and {TIMES} times its size"));
        left.map(|left| self.0.set(left)).ok_or_else(what)
    }
}
