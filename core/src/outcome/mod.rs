//! Parts of the results: of [`PairReport`](crate::PairReport), [`Proposal`](crate::Proposal) and
//! [`Verdict`](crate::Verdict). [`History`] keeps the changes of a verdict.

pub(crate) mod cause;
pub(crate) mod details;
mod history;
pub(crate) mod judge;
pub(crate) mod lens_estimate;
mod pair_fit;
pub(crate) mod pair_report;
pub(crate) mod proposal;
pub(crate) mod reasons;
pub(crate) mod recent;
pub(crate) mod relief;
mod robust_rms;
mod rows_of;
pub(crate) mod verdict;
pub(crate) mod vibration;

pub use crate::algebra::information::{Information, StandardDeviations};
pub use crate::state::Stop;
pub use details::{DEPTHS_M, Details};
pub use history::{Change, Changes, Event, History};
pub use lens_estimate::{Finding, LensEstimate};
pub use proposal::Direction;
pub use vibration::Vibration;
