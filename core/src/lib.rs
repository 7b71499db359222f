//! Tracks the extrinsics of a stereo rig online, from left/right correspondences: `no_std`, no heap, fixed capacity.
//!
//! Each stereo pair gives two rectifying rotations from the row offsets of its correspondences, in a bounded number of
//! passes. An incremental fusion in constant memory combines the pairs. Two presets: [`Config::robust`], for up to half
//! outliers, and [`Config::paper`], the method as published by H. Zhao, Y. Zhang, Q. Chen, R. Fan, "Dive Deeper into
//! Rectifying Homography for Stereo Camera Online Self-Calibration". Equation numbers are that paper's; [`derivation`]
//! derives the robust preset.
//!
//! # The walk
//!
//! ```text
//! pixels -> Camera      undistorted rays; cameras and extrinsics: FactoryCalibration
//!        -> Batch       up to N correspondences of one stereo pair, selected; Calibrator::push
//!        -> pair        R, t of the batch, with their information: PairReport
//!        -> fusion      the estimate over all pairs: Proposal; Calibrator::solve_pair takes both steps
//!        -> check       residuals in use and proposed, arming: Health; Calibrator::health
//!        -> apply       the estimate is put into use: Calibration; Calibrator::apply
//!        -> rectifier   Calibration::homographies
//! ```
//!
//! Estimating never changes the extrinsics in use; [`Calibrator::apply`] does. [`link`] receives a matcher's frames and
//! [`store`] keeps records in flash; the estimator depends on neither.
//!
//! # Example
//!
//! One stereo pair. `examples/minimal.rs` is a complete program.
//!
//! ```
//! use stereo_selfcal::{Calibration, Calibrator, Correspondence};
//!
//! /// Takes one stereo pair; the calibration to rectify with.
//! fn on_pair<const N: usize>(
//!     calibrator: &mut Calibrator<f32, N>,
//!     matches: &[Correspondence<f32>],
//! ) -> Calibration<f32> {
//!     // Too few, no consensus, rejected: the state may have changed, what is in use has not.
//!     log(&calibrator.take_pair(matches.iter().copied()));
//!     match calibrator.health() {
//!         Ok(health) => log(&health),
//!         Err(none) => log(&none),
//!     }
//!     if let Err(why) = calibrator.apply() {
//!         log(&why); // normal until four pairs agree
//!     }
//!     calibrator.in_use() // its generation tells whether it has changed
//! }
//! # fn log(_: &dyn core::fmt::Display) {}
//! ```
//!
//! # Conventions
//!
//! * Extrinsics: `p_r = R p_l + t`, `|t| = 1`; `p_l`, `p_r` are one point in the left and the right camera frame. A
//!   plain side-by-side rig has `R = I`, `t = (-1, 0, 0)`. The length of the baseline is not observable.
//! * Camera frame: x right, y down, z forward.
//! * Pixels: of the image before undistortion; `(0, 0)` is the centre of the top left pixel, u right, v down. Lens
//!   models and coefficients are OpenCV's.
//! * Units: px in the image, rad for angles; a name ends with its unit where the unit is not obvious.
//! * Scalar: `f32` ships, `f64` is the reference. The same input gives the same bits on every target.
//! * [`nalgebra`] is part of the public API and is re-exported.
//!
//! # Errors and actions
//!
//! Every error is a small `Copy` enum, one per operation, with `Display`, [`core::error::Error`] and a stable number
//! `code()`. No error changes the extrinsics in use.
//!
//! | error | of | action |
//! |---|---|---|
//! | [`ConfigError`] | `Config::with_*` | Correct the named parameter. In a `const` it fails the build. |
//! | [`CameraError`] | [`Camera::try_new`] | Correct the named quantity. |
//! | [`ExtrinsicsError`] | [`Extrinsics::try_new`] | Correct `R` or `t`; a baseline along an optical axis cannot be rectified. |
//! | [`UndistortError`] | [`Camera::ray`] | Drop the correspondence. |
//! | [`ProjectError`] | [`Camera::pixel`] | Drop the ray: it is beyond the lens model. |
//! | [`PushError`] | [`Calibrator::push`] | `Pixel`, `Score`, `GridStep`: drop the correspondence; many of them: wrong cameras. `Busy`: finish or discard the pair. |
//! | [`Rejection`] | [`Calibrator::solve_pair`], in [`Outcome`] and [`Health`] | Take the next pair. `Behind`: the cameras or `t` are exchanged, or an image is mirrored. `CorrectionLimit` again and again: factory values or mounting. `Frozen`: intended. |
//! | [`NoHealth`] | [`Calibrator::health`] | Take more pairs; its cause, if any, is the likeliest mistake. |
//! | [`ApplyError`] | [`Calibrator::apply`] | `NoProposal`, `NotLocked`: fuse more pairs. `Doubtful`, `Inconsistent`: look for biased matches or wrong intrinsics. `NothingToUndo`, `Frozen`: nothing to do. |
//! | [`RectifyError`] | [`RectifiedCamera::try_choose`] | Correct `alpha`, or keep the last rectification: the rig has no common view. |
//! | [`RestoreError`] | [`Calibrator::restore`], [`store::Store::resume`] | Go on: the calibrator starts from the factory calibration. |
//! | [`link::ReceiveError`], [`link::FrameRefusal`] | drivers of a matcher | Call again; the decoder resynchronises. `ImageSize`: the cameras set are of another image. |
//! | [`link::HeaderError`], [`link::RecordError`], [`link::Damage`] | decoding | Skip the frame; [`link::Counters`] count it. |
//! | [`link::EncodeError`] | encoding | Correct the named quantity of the sender. |
//! | [`store::StoreError`] | the store | `Range`, `Alignment`: correct the ranges. Else: go on without; the record before remains, and the save is due again later. |
//!
//! # Real time
//!
//! Every call returns after a bounded number of operations. Between two calls of a pair the caller may do anything
//! else; a call itself only computes, and interrupts may preempt it. Instructions of a Cortex-M4F in `f32`, built for
//! speed, 256 correspondences of which 30 % are outliers, the most that was measured:
//!
//! | call | instructions | calls |
//! |---|---|---|
//! | decode and [`Calibrator::push`] | 600 in the mean, 1,700; 7,000 with all matches in one place | one a match |
//! | [`Calibrator::advance_pair`], the first one | 70,000 | one a pair |
//! | [`Calibrator::advance_pair`], a pass | 120,000; in a track 34,000 | 2 in a track, in a search up to [`Config::with_max_passes`] |
//! | [`Calibrator::advance_pair`], the last pass | 160,000 | one a pair |
//! | [`Calibrator::advance_pair`], the fusion | 125,000 | one a pair |
//! | [`Calibrator::health`], [`Calibrator::apply`] | 100,000, 50,000 | as needed |
//!
//! * Locked, a frame of 1,000 matches takes 0.76 million from its first byte to its outcome: 0.45 million to decode and
//!   select, 0.31 million for the pair. While acquiring 1.84 million; a batch of mismatches alone, 1.22 million for the
//!   pair.
//! * Slices: call `advance_pair` once per period until it returns an outcome. The
//!   longest call then decides the time slice. The result is that of [`Calibrator::solve_pair`], bit for bit.
//! * A frame that comes before the last pair is done: a driver of [`link`] reads nothing, and the sender keeps its
//!   frame; without a driver `push` returns [`PushError::Busy`], and a decoder
//!   [`link::FrameRefusal::Busy`], once a frame. The pair goes on. [`Calibrator::discard_pair`] gives it up instead;
//!   the estimate stays as it is. A frame left out is only a pair less.
//!
//! # Glossary
//!
//! | term | meaning |
//! |---|---|
//! | pair | One stereo image pair: its correspondences in the [`Batch`], and their solution, [`PairReport`]. |
//! | pass | One read of the whole batch: the unit of time of a solve. |
//! | search, track | Solve from far, by an annealed loss; solve near a hypothesis, in 4 passes. |
//! | factory | Extrinsics that the rig left production with: start, prior, and centre of the correction limit. |
//! | calibration | Extrinsics, and the cameras that they belong to: as given, or corrected ([`LensTracking::Compensate`]). |
//! | in use | Calibration that the caller rectifies with, as of the last [`Calibrator::apply`]. |
//! | generation | Number that changes exactly when the extrinsics in use, or the correction of their cameras, do. |
//! | proposal | The estimate over all fused pairs, not in use yet. |
//! | hypothesis | Extrinsics with the sums of the pairs that support them. |
//! | champion | The hypothesis that is reported, once four pairs agree. |
//! | challenger | The hypothesis of pairs outside the champion's gate. Three pairs that show another rig promote it. |
//! | baseline observed | The pairs have determined `t`, and not `R` alone: near points, or many pairs. |
//! | high leverage | Share of a correspondence in the information on `t` far above the usual: near points, or outliers. |
//! | repeated scene | A pair with the matches of the pair before it, as of a vehicle at rest: it replaces that pair. |
//! | image halves | Two halves of the image, estimated apart: their disagreement shows biased matches ([`Doubt`]). |
//! | screened | Within the threshold of the residual: counted as an inlier. |
//! | band, arming | Verdict on the row offset in use; yes or no to an arming check. |
//!
//! # Features
//!
//! | feature | effect |
//! |---|---|
//! | `paper` (default) | The published method, `Config::paper`. Without it a firmware saves flash. |
//! | `defmt` | `defmt::Format` for every result and error. |
//! | `serde` | `Serialize` and `Deserialize` for parameters, cameras, extrinsics and results, as plain arrays; what is read is checked. |
//! | `async` | [`link::FpgaMatcher`] over `embedded-hal-async`. |
//!
//! Minimum supported Rust version: 1.89.

#![no_std]
#![forbid(unsafe_code)]

// `inline(always)`: a part of an inner loop that opt-level "s" leaves out of line. Its call costs instructions for each
// correspondence, and a sum whose address it takes leaves the registers. `cargo controller-cost` shows which parts
// need it. `inline(never)`: a function that needs much stack. Inlined, it would hold that stack through all other calls
// of its caller.

#[macro_use]
mod error;

mod algebra;
mod batch;
mod calibrator;
mod checksum;
mod config;
mod depth;
mod fusion;
mod geometry;
pub mod link;
mod outcome;
mod pair;
#[cfg(feature = "paper")]
mod paper;
mod record;
mod scalar;
mod state;
pub mod store;
mod thresholds;

#[doc = include_str!("../ESTIMATOR.md")]
pub mod derivation {}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

pub use nalgebra;

pub use algebra::information::{Information, StandardDeviations};
pub use batch::correspondence::{Cameras, Correspondence, RayPair};
pub use batch::row_offset::row_offset;
pub use batch::{Batch, Pushed};
pub use calibrator::{Calibration, Calibrator};
pub use config::{Central, Config, LensPrior, LensTracking};
pub use depth::mount::Witnessed;
pub use depth::range::{Range, RangeReading};
pub use error::{
    ApplyError, CameraError, ConfigError, ExtrinsicsError, MotionError, ProjectError, PushError,
    RangeError, RectifyError, Rejection, RestoreError, Side, UndistortError,
};
pub use geometry::camera::{Camera, Intrinsics};
pub use geometry::extrinsics::Extrinsics;
pub use geometry::homography::RectifiedCamera;
pub use geometry::lens::{Fisheye, Lens, RadialTangential};
pub use geometry::lens_correction::LensCorrection;
pub use geometry::rational::Rational;
pub use geometry::rectification::RectifyingRotations;
pub use geometry::{metrics, so3};
pub use outcome::cause::Cause;
pub use outcome::health::{Arming, Band, DEPTHS_M, Health, NoHealth};
pub use outcome::lens_estimate::{Finding, LensEstimate};
pub use outcome::pair_report::{Fused, Outcome, PairReport};
pub use outcome::proposal::{Direction, Doubt, Proposal};
pub use outcome::reasons::{Reason, Reasons};
pub use outcome::vibration::Vibration;
#[cfg(feature = "paper")]
pub use paper::mean_direction::{FusedEstimate, MeanDirection};
#[cfg(feature = "paper")]
pub use paper::solver::HuberSolver;
pub use record::factory::FactoryCalibration;
pub use scalar::Scalar;
pub use state::{State, Stop};
