//! Information of a pair without the bias of noise in its disparities.

use crate::algebra::information::Information;
use crate::scalar::Scalar;
use crate::thresholds::SIGNIFICANT;
use crate::thresholds::paper::MAX_DISPARITY_NOISE;

/// Returns the information without the bias of noise in the block of the baseline. The derivatives in this block
/// are disparities, which are only noise for points at infinity.
///
/// * `weight`: sum of the weights.
/// * `variance`: variance of a disparity, in the unit of the sum.
///
/// `None` if noise and a yaw error exceed the share [`MAX_DISPARITY_NOISE`] of the squared disparities. Yaw changes
/// all disparities alike and hardly changes rows. The assumed yaw error is [`SIGNIFICANT`] standard deviations.
pub(super) fn less_disparity_noise<T: Scalar>(
    information: &Information<T>,
    weight: T,
    variance: T,
) -> Option<Information<T>> {
    let [.., squares] = information.0.diagonal();
    let alike = T::lit(SIGNIFICANT * SIGNIFICANT) * yaw_share(information);
    if !(variance * (weight + alike) <= squares * T::lit(MAX_DISPARITY_NOISE)) {
        return None;
    }
    let share = T::ONE - variance * weight / squares;
    let mut unbiased = *information;
    let h = &mut unbiased.0.0;
    h[9] *= share;
    h[13] *= share;
    h[14] *= share;
    Some(unbiased)
}

/// Returns the weighted sum of the squared disparities caused by a yaw error (rotation about y) of one standard
/// deviation: `H_pitch / H_yaw`, dimensionless. `H_pitch` is about the sum of the weights, and `1 / H_yaw` is the
/// variance of yaw.
fn yaw_share<T: Scalar>(information: &Information<T>) -> T {
    let [pitch, yaw, ..] = information.0.diagonal();
    pitch / yaw
}
