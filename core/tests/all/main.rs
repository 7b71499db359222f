//! The core through its public interface, in one program, because each program instantiates the calibrator anew.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::indexing_slicing,
    reason = "a test that panics is a test that fails"
)]

mod api;
mod link;
mod paper;
mod record;
mod store;
