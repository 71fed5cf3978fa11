//! Hashing reader and writer, for files that end with the hash of all preceding bytes.

use std::io::{self, Read, Write};

/// A reader or writer that hashes all bytes it transfers.
#[derive(Debug)]
pub(crate) struct Hashed<T> {
    /// The underlying reader or writer.
    pub(crate) inner: T,
    /// The hash so far.
    pub(crate) hasher: blake3::Hasher,
}

impl<T> Hashed<T> {
    /// Starts with an empty hash.
    pub(crate) fn new(inner: T) -> Self {
        Hashed { inner, hasher: blake3::Hasher::new() }
    }
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(bytes)?;
        self.hasher.update(&bytes[..n]);
        Ok(n)
    }
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
