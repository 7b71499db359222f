//! Stereo images to matches: readers of folders and bags, the matcher, a run over them, and pictures before and after.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "arithmetic of pixels: sides are below 2^16, checked where a picture is made"
)]

pub mod coverage;
pub mod matcher;
pub mod moments;
pub mod picture;
pub mod pictures;
pub mod pipeline;
pub mod resized;
pub mod rig;
pub mod score;
pub mod session;
pub mod shipped;
pub mod source;
pub mod verdict;
