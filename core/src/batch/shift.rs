//! Motion between the images that most matches have in common: none, or a shift, where both sides show the same image.

use crate::batch::correspondence::Correspondence;
use crate::scalar::Scalar;
use crate::thresholds::ALIKE_PX;

/// Majority vote of Boyer and Moore (1991), in one pass and constant memory. A motion that a share `p` of the matches
/// has in common is left with an excess of at least `2 p - 1` of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift<T> {
    /// Left pixel less right pixel, px.
    at: [T; 2],
    /// Matches with this motion less others, since the motion was taken up.
    pub(super) excess: u32,
}

impl<T: Scalar> Shift<T> {
    pub(super) const NONE: Self = Self { at: [T::ZERO; 2], excess: 0 };

    /// Counts a match for the motion, or against it.
    pub(super) fn add(&mut self, c: &Correspondence<T>) {
        let ([u_l, v_l], [u_r, v_r]) = (c.left, c.right);
        let moved = [u_l - u_r, v_l - v_r];
        let alike = |(a, b): (T, T)| (a - b).abs() <= T::lit(ALIKE_PX);
        if self.excess == 0 {
            *self = Self { at: moved, excess: 1 };
        } else if moved.into_iter().zip(self.at).all(alike) {
            self.excess = self.excess.saturating_add(1);
        } else {
            self.excess -= 1;
        }
    }
}
