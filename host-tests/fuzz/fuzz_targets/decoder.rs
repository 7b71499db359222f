//! Any stream of bytes and frames into the decoder: `cargo fuzz run --sanitizer none decoder` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_harness::run_decoder(bytes));
