//! The flash store through its public API, on flash that loses power and rots.
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

#[path = "../api/scene.rs"]
mod scene;

mod cuts;
mod garbage;
mod limits;
mod model;
mod persistence;
mod rig;
mod rot;
