//! The public API on generated rigs.

mod bad_input;
mod fusion;
mod homography;
mod scene;
mod solver;
