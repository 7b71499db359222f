//! Reported vibration.

use core::fmt;

use crate::algebra::block_variances::BlockVariances;
use crate::scalar::Scalar;

/// Motion of the rig from one pair to the next about a constant mean, rad RMS; 0 if the pairs show no vibration.
///
/// The estimate is the mean; the extrinsics of a single pair differ from it by this much. No calibration can follow a
/// vibration. Remedies: a stiffer mount, dampers, or better synchronised cameras.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Vibration<T> {
    /// Vibration of `R` about each axis, rad RMS.
    pub rotation: T,
    /// Vibration of the baseline about each of its two angles, rad RMS.
    pub baseline: T,
}

impl<T: Scalar> Vibration<T> {
    /// No vibration.
    pub const NONE: Self = Self { rotation: T::ZERO, baseline: T::ZERO };

    /// Returns whether the pairs show no vibration.
    pub fn is_none(&self) -> bool {
        self.rotation == T::ZERO && self.baseline == T::ZERO
    }
}

impl<T: Scalar> From<BlockVariances<T>> for Vibration<T> {
    fn from(variances: BlockVariances<T>) -> Self {
        Self { rotation: variances.rotation.sqrt(), baseline: variances.baseline.sqrt() }
    }
}

impl<T: Scalar> fmt::Display for Vibration<T> {
    /// Writes rotation and baseline, degrees RMS.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, t] = [self.rotation, self.baseline].map(|rad| rad.to_f64().to_degrees());
        write!(f, "vibration {r:.3} deg R, {t:.3} deg t")
    }
}
