//! Geometry of the rig beyond [`Camera`](crate::Camera) and [`Extrinsics`](crate::Extrinsics): lens models,
//! rectification, rotations, error metrics, and the error types of these operations.
//!
//! Frames have x right, y down, z forward. Rays are at unit depth and dimensionless, pixels are in px, angles in rad.

pub(crate) mod camera;
pub(crate) mod cameras;
mod distortion;
pub(crate) mod extrinsics;
pub(crate) mod homography;
pub(crate) mod lens;
pub(crate) mod lens_correction;
pub mod metrics;
pub(crate) mod rational;
pub(crate) mod rectification;
pub mod so3;

pub use crate::error::{
    CameraError, ExtrinsicsError, ProjectError, RectifyError, Side, UndistortError,
};
pub use homography::RectifiedCamera;
pub use lens::{Fisheye, RadialTangential};
pub use lens_correction::LensCorrection;
pub use rational::Rational;
pub use rectification::RectifyingRotations;
