//! Stereo images to matches: readers of folders and bags, the matcher, a run over them, and pictures before and after.
//!
//! [`source`] finds pairs in folders and bags, [`picture`] decodes an image: a new format of images is a feature of the
//! crate `image`, and an ending in `source/folders.rs`. [`matcher`] matches a pair, [`pipeline`] many at a time;
//! [`session`] feeds them to the calibrator, and [`verdict`] judges the rig. [`pictures`] draws rectified pairs.
#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    reason = "only this workspace uses the package"
)]
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
