//! Any bytes as a bag: `.ci/fuzz 60 bags`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_bags(bytes));
