//! Arbitrary bytes as saved records: `cargo fuzz run --sanitizer none record` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_harness::run_record(bytes));
