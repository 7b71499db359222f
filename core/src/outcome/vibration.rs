//! Vibration as it is reported.

use core::fmt;

use nalgebra::Vector5;

use crate::algebra::block_variances::BlockVariances;
use crate::batch::Batch;
use crate::batch::row_offset::row_offset;
use crate::geometry::lens_correction::RayChange;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::ALLOWED_VIBRATION;

/// Motion of the rig from one pair to the next about the same mean, rad RMS; 0 where the pairs show no sign of any.
///
/// The estimate is the mean; the extrinsics of a single pair are off by this much. No calibration follows it: it is
/// cured by a stiffer mount, dampers, or better synchronised cameras.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Vibration<T> {
    /// Of `R` about each axis, rad RMS.
    pub rotation: T,
    /// Of the baseline about each of its two angles, rad RMS.
    pub baseline: T,
}

impl<T: Scalar> Vibration<T> {
    /// No sign of any.
    pub const NONE: Self = Self { rotation: T::ZERO, baseline: T::ZERO };

    /// Whether there is no sign of any.
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
    /// Degrees RMS of rotation and baseline.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, t] = [self.rotation, self.baseline].map(|rad| rad.to_f64().to_degrees());
        write!(f, "vibration {r:.3} deg R, {t:.3} deg t")
    }
}

/// A batch of a rig that vibrates, by the matches that fit the estimate.
pub(crate) struct Shaken<'a, T: Scalar, const N: usize> {
    pub(crate) batch: &'a Batch<T, N>,
    /// The estimate.
    pub(crate) pose: &'a RectifyingRotations<T>,
    /// Of the right rays, to those of its cameras.
    pub(crate) change: Option<&'a RayChange<T>>,
    /// Largest row offset of a match that fits, at unit focal length.
    pub(crate) limit: T,
}

impl<T: Scalar, const N: usize> Shaken<'_, T, N> {
    /// RMS row offset that the extrinsics in use would have without vibration, at unit focal length: their distance
    /// from the estimate, and what the estimate's RMS has beyond vibration.
    ///
    /// * `in_use`, `change`: the extrinsics in use, and the change of the rays to their cameras.
    /// * `rms`: row offsets in use and of the estimate.
    #[inline(never)]
    pub(crate) fn steady(
        &self,
        in_use: &RectifyingRotations<T>,
        change: Option<&RayChange<T>>,
        rms: [T; 2],
        vibration: &Vibration<T>,
    ) -> T {
        let off = self.mean_square(in_use, change);
        let [rms_in_use, rms_proposed] = rms;
        let Vibration { rotation: r, baseline: b } = *vibration;
        let shakes = [r, r, r, b, b].into_iter().enumerate().map(|(axis, size)| {
            let mut shake = Vector5::zeros();
            if let Some(shake) = shake.get_mut(axis) {
                *shake = size;
            }
            let shaken = self.pose.stepped_by(&shake);
            shaken.map_or(T::ZERO, |shaken| self.mean_square(&shaken, self.change))
        });
        let allowed = shakes.fold(T::ZERO, |sum, square| sum + square) * T::lit(ALLOWED_VIBRATION);
        let rest = (rms_proposed * rms_proposed - allowed).max(T::ZERO);
        // More than is seen is not there.
        (off + rest).sqrt().min(rms_in_use)
    }

    /// Mean squared difference of the row offsets at another pose and at the estimate.
    #[inline(never)]
    fn mean_square(&self, other: &RectifyingRotations<T>, change: Option<&RayChange<T>>) -> T {
        let [mut squares, mut count] = [T::ZERO; 2];
        for pair in self.batch.pairs() {
            let by = |pose, change: Option<&RayChange<T>>| {
                row_offset(pose, &change.map_or(*pair, |change| pair.changed(change)))
            };
            let both = by(self.pose, self.change).zip(by(other, change));
            if let Some((own, other)) = both.filter(|(own, _)| own.abs() <= self.limit) {
                squares += (other - own) * (other - own);
                count += T::ONE;
            }
        }
        squares / count.max(T::ONE)
    }
}
