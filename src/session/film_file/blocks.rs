//! Arrays of 64-bit words, stored in blocks that are compressed independently. All threads compress and decompress in
//! parallel, and a reader holds only a few blocks at a time.
//!
//! A block is the length of its frame as a u32, then a zstd frame. Inside, the bytes of the words are transposed: first
//! the lowest byte of every word, then the next one, up to the highest. Neighbouring sums differ in their low bytes and
//! hardly in their high bytes, so that the transposed bytes compress better.

use crate::error::{Error, Result};
use rayon::prelude::*;
use std::io::{self, Read, Write};
use zstd::bulk::{Compressor, Decompressor};

/// Words per block; the last block of a run may be shorter.
pub(super) const WORDS: usize = 1 << 16;
const BYTES: usize = size_of::<u64>();
/// Compression level that keeps up with the disk, since checkpoints are written while rendering.
const LEVEL: i32 = 1;
/// zstd expands 4 bytes to at most 128 KiB.
const MOST_EXPANSION: u64 = 1 << 15;

/// Maximum number of words in `bytes` of blocks.
pub(super) fn most_words(bytes: u64) -> u64 {
    bytes.saturating_mul(MOST_EXPANSION) / BYTES as u64
}

/// Number of blocks in flight: two per thread.
fn batch() -> usize {
    2 * rayon::current_num_threads()
}

/// Writes a run.
pub(super) fn write(out: &mut impl Write, words: &[u64]) -> io::Result<()> {
    for batch in words.chunks(WORDS * batch()) {
        let compressor = || Compressor::new(LEVEL);
        let frames = batch.par_chunks(WORDS).map_init(compressor, |compressor, words| match compressor {
            Ok(compressor) => compressor.compress(&split(words)),
            Err(cause) => Err(io::Error::other(cause.to_string())),
        });
        for frame in frames.collect::<io::Result<Vec<_>>>()? {
            let length = u32::try_from(frame.len()).map_err(io::Error::other)?;
            out.write_all(&length.to_le_bytes())?;
            out.write_all(&frame)?;
        }
    }
    Ok(())
}

/// Reads a run of as many words as `into` has. `add` receives the index of a block's first word, the block's part of
/// `into`, and its words. Memory is touched only as words arrive.
pub(super) fn read<T: Send, R: Send>(
    input: &mut impl Read,
    into: &mut [T],
    add: impl Fn(usize, &mut [T], &[u64]) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let (mut results, mut begun) = (Vec::new(), 0);
    for batch in into.chunks_mut(WORDS * batch()) {
        let frames = batch.chunks(WORDS).map(|_| read_frame(input)).collect::<Result<Vec<_>>>()?;
        let parts = batch.par_chunks_mut(WORDS).zip(frames).enumerate();
        let added = parts.map_init(Decompressor::new, |decompressor, (block, (into, frame))| {
            let decompressor = decompressor.as_mut().map_err(|cause| Error::scene(cause.to_string()))?;
            let bytes = decompressor.decompress(&frame, into.len() * BYTES).map_err(super::damaged)?;
            if bytes.len() != into.len() * BYTES {
                return Err(Error::scene("it is damaged: a block is too short"));
            }
            add(begun + block * WORDS, into, &join(&bytes))
        });
        results.extend(added.collect::<Result<Vec<_>>>()?);
        begun += batch.len();
    }
    Ok(results)
}

fn read_frame(input: &mut impl Read) -> Result<Vec<u8>> {
    let mut length = [0; 4];
    input.read_exact(&mut length).map_err(super::damaged)?;
    let length = u32::from_le_bytes(length) as usize;
    if length > zstd::zstd_safe::compress_bound(WORDS * BYTES) {
        return Err(Error::scene("it is damaged: a block is too long"));
    }
    let mut frame = vec![0; length];
    input.read_exact(&mut frame).map_err(super::damaged)?;
    Ok(frame)
}

/// Transposes the bytes: the lowest byte of every word, then the next one, and so on.
fn split(words: &[u64]) -> Vec<u8> {
    let mut bytes = vec![0; words.len() * BYTES];
    for (place, bytes) in bytes.chunks_exact_mut(words.len()).enumerate() {
        bytes.iter_mut().zip(words).for_each(|(byte, word)| *byte = (word >> (8 * place)) as u8);
    }
    bytes
}

/// Inverse of [`split`].
fn join(bytes: &[u8]) -> Vec<u64> {
    let mut words = vec![0; bytes.len() / BYTES];
    for (place, bytes) in bytes.chunks_exact(words.len()).enumerate() {
        words.iter_mut().zip(bytes).for_each(|(word, &byte)| *word |= u64::from(byte) << (8 * place));
    }
    words
}
