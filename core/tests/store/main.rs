//! Flash store through its public API, under loss of power and bit rot.
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
mod faults;
mod faulty;
mod garbage;
mod limits;
mod model;
mod persistence;
mod policy;
mod rig;
mod rot;

/// Whether the tests of cuts and faults run at length, for minutes: where the variable `STORE_CAMPAIGN` is set.
fn is_campaign() -> bool {
    std::env::var_os("STORE_CAMPAIGN").is_some()
}
