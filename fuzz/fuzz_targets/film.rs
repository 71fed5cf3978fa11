//! Film files whose checksum is right: a header in JSON, a NUL, and the blocks before compression, each with its length
//! before it; or any bytes at all.

#![no_main]

use etendue_fuzz::{check, file};
use etendue_testing::forge;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    read(&forge::film(bytes));
});

fn read(bytes: &[u8]) {
    if let Err(error) = etendue::session::film_file::read(&file("a.film", bytes)) {
        check(&error);
    }
}
