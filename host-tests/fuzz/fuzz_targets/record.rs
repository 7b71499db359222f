//! Any bytes as records of what was learnt: `cargo +nightly fuzz run record` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| host_tests::abuse::abuse_record(bytes));
