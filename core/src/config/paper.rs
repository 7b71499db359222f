//! Parameters of the published method alone.

use crate::error::ConfigError;

/// Central tendency of the angles of the pairs' rotations, `s*` of eq 22.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Central {
    /// Arithmetic mean: efficient where no pair is grossly wrong.
    Mean,
    /// Median: unmoved by a minority of wrong pairs; exact up to 31 pairs, then a streaming
    /// estimate in constant memory.
    Median,
}

/// Parameters of the published method alone: [`crate::Config::with_paper`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    pub(crate) step_tolerance_rad: f32,
    pub(crate) angle: Central,
    pub(crate) max_sd_rad: f32,
}

impl Settings {
    /// The defaults.
    pub const DEFAULT: Self =
        Self { step_tolerance_rad: 1e-9, angle: Central::Mean, max_sd_rad: 0.12 };

    /// The solver has converged when its step is below this, rad. Default 1e-9.
    ///
    /// Never taken as smaller than 8 units in the last place of 1: 1e-6 rad in `f32`.
    ///
    /// # Errors
    /// [`ConfigError::StepTolerance`] unless from 0 to 0.1.
    pub const fn with_step_tolerance_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.step_tolerance_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::StepTolerance)
        }
    }

    /// Mean or median of the angles in fusion (eq 22). Default mean.
    #[must_use]
    pub const fn with_angle(mut self, angle: Central) -> Self {
        self.angle = angle;
        self
    }

    /// The gate refuses a pair whose weakest direction has a larger standard deviation than this, rad. Default 0.12.
    ///
    /// # Errors
    /// [`ConfigError::MaxStandardDeviation`] unless finite and above 0.
    pub const fn with_max_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad.is_finite() {
            self.max_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxStandardDeviation)
        }
    }

    /// The same parameters, if each is within its range.
    #[cfg(feature = "serde")]
    pub(crate) fn checked(self) -> Result<Self, ConfigError> {
        self.with_step_tolerance_rad(self.step_tolerance_rad)?.with_max_sd_rad(self.max_sd_rad)
    }
}
