//! Parts of the results: of [`PairReport`](crate::PairReport), [`Proposal`](crate::Proposal) and
//! [`Health`](crate::Health).

pub(crate) mod cause;
pub(crate) mod health;
pub(crate) mod lens_estimate;
pub(crate) mod pair_report;
pub(crate) mod proposal;
pub(crate) mod reasons;
pub(crate) mod relief;
mod robust_rms;
pub(crate) mod vibration;

pub use crate::algebra::information::{Information, StandardDeviations};
pub use crate::state::Stop;
pub use health::DEPTHS_M;
pub use lens_estimate::{Finding, LensEstimate};
pub use proposal::Direction;
pub use vibration::Vibration;
