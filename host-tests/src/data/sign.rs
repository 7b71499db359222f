//! Sign convention of `t`.

use std::error::Error;
use std::fmt;

/// `t` points from the left camera to the right one: it is of another convention, or of exchanged images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrongSign {
    /// As given, any length.
    pub t: [f64; 3],
}

impl WrongSign {
    /// Passes a `t` of `p_r = R p_l + t`, any length: to the left, or more up or down than to the right.
    ///
    /// # Errors
    /// The `t` that was given.
    pub fn check(t: [f64; 3]) -> Result<(), Self> {
        let [x, y, _] = t;
        if x > 0.0 && x >= y.abs() { Err(Self { t }) } else { Ok(()) }
    }
}

impl fmt::Display for WrongSign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.t;
        write!(
            f,
            "t = ({x}, {y}, {z}) points to the right: with p_r = R p_l + t a rig side by side has \
             t = (-1, 0, 0). If t is where the right camera stands, in the left frame, use -R t; if the \
             images are exchanged, exchange them"
        )
    }
}

impl Error for WrongSign {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_t_to_the_right_is_of_the_other_convention() {
        for t in [[1.0, 0.0, 0.0], [0.12, 0.01, -0.3], [1e-7, 1e-7, 0.0]] {
            assert_eq!(WrongSign::check(t), Err(WrongSign { t }));
        }
        // To the left, above each other, and what is refused for another reason.
        for t in [[-1.0, 0.0, 0.0], [-0.1, 0.0, 9.0], [0.1, -1.0, 0.0], [0.0; 3], [f64::NAN; 3]] {
            assert_eq!(WrongSign::check(t), Ok(()));
        }
    }
}
