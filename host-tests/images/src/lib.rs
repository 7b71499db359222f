//! Stereo images to correspondences: readers of folders and bags, the matcher, and the image commands of
//! `selfcal`.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "arithmetic of pixels: sides are below 2^16, checked where a picture is made"
)]

mod cli;
pub mod coverage;
pub mod live;
pub mod made;
pub mod matcher;
pub mod measure;
pub mod moments;
pub mod page;
pub mod picture;
pub mod pipeline;
pub mod resized;
pub mod rig;
pub mod score;
pub mod session;
pub mod shipped;
pub mod source;
pub mod verdict;

pub use cli::Command;
