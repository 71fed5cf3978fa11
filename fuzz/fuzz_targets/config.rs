//! Any text as a render.toml.

#![no_main]

use etendue::session::SettingsPatch;
use etendue_fuzz::check;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(error) = SettingsPatch::parse(text) {
        check(&error);
    }
});
