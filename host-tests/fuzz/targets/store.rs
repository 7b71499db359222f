//! Any flash, any sequence of operations: `.ci/fuzz 60 store`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = fuzz::run_store(bytes);
});
