//! Parameters that only the published method has.

use crate::error::ConfigError;

/// Central tendency `s*` of the rotation angles of the pairs (eq 22).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Central {
    /// Arithmetic mean: efficient where no pair is grossly wrong.
    Mean,
    /// Median: a minority of wrong pairs hardly moves it. It is exact up to 31 pairs, then a streaming estimate in
    /// constant memory.
    Median,
}

/// Parameters that only the published method has: [`crate::Config::with_paper`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts"))]
pub struct Settings {
    pub(crate) step_tolerance_rad: f32,
    pub(crate) angle: Central,
    pub(crate) max_sd_rad: f32,
}

/// Unchecked fields from which settings are deserialised.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Parts {
    step_tolerance_rad: f32,
    angle: Central,
    max_sd_rad: f32,
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for Settings {
    type Error = ConfigError;

    fn try_from(
        Parts { step_tolerance_rad, angle, max_sd_rad }: Parts,
    ) -> Result<Self, ConfigError> {
        let settings = Self { angle, ..Self::DEFAULT };
        settings.with_step_tolerance_rad(step_tolerance_rad)?.with_max_sd_rad(max_sd_rad)
    }
}

impl Settings {
    /// The defaults.
    pub const DEFAULT: Self =
        Self { step_tolerance_rad: 1e-9, angle: Central::Mean, max_sd_rad: 0.12 };

    /// Sets the step tolerance, rad: the solver has converged if the largest component of an accepted step with low
    /// damping is at most this. Default 1e-9.
    ///
    /// The solver uses at least 8 units in the last place of 1: 1e-6 rad in `f32`.
    ///
    /// # Errors
    /// [`ConfigError::StepTolerance`] if the value is outside 0 to 0.1.
    pub const fn with_step_tolerance_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad >= 0.0 && rad <= 0.1 {
            self.step_tolerance_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::StepTolerance)
        }
    }

    /// Sets the average of the rotation angles in fusion (eq 22): mean or median. Default mean.
    #[must_use]
    pub const fn with_angle(mut self, angle: Central) -> Self {
        self.angle = angle;
        self
    }

    /// Sets the largest standard deviation of the weakest direction of a pair, rad. The gate refuses pairs above it.
    /// Default 0.12.
    ///
    /// # Errors
    /// [`ConfigError::MaxStandardDeviation`] unless the value is finite and above 0.
    pub const fn with_max_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if rad > 0.0 && rad.is_finite() {
            self.max_sd_rad = rad;
            Ok(self)
        } else {
            Err(ConfigError::MaxStandardDeviation)
        }
    }
}
