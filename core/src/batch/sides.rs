//! Points in front of the cameras and behind them. Row offsets are equal for `t` and `-t`, but the points are in front
//! of the cameras for one sign and behind them for the other.

use crate::scalar::Scalar;
use crate::thresholds::{MAX_BEHIND, TRACK_MIN_NEAR};

/// Returns whether too many points are behind the cameras: at least [`TRACK_MIN_NEAR`], and more than [`MAX_BEHIND`]
/// times as many as in front.
///
/// * `[ahead, behind]`: numbers of points clearly in front of the cameras and clearly behind them.
pub(crate) fn is_behind<T: Scalar>([ahead, behind]: [T; 2]) -> bool {
    behind >= T::count(TRACK_MIN_NEAR) && behind > T::lit(MAX_BEHIND) * ahead
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_half_as_many_behind_as_in_front_are_too_many_and_few_mismatches_are_not() {
        let behind = [[0.0, 7.0], [0.0, 8.0], [100.0, 50.0], [100.0, 51.0], [0.0, 0.0]];
        assert_eq!(behind.map(is_behind::<f64>), [false, true, false, true, false]);
    }
}
