//! Ray streams: any bytes, and the same with a checksum that is right.

#![no_main]

use etendue_fuzz::{check, file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    let body = &bytes[..bytes.len().saturating_sub(blake3::OUT_LEN)];
    read(&[body, blake3::hash(body).as_bytes()].concat());
});

fn read(bytes: &[u8]) {
    if let Err(error) = etendue::lab::bench_rays::stream_file::read(&file("a.rays", bytes)) {
        check(&error);
    }
}
