//! Sign convention of `t`: the right camera stands to the right of the left one.

use std::error::Error;
use std::fmt;

use nalgebra::Vector3;

use super::geometry::{Rows, matrix};

/// The right camera stands to the left of the left one: `t` follows another convention, or the images are exchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrongSign {
    /// The given `t`, of any length.
    pub t: [f64; 3],
    /// Centre of the right camera in the left frame.
    pub centre: [f64; 3],
}

impl WrongSign {
    /// Checks `R` and `t` of `p_r = R p_l + t`, with `t` of any length. A right camera that stands to the left of the
    /// left one is accepted only if its vertical offset is larger than its horizontal one. The check uses the camera's
    /// centre `-R^T t` instead of `t`, because a camera may be mounted upside down.
    ///
    /// # Errors
    /// If the right camera stands to the left, and its vertical offset is not larger.
    pub fn check(r: &Rows, t: [f64; 3]) -> Result<(), Self> {
        let centre = -(matrix(r).transpose() * Vector3::from(t));
        let [x, y] = [centre.x, centre.y];
        if x < 0.0 && -x >= y.abs() { Err(Self { t, centre: centre.into() }) } else { Ok(()) }
    }
}

impl fmt::Display for WrongSign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { t: [x, y, z], centre: [a, b, c] } = self;
        write!(
            f,
            "t = ({x}, {y}, {z}): the right camera would stand at ({a:.4}, {b:.4}, {c:.4}) in the left frame, \
             to the left. With p_r = R p_l + t a rig side by side has t = (-1, 0, 0). If t points to the \
             right, because it is the position of the right camera in the left frame, use -R t; if R and t \
             lead from right to left, use R^T and -R^T t; if the images are exchanged, exchange them"
        )
    }
}

impl Error for WrongSign {}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const UPSIDE_DOWN: Rows = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn only_a_right_camera_that_stands_to_the_left_is_refused() {
        for t in [[1.0, 0.0, 0.0], [0.12, 0.01, -0.3], [1e-7, 1e-7, 0.0]] {
            assert!(WrongSign::check(&PLAIN, t).is_err(), "{t:?}");
        }
        // A side-by-side rig, cameras behind or above each other, and values of `t` that other checks refuse.
        for t in [[-1.0, 0.0, 0.0], [-0.1, 0.0, 9.0], [0.1, -1.0, 0.0], [0.0; 3], [f64::NAN; 3]] {
            assert_eq!(WrongSign::check(&PLAIN, t), Ok(()));
        }
    }

    #[test]
    fn a_camera_upside_down_turns_the_sign_of_t() {
        assert_eq!(WrongSign::check(&UPSIDE_DOWN, [1.0, 0.0, 0.0]), Ok(()));
        let wrong = WrongSign::check(&UPSIDE_DOWN, [-1.0, 0.0, 0.0]).unwrap_err();
        assert!(wrong.centre[0] < -0.999, "{wrong:?}");
    }
}
