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

mod algebra;
mod batch;
mod calibrator;
mod codec;
mod config;
mod estimator;
mod fusion;
mod geometry;
pub mod link;
mod outcome;
mod pair;
#[cfg(feature = "paper")]
mod paper;
mod scalar;
mod simd;
mod snapshot;
mod state;
pub mod store;
mod thresholds;

pub use nalgebra;

pub use algebra::information::{Information, StandardDeviations};
pub use batch::correspondence::{Cameras, Correspondence, RayPair};
pub use batch::row_offset::row_offset;
pub use batch::{Batch, Pushed};
pub use calibrator::Calibrator;
pub use config::{Central, Config};
pub use error::{
    ApplyError, CameraError, ConfigError, ExtrinsicsError, PairError, ProjectError, PushError,
    RectifyError, Refusal, Rejection, RestoreError, Side, SnapshotError, UndistortError,
};
pub use geometry::camera::{Camera, Intrinsics};
pub use geometry::extrinsics::Extrinsics;
pub use geometry::homography::RectifiedCamera;
pub use geometry::lens::{Fisheye, Lens, RadialTangential};
pub use geometry::rectification::RectifyingRotations;
pub use geometry::{metrics, so3};
pub use outcome::health::{Arming, Band, DEPTHS_M, Health};
pub use outcome::pair_report::{Fused, PairReport};
pub use outcome::proposal::{Direction, Doubt, Proposal};
#[cfg(feature = "paper")]
pub use paper::mean_direction::{FusedEstimate, MeanDirection};
#[cfg(feature = "paper")]
pub use paper::solver::HuberSolver;
pub use scalar::Scalar;
pub use snapshot::factory::FactoryCalibration;
pub use state::{State, Stop};
