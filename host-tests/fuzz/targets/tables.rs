//! Any bytes as a table of matches: `.ci/fuzz 60 tables`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_tables(bytes));
