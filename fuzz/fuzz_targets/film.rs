//! Film files whose checksum is right: a header in JSON, a NUL, and the blocks before compression, each with its length before it;
//! or any bytes at all.

#![no_main]

use etendue_fuzz::{check, file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    let at = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let (header, body) = bytes.split_at(at);
    read(&forged(header, body.get(1..).unwrap_or_default()));
});

fn read(bytes: &[u8]) {
    if let Err(error) = etendue::render::film_file::read(&file("a.film", bytes)) {
        check(&error);
    }
}

fn forged(header: &[u8], mut blocks: &[u8]) -> Vec<u8> {
    let mut film = [&b"\x89ETFILM\n"[..], &3u32.to_le_bytes(), &(header.len() as u32).to_le_bytes(), header].concat();
    while let Some((length, rest)) = blocks.split_first_chunk() {
        let (block, others) = rest.split_at(rest.len().min(u32::from_le_bytes(*length) as usize));
        let frame = zstd::encode_all(block, 1).expect("compression in memory");
        film.extend((frame.len() as u32).to_le_bytes());
        film.extend(frame);
        blocks = others;
    }
    let hash = blake3::hash(&film);
    film.extend(hash.as_bytes());
    film
}
