//! Tracks the extrinsics of a stereo rig online, from left/right correspondences: `no_std`, no heap, fixed capacity.
//!
//! The row offsets of the correspondences of a stereo pair give two rectifying rotations, in a bounded number of
//! passes. An incremental fusion in constant memory combines the pairs. Up to half of the matches may be outliers.
//! [`derivation`] derives the estimator. Module `paper` has the method as published by H. Zhao, Y. Zhang, Q. Chen,
//! R. Fan, "Dive Deeper into Rectifying Homography for Stereo Camera Online Self-Calibration", on which it builds.
//! Equation numbers refer to that paper.
//!
//! # Data flow
//!
//! ```text
//! FactoryCalibration   cameras, and the extrinsics of production or a guess: where everything starts
//! pixels -> batch      undistorted to rays, up to N kept: Calibrator::push
//!        -> pair       R, t of the batch, with their information: PairReport
//!        -> estimate   over all pairs: Proposal. Calibrator::solve_pair takes both steps and returns an Outcome
//!        -> check      rows, depth and coverage in use, whether the rig may arm, and why not: Verdict
//!        -> apply      the estimate is put into use: Calibrator::apply returns a Calibration
//!        -> rectifier  Calibration::homographies
//! ```
//!
//! Estimating never changes the extrinsics in use; only [`Calibrator::apply`], [`Calibrator::undo`],
//! [`Calibrator::reset`] and a restore ([`Calibrator::restore`], [`store::Store::resume`]) change them. A firmware
//! loads [`Calibrator::in_use`] at start, before any pair has come. [`link`] receives a matcher's frames and [`store`]
//! keeps records in flash; the estimator depends on neither.
//!
//! # Modules
//!
//! The root of the crate has the names that a firmware needs. [`geometry`] has lens models, rectification and
//! rotations; [`batch`] has the correspondences that are held; [`outcome`] has parts of the results; [`depth`] has the
//! witnesses of a known distance and of a motion; [`link`] receives from a matcher; [`store`] writes to flash; `paper`
//! has the published method.
//!
//! # Example
//!
//! One stereo pair. `examples/minimal.rs` is a complete program.
//!
//! ```
//! use stereo_selfcal::{Calibration, Calibrator, Correspondence};
//!
//! /// Takes one stereo pair; returns the calibration to rectify with.
//! fn on_pair<const N: usize>(
//!     calibrator: &mut Calibrator<f32, N>,
//!     matches: &[Correspondence<f32>],
//! ) -> Calibration<f32> {
//!     // A pair that is not fused is normal, and never changes the calibration in use.
//!     log(&calibrator.take_pair(matches.iter().copied()));
//!     log(calibrator.verdict());
//!     if calibrator.verdict().should_apply {
//!         let _ = calibrator.apply();
//!     }
//!     calibrator.in_use() // its generation tells whether it has changed
//! }
//! # fn log(_: &dyn core::fmt::Display) {}
//! ```
//!
//! # Conventions
//!
//! * Extrinsics: `p_r = R p_l + t`, `|t| = 1`; `p_l`, `p_r` are the same point in the left and in the right camera
//!   frame. A plain side-by-side rig has `R = I`, `t = (-1, 0, 0)`. The length of the baseline is not observable.
//! * Camera frame: x right, y down, z forward.
//! * Pixels: in the image before undistortion; `(0, 0)` is the centre of the top left pixel, u right, v down. Lens
//!   models and coefficients are OpenCV's.
//! * Units: px in the image, rad for angles; a name ends with its unit where the unit is not obvious.
//! * Scalar: `f32` in products, `f64` as the reference for tests. The same input gives the same bits on every target.
//! * [`nalgebra`] is part of the public API and is re-exported.
//!
//! # Errors and actions
//!
//! Each operation has one error: a small `Copy` enum with `Display`, [`core::error::Error`] and a number `code()`. An
//! error that several operations return has the same number in all of them. No error changes the extrinsics in use,
//! except an error of [`Calibrator::restore`] or [`store::Store::resume`], which puts the factory calibration into use.
//!
//! | error | returned by | action |
//! |---|---|---|
//! | [`ConfigError`] | `with_*` of [`Config`], [`FactoryCalibration`] and `paper::Settings` | Correct the named parameter. In a `const` it can fail the build. |
//! | [`geometry::CameraError`] | [`Camera::try_new`], `try_new` of the lens models, [`Cameras::corrected`] | Correct the named quantity. |
//! | [`geometry::ExtrinsicsError`] | [`Extrinsics::try_new`], [`Extrinsics::from_row_major`] | Correct `R` or `t`; a baseline along an optical axis cannot be rectified. |
//! | [`geometry::UndistortError`] | [`Camera::ray`] | Drop the correspondence. |
//! | [`geometry::ProjectError`] | [`Camera::pixel`] | Drop the ray: it is beyond the lens model. |
//! | [`PushError`] | [`Calibrator::push`] | `Pixel`, `Score`, `GridStep`: drop the correspondence; if there are many of `Pixel`, the cameras are wrong. `Busy`: finish or discard the pair. |
//! | [`Rejection`] | [`Calibrator::solve_pair`], in [`Outcome`] | Take the next pair. `Behind`: left and right are exchanged, `t` has the wrong sign, or an image is mirrored. `CorrectionLimit` again and again: check factory values and mounting. `Frozen`: intended. |
//! | [`ApplyError`] | [`Calibrator::apply`], [`Calibrator::undo`] | `NoProposal`, `NotLocked`: take more pairs. `Doubtful`, `Inconsistent`: look for biased matches or wrong intrinsics. `NothingToUndo`, `Frozen`: nothing to do. |
//! | [`geometry::RectifyError`] | [`Calibration::homographies`] | Correct `alpha`, or keep the last rectification: the rig has no common view. |
//! | [`depth::RangeError`], [`depth::MotionError`] | [`Calibrator::push_range`], [`Calibrator::push_tracks`] | `NoBaseline`: set [`FactoryCalibration::with_baseline_m`]. `Reading`, `Pixel`: drop the reading. `Contradicts` again and again: check the sensor and its scale. All others: measure again later. |
//! | [`RestoreError`] | [`Calibrator::restore`], [`store::Store::resume`] | Continue: the calibrator starts from the factory calibration. |
//! | [`RestoreError`] | [`FactoryCalibration::from_record`], [`store::Store::load_factory`] | Calibrate the rig again, or start from [`FactoryCalibration::guess`]. |
//! | [`link::ReceiveError`], [`link::FrameRefusal`] | drivers of a matcher | Call again; the decoder resynchronises. `ImageSize`: the calibrator has cameras of another image size. |
//! | [`link::HeaderError`] | decoding | Skip the frame; [`link::Counters`] count it. |
//! | [`link::EncodeError`] | encoding | Correct the named quantity of the sender. |
//! | [`store::StoreError`] | the store | `Range`: correct the ranges. Otherwise: continue without saving; the previous record remains, and the save is due again later. |
//!
//! # Real time
//!
//! Every call returns after a bounded number of operations. Between two calls of a pair the caller may do anything
//! else; a call itself only computes, and interrupts may preempt it. The table has the largest measured numbers of
//! instructions on a Cortex-M4F, in `f32`, built for speed, with 256 correspondences of which 30 % are outliers:
//!
#![doc = include_str!("../docs/real-time.md")]
//! * Slices: call `advance_pair` once per period until it returns an outcome. The longest call decides the time slice.
//!   The result equals the result of [`Calibrator::solve_pair`], bit for bit.
//! * A frame may come before the last pair is done. A driver of [`link`] then reads nothing, and the sender keeps the
//!   frame. Without a driver, `push` returns [`PushError::Busy`], and a decoder returns [`link::FrameRefusal::Busy`]
//!   once per frame. The pair continues; [`Calibrator::discard_pair`] abandons it. The estimate stays unchanged if the
//!   pair has not been fused yet. A frame that is left out costs one pair.
//!
//! # Features
//!
//! | feature | effect |
//! |---|---|
//! | `defmt` | `defmt::Format` for every result and error. |
//! | `serde` | `Serialize` and `Deserialize` for parameters, cameras, extrinsics and results; [`Calibration`] has only `Serialize`. Matrices and lens coefficients are plain arrays. A [`Config`], a [`FactoryCalibration`], a [`Camera`], a lens model and [`Extrinsics`] that are read are checked. |
//! | `async` | [`link::FpgaMatcher`] over `embedded-hal-async`. |
//!
//! Minimum supported Rust version: 1.89.
//!
//! # Glossary
//!
//! Terms of this crate. All other terms have their usual meaning in the field.
//!
//! | term | meaning |
//! |---|---|
//! | pair | One stereo image pair: the correspondences of the batch, and the extrinsics that solve them. |
//! | pass | One read of the batch, or of a sample of it: the unit of time of a solve. |
//! | search, track | Search: a solve from far away, by an annealed loss. Track: a solve near a known estimate, in 4 passes. |
//! | factory | Calibration that the rig left production with, or a guess: start, prior, and centre of the correction limit. |
//! | in use | Calibration that the caller rectifies with. [`Calibrator::apply`] changes it; a change also changes its generation number. |
//! | proposal | The estimate over all fused pairs, which `apply` puts into use. |
//! | challenger | A second estimate, from pairs that disagree with the reported one. If three pairs show another rig, it replaces the reported one. |
//! | key frame | The last pair that was added. A later pair counts by how far the scene has moved since then. |
//! | repeated scene | A pair whose scene has hardly moved since the key frame: the vehicle is at rest. Such a pair adds no information. |
//! | local scale | Length of a pixel at unit depth times the focal length: 1 for a pinhole, more towards the border of a wide-angle lens. |
//! | witness | A measurement of the yaw of the mount alone: a known distance, or tracked matches of a rig that moves. |

#![no_std]
#![forbid(unsafe_code)]

// `inline(always)` marks a part of an inner loop that opt-level "s" would leave out of line. A call would cost
// instructions for each correspondence, and a sum whose address is passed would leave the registers.
// `cargo controller-cost` shows which parts need it. On a constructor, it lets the value be written in place. `inline(never)`
// marks a function that needs much stack, or one that several functions call. Inlined, the former would hold its stack
// during all other calls of its caller, and the latter would exist several times in flash.

#[macro_use]
mod named;

mod algebra;
pub mod batch;
mod calibrator;
mod checksum;
mod config;
pub mod depth;
mod error;
mod fusion;
pub mod geometry;
pub mod link;
pub mod outcome;
mod pair;
pub mod paper;
mod record;
mod scalar;
mod state;
pub mod store;
mod thresholds;

#[doc = include_str!("../ESTIMATOR.md")]
#[doc = include_str!("../docs/tried.md")]
#[doc = include_str!("../docs/thresholds.md")]
pub mod derivation {}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/controller.md")]
#[doc = include_str!("../docs/crate.md")]
#[doc = include_str!("../docs/depth.md")]
mod pages {}

pub use nalgebra;

pub use algebra::lens_prior::LensPrior;
pub use batch::correspondence::Correspondence;
#[doc(hidden)]
pub use calibrator::has_valid_lengths;
pub use calibrator::{Calibration, Calibrator};
pub use config::{Config, LensTracking};
pub use error::{ApplyError, ConfigError, PushError, Rejection, RestoreError};
pub use geometry::camera::{Camera, Intrinsics};
pub use geometry::cameras::Cameras;
pub use geometry::extrinsics::Extrinsics;
pub use geometry::lens::Lens;
pub use outcome::cause::Cause;
pub use outcome::pair_report::{Fused, Outcome, PairReport};
pub use outcome::proposal::Proposal;
pub use outcome::reasons::{Reason, Reasons};
pub use outcome::verdict::Verdict;
pub use record::factory::FactoryCalibration;
pub use scalar::Scalar;
pub use state::State;
