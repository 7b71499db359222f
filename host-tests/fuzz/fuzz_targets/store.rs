//! Any flash, any sequence of operations: `cargo fuzz run --sanitizer none store` in `host-tests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzz_harness::run_store(bytes);
});
