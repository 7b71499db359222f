//! One stereo pair: an M-estimator of the extrinsics from whitened row offsets, one pass at a time.
//!
//! [`constraint`] is the residual, [`loss`] and [`leverage`] weight it, [`sweep`] sums over the batch, [`solver`] steps
//! to the optimum, and [`evaluate`] measures what the batch says there. Derivation: `ESTIMATOR.md`.

mod constraint;
pub(crate) mod evaluate;
mod iterate;
mod leverage;
mod loss;
mod normal_sums;
mod residual_stats;
#[cfg(test)]
mod scenes;
pub(crate) mod solver;
mod survey;
mod sweep;
mod weighting;
