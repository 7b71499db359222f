//! Any flash, any sequence of operations: `cargo fuzz run --sanitizer none store` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| abuse::abuse_store(bytes, |_, _| ()));
