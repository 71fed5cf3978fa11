//! Any bytes as an OpenEXR file.

#![no_main]

use etendue_fuzz::{check, file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = etendue::io::exr::read(&file("a.exr", bytes)) {
        check(&error);
    }
});
