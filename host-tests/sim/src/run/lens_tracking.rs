//! Treatment of the lens models in a run.

use stereo_selfcal::Config;
use strum::{Display, EnumMessage, EnumString, VariantArray};

/// Treatment of the lens models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display, EnumMessage, EnumString, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum LensTracking {
    /// Exact: no deviation covers an error of the lens.
    Given,
    /// Uncertain: errors of the lens are estimated, reported, and widen the deviations; R and t belong to the given
    /// lens.
    Report,
    /// Uncertain and corrected: differences of focal length and of k1 are compensated if that halves the deviation of
    /// t; R and t belong to the corrected cameras.
    Compensate,
}

impl LensTracking {
    /// The robust preset with this treatment.
    pub fn config(self) -> Config {
        match self {
            Self::Given => Config::robust().without_lens_prior(),
            Self::Report => Config::robust(),
            Self::Compensate => {
                Config::robust().with_lens_tracking(stereo_selfcal::LensTracking::Compensate)
            }
        }
    }
}
