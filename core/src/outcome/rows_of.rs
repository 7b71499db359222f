//! Row offsets of the matches of a batch with a calibration.

use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::pixel_row_offset;
use crate::depth::pose::{MountPose, RowsPose};
use crate::geometry::lens_correction::{LensCorrection, RayChange};
use crate::scalar::Scalar;

/// A calibration whose row offsets are compared with those of another.
pub(super) struct RowsOf<T: Scalar> {
    pose: RowsPose<T>,
    /// Change of the right rays from the cameras of the batch to those of the calibration; `None` without a change.
    change: Option<RayChange<T>>,
}

impl<T: Scalar> RowsOf<T> {
    /// Returns the rows of a calibration. Rows are compared with rows, so that the yaw of the lens counts against no
    /// calibration. `None` if the mount cannot be turned by this yaw.
    ///
    /// * `mount`, `correction`: pose and lens correction of the calibration; `rays`: lens correction of the cameras that
    ///   the rays of the batch belong to; `lens_yaw`: apparent yaw of the lens, rad.
    pub(super) fn new(
        mount: &MountPose<T>,
        correction: &LensCorrection<T>,
        rays: &LensCorrection<T>,
        lens_yaw: T,
    ) -> Option<Self> {
        let change = (correction != rays).then(|| rays.change_to(correction));
        Some(Self { pose: mount.with_lens(lens_yaw)?, change })
    }

    /// Returns the row offset of a match, in pixels over the focal length. `None` for a match that is not in front of
    /// both rectified cameras.
    pub(super) fn offset(&self, pair: &RayPair<T>) -> Option<T> {
        let changed = self.change.map_or(*pair, |change| pair.changed(&change));
        pixel_row_offset(self.pose.rotations(), &changed)
    }
}
