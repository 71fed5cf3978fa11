//! Any bytes as an environment map, of either format, with and without a layer asked for. The first byte chooses.

#![no_main]

use etendue_fuzz::{check, file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else { return };
    let name = if choice & 1 == 0 { "a.hdr" } else { "a.exr" };
    let layer = (choice & 2 != 0).then_some("Combined");
    if let Err(error) = etendue::io::environment::load(&file(name, bytes), layer) {
        check(&error);
    }
});
