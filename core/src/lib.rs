//! Online self-calibration of stereo extrinsics from left/right correspondences.
//!
//! Per stereo pair two rectifying rotations from row offsets alone, in bounded passes; over pairs an
//! incremental fusion in constant memory. As published ([`Config::paper`]), or so that half of the
//! matches may be wrong ([`Config::robust`]). Method: H. Zhao, Y. Zhang, Q. Chen,
//! R. Fan, "Dive Deeper into Rectifying Homography for Stereo Camera Online Self-Calibration";
//! equation numbers are that paper's.
//!
//! Convention: `p_r = R p_l + t`, `|t| = 1`, camera frames x right, y down, z forward. A plain
//! side-by-side rig has `R = I`, `t = (-1, 0, 0)`. Angles are in rad, image coordinates in px.
//!
//! Start at [`Calibrator`]. Data flows one way: [`Camera`] makes rays of pixels, a [`Batch`] holds
//! them, a solver turns a batch into a [`PairReport`], the reports come to a [`Proposal`], and
//! [`Health`] says whether to rely on it.
//!
//! Beside it stand [`link`], which takes a matcher's frames in, and [`store`], which keeps what was learnt
//! in flash; nothing of the mathematics depends on them.

#![no_std]
#![forbid(unsafe_code)]

// `inline(always)`: the inner loops must be of one piece at opt-level "s" too. `inline(never)`: what
// needs much stack must not lend it to its caller, who would hold it through all other calls.

#[macro_use]
mod error;

mod batch;
mod calibrator;
mod camera;
mod checksum;
#[cfg(feature = "simd")]
mod columns;
mod config;
mod correspondence;
mod estimator;
mod extrinsics;
mod factory;
mod fusion;
mod gate;
mod health;
mod homography;
mod huber;
mod information;
mod lanes;
pub mod link;
mod loss;
pub mod metrics;
mod moments;
mod proposal;
mod quadratic;
mod record;
mod rectification;
mod report;
mod residual;
mod robust;
mod scalar;
mod selection;
pub mod so3;
pub mod store;
mod supervision;
mod symmetric;

pub use batch::{Batch, Pushed};
pub use calibrator::Calibrator;
pub use camera::{Camera, Fisheye, Intrinsics, Lens, RadialTangential};
pub use config::{Central, Config};
pub use correspondence::{Cameras, Correspondence, RayPair};
pub use error::{
    ApplyError, CameraError, ConfigError, ExtrinsicsError, PairError, ProjectError, PushError,
    RectifyError, Refusal, Rejection, RestoreError, Side, SnapshotError, UndistortError,
};
pub use extrinsics::Extrinsics;
pub use factory::FactoryCalibration;
pub use fusion::{FusedEstimate, MeanDirection};
pub use health::{Arming, Band, DEPTHS_M, Health};
pub use homography::RectifiedCamera;
pub use huber::HuberSolver;
pub use information::{Information, StandardDeviations};
pub use proposal::{Direction, Doubt, Proposal};
pub use rectification::RectifyingRotations;
pub use report::{PairReport, Stop};
pub use residual::row_offset;
pub use scalar::Scalar;
pub use supervision::{Fused, State};
