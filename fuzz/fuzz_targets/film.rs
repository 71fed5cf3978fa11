//! Film files whose checksum is right: a header in JSON, a NUL, and the body before compression; or any bytes at all.

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

fn forged(header: &[u8], body: &[u8]) -> Vec<u8> {
    let prefix = [&b"\x89ETFILM\n"[..], &2u32.to_le_bytes(), &(header.len() as u32).to_le_bytes(), header].concat();
    let mut film = prefix;
    film.extend(zstd::encode_all(body, 1).expect("compression in memory"));
    let hash = blake3::hash(&film);
    film.extend(hash.as_bytes());
    film
}
