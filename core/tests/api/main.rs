//! The public API on generated rigs.
#![allow(
    clippy::unwrap_used,
    clippy::as_conversions,
    clippy::cast_precision_loss,
    clippy::indexing_slicing,
    reason = "a test that panics is a test that fails"
)]

mod applying;
mod bad_input;
mod bias;
mod compensation;
mod depth;
mod disturbed;
mod documentation;
mod far;
mod fusion;
mod health;
mod homography;
mod lens;
mod memory;
mod memory_numbers;
mod presets;
mod robust;
mod saving;
mod scene;
mod selection;
#[cfg(feature = "serde")]
mod serialization;
mod solver;
mod supervision;
mod texts;
// The vector lanes add in another order, and powers of the generated depths are those of the platform.
#[cfg(all(not(feature = "simd"), target_env = "gnu"))]
mod traces;
mod turning;
mod vibration;
