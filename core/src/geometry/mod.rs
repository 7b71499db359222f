//! Geometry of the rig: cameras, lens models, rotations, extrinsics, rectification.
//!
//! Frames: x right, y down, z forward. Rays at unit depth, dimensionless; pixels in px, angles in rad.

pub(crate) mod camera;
mod distortion;
pub(crate) mod extrinsics;
pub(crate) mod homography;
pub(crate) mod lens;
pub(crate) mod lens_correction;
pub mod metrics;
pub(crate) mod rational;
pub(crate) mod rectification;
pub mod so3;
