//! Files with a valid checksum and any contents, for the fuzz target of films and for the replay of its corpus in
//! tests/io.

/// A film from a header, a NUL and unpacked blocks, each with its length before it.
pub fn film(bytes: &[u8]) -> Vec<u8> {
    let at = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let (header, mut blocks) = (&bytes[..at], bytes.get(at + 1..).unwrap_or_default());
    let mut film = [b"\x89ETFILM\n", &3u32.to_le_bytes()[..], &(header.len() as u32).to_le_bytes(), header].concat();
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
