//! Any bytes as a rig file: `.ci/fuzz 60 rigs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_rigs(bytes));
