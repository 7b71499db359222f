//! Any bytes as an image: `.ci/fuzz 60 images`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::run_images(bytes));
