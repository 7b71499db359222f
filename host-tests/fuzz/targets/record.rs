//! Arbitrary bytes as saved records: `.ci/fuzz 60 record`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_record(bytes));
