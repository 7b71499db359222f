//! Any stream of bytes and frames into the decoder: `.ci/fuzz 60 decoder`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_decoder(bytes));
