//! The flash store through its public API, on flash that loses power and rots.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::as_conversions,
    clippy::indexing_slicing,
    reason = "a test that panics is a test that fails"
)]

#[allow(dead_code, reason = "shared with the fuzz harness of the host tests")]
mod flash;

mod cuts;
mod garbage;
mod limits;
mod model;
mod rig;
mod rot;
