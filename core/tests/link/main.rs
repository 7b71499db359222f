//! Frames over the wire: what is sent comes in, and damage costs no frame but those it touched.
#![allow(
    clippy::unwrap_used,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "a test that panics is a test that fails"
)]

mod counters;
mod stream;
