//! A bound on the data that a file may expand to. A small file can then exhaust neither memory nor time.
//!
//! glTF allows sharing: a thousand primitives may share one accessor, a thousand nodes one mesh of a thousand parts.
//! Legitimate files share too, so that the loaded data may take many times the bytes of the file.

use crate::error::{Error, Result};
use std::cell::Cell;

/// Budget of every file, in bytes.
const FREE: u64 = 1 << 26;
/// Further budget, as a multiple of the file's bytes. An index of one byte becomes 16 bytes of triangles, a component
/// of one byte becomes 4 bytes. Files without sharing stay below a third of the budget.
const TIMES: u64 = 64;

/// Remaining bytes.
pub(super) struct Budget(Cell<u64>);

impl Budget {
    /// Returns the budget of a file of `size` bytes, including its buffers.
    pub(super) fn of(size: usize) -> Self {
        Budget(Cell::new((size as u64).saturating_mul(TIMES).saturating_add(FREE)))
    }

    /// Spends `count` times `bytes`.
    ///
    /// # Errors
    /// A scene error if fewer bytes are left.
    pub(super) fn spend(&self, count: usize, bytes: usize) -> Result<()> {
        let left = (count as u64).checked_mul(bytes as u64).and_then(|cost| self.0.get().checked_sub(cost));
        let what = || Error::scene(format!("the file unfolds to more than {FREE} bytes and {TIMES} times its size"));
        left.map(|left| self.0.set(left)).ok_or_else(what)
    }
}
