//! Any sequence of calls with any bits: `cargo fuzz run --sanitizer none calibrator` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_harness::run_calibrator(bytes));
