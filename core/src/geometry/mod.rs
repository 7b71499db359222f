//! Cameras, rotations, extrinsics, and their rectification.

pub(crate) mod camera;
pub(crate) mod extrinsics;
pub(crate) mod homography;
pub(crate) mod lens;
pub mod metrics;
pub(crate) mod rectification;
pub mod so3;
