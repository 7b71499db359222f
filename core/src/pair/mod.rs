//! One stereo pair: M-estimator of the extrinsics from whitened row offsets, one pass over the batch at a time.
//!
//! Inputs are the rays of a batch at unit depth, and a start pose with its prior. Outputs are the pose reached, its
//! moments, and residual statistics.
//!
//! - [`constraint`]: residual, its variance and its derivatives. [`loss`], [`leverage`], [`weighting`]: weight of a
//!   residual.
//! - [`pass`]: one loop over the batch, and its sums. [`iterate`]: linearisation point. [`phase`], [`scale`]: loss of
//!   each pass. [`survey`]: first limit on leverage of a track, first scale of a search. [`solver`], [`descent`]:
//!   Levenberg-Marquardt steps. [`proposal`]: second start of a search.
//! - [`evaluate`]: last pass, at the final pose. [`regions`], [`residual_stats`]: sums of the evaluation.
//!
//! Derivation: `ESTIMATOR.md`, sections 2 to 9.

mod constraint;
mod descent;
pub(crate) mod evaluate;
pub(crate) mod iterate;
pub(crate) mod leverage;
mod loss;
mod pass;
mod phase;
mod proposal;
mod regions;
mod residual_stats;
mod scale;
#[cfg(test)]
mod scenes;
pub(crate) mod solver;
mod survey;
mod weighting;
