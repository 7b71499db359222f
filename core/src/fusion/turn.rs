//! Rotations of the baseline that are tried before the first champion (`ESTIMATOR.md`, section 13). If a pair fits with
//! one of them, the rig file or the matcher has a common mistake, for instance exchanged images.

use nalgebra::{Unit, Vector3};

use crate::error::Rejection;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Rotation of the baseline about the optical axis of the right camera, from x to y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    /// A quarter turn: cameras one above the other, or u and v exchanged.
    Quarter,
    /// A half turn: left and right exchanged, or `t` with the wrong sign.
    Half,
    /// A quarter turn in the other direction.
    ThreeQuarters,
}

impl Turn {
    /// Returns a turn for a number; successive numbers cycle through the turns.
    pub(super) fn of_number(number: u16) -> Self {
        match number % 3 {
            0 => Self::Quarter,
            1 => Self::Half,
            _ => Self::ThreeQuarters,
        }
    }

    /// Returns the rejection that a good fit with this turn indicates.
    pub(super) fn error(self) -> Rejection {
        match self {
            Self::Half => Rejection::Behind,
            Self::Quarter | Self::ThreeQuarters => Rejection::Columns,
        }
    }

    /// Returns the rectification of the given extrinsics with the baseline turned; `None` if the turned extrinsics are
    /// not valid.
    pub(super) fn of<T: Scalar>(self, given: &Extrinsics<T>) -> Option<RectifyingRotations<T>> {
        let t: &Unit<Vector3<T>> = given.translation();
        let [x, y] = match self {
            Self::Quarter => [-t.y, t.x],
            Self::Half => [-t.x, -t.y],
            Self::ThreeQuarters => [t.y, -t.x],
        };
        let turned = Extrinsics::try_new(given.rotation().matrix(), &Vector3::new(x, y, t.z));
        turned.ok().map(|turned| RectifyingRotations::from(&turned))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn three_turns_follow_each_other_and_turn_the_baseline_by_right_angles() {
        let given = Vector3::new(-0.8, 0.6, 0.0);
        let given = Extrinsics::<f64>::try_new(&Matrix3::identity(), &given).unwrap();
        let turned = [0, 1, 2, 3].map(|number| {
            let pose = Turn::of_number(number).of(&given).unwrap();
            let extrinsics = pose.extrinsics().unwrap();
            assert!((extrinsics.rotation().matrix() - given.rotation().matrix()).norm() < 1e-12);
            extrinsics.translation().into_inner()
        });
        let expected = [[-0.6, -0.8], [0.8, -0.6], [0.6, 0.8], [-0.6, -0.8]];
        for (t, [x, y]) in turned.iter().zip(expected) {
            assert!((t - Vector3::new(x, y, 0.0)).norm() < 1e-12, "{t}");
        }
    }
}
