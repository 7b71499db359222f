//! Interface of the methods to a run, and when a run applies the estimate.

use std::fmt;

use stereo_selfcal::depth::RangeReading;
use strum::{Display, EnumMessage, EnumString, VariantArray};

use super::log::RunLog;
use rigs::data::Match;
use rigs::data::tracked::Track;

/// When the estimate is applied.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Display, EnumMessage, EnumString, VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Apply {
    /// Never: the extrinsics of the start stay in use.
    #[default]
    Never,
    /// After every pair, as on a vehicle.
    Each,
}

/// Takes pairs, and records the results in a log.
#[doc(hidden)]
pub trait Replayed: fmt::Debug + Send {
    /// Solves and fuses a pair, and takes the range readings and tracks that come with it.
    fn take(
        &mut self,
        pair: &[Match],
        with: (&[RangeReading<f64>], &[Track]),
        apply: Apply,
        log: &mut RunLog,
    );
}
