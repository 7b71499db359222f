//! Many pairs into one estimate, in constant memory.

mod compensated;
mod information_mean;
mod mean_direction;
mod median;

pub use information_mean::InformationMean;
pub use mean_direction::{FusedEstimate, MeanDirection};

use crate::config::{Config, Method};
use crate::extrinsics::Extrinsics;
use crate::report::PairReport;
use crate::scalar::Scalar;

/// The fusion that the configuration names.
#[derive(Debug, Clone)]
pub(crate) enum Fusion<T: Scalar> {
    MeanDirection(MeanDirection<T>),
    Information(InformationMean<T>),
}

impl<T: Scalar> Fusion<T> {
    /// No pairs yet, and no prior: [`Fusion::restart`] comes before the first.
    pub(crate) const fn new(config: &Config) -> Self {
        match config.method {
            Method::Paper => Self::MeanDirection(MeanDirection::new(config.angle)),
            Method::Robust => Self::Information(InformationMean::new()),
        }
    }

    /// No pairs, and the factory extrinsics as the prior.
    pub(crate) fn restart(config: &Config, factory: &Extrinsics<T>) -> Self {
        match config.method {
            Method::Paper => Self::new(config),
            Method::Robust => {
                let sd = T::lit(config.prior_sd_rad.into());
                Self::Information(InformationMean::from_prior(*factory, sd))
            }
        }
    }

    /// Whether the pair was taken.
    pub(crate) fn add(&mut self, report: &PairReport<T>) -> bool {
        match self {
            Self::MeanDirection(fusion) => {
                fusion.add(report);
                true
            }
            Self::Information(fusion) => fusion.add(report),
        }
    }

    pub(crate) fn pairs(&self) -> u32 {
        match self {
            Self::MeanDirection(fusion) => fusion.pairs(),
            Self::Information(fusion) => fusion.pairs(),
        }
    }

    pub(crate) fn estimate(&self) -> Option<FusedEstimate<T>> {
        match self {
            Self::MeanDirection(fusion) => fusion.estimate(),
            Self::Information(fusion) => fusion.estimate(),
        }
    }
}
