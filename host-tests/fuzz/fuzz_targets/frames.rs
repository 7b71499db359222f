//! Any stream of bytes and frames through the decoder into the calibrator: `cargo fuzz run --sanitizer none frames`
//! in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_harness::run_frames(bytes));
