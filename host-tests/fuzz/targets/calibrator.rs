//! Any sequence of calls with any bits: `.ci/fuzz 60 calibrator`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_calibrator(bytes));
