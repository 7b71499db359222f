//! Any stream of bytes and frames through the decoder into the calibrator: `.ci/fuzz 60 frames`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_frames(bytes));
