//! Results: of one pair, of all pairs, and how far to rely on them.

pub(crate) mod cause;
pub(crate) mod health;
pub(crate) mod lens_estimate;
pub(crate) mod pair_report;
pub(crate) mod proposal;
pub(crate) mod reasons;
mod robust_rms;
pub(crate) mod vibration;
