//! The motion between both images that most matches share: zero, or a shift, where both sides show the same image.

use crate::batch::correspondence::Correspondence;
use crate::scalar::Scalar;
use crate::thresholds::ALIKE_PX;

/// Majority vote of Boyer and Moore (1991), in one pass and constant memory. If a share `p` of the matches has a common
/// motion, the vote keeps it with an excess of at least `2 p - 1` of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift<T> {
    /// Left pixel less right pixel, px.
    at: [T; 2],
    /// Matches with this motion less others, since this motion became the candidate.
    pub(super) excess: u32,
    /// Matches with this motion.
    count: u32,
    /// Sums of their differences from it along columns and rows, px, and of the squares.
    sums: [T; 2],
    squares: [T; 2],
}

impl<T: Scalar> Shift<T> {
    pub(super) const NONE: Self =
        Self { at: [T::ZERO; 2], excess: 0, count: 0, sums: [T::ZERO; 2], squares: [T::ZERO; 2] };

    /// Counts a match for the motion or against it.
    pub(super) fn add(&mut self, c: &Correspondence<T>) {
        let ([u_l, v_l], [u_r, v_r]) = (c.left, c.right);
        let moved = [u_l - u_r, v_l - v_r];
        if self.excess == 0 {
            *self = Self { at: moved, ..Self::NONE };
        }
        let [x, y] = [moved[0] - self.at[0], moved[1] - self.at[1]];
        if x.abs().max(y.abs()) <= T::lit(ALIKE_PX) {
            self.excess = self.excess.saturating_add(1);
            self.count = self.count.saturating_add(1);
            self.sums = [self.sums[0] + x, self.sums[1] + y];
            self.squares = [self.squares[0] + x * x, self.squares[1] + y * y];
        } else {
            self.excess -= 1;
        }
    }

    /// Excess scatter along rows of the matches with this motion: the difference of both sums of squares about their
    /// means, and its variance if both are noise. Only depth makes the difference positive.
    pub(super) fn spread(&self) -> [T; 2] {
        let n = T::count(self.count.max(1));
        let ([x, y], [xx, yy]) = (self.sums, self.squares);
        let [along, across] = [xx - x * x / n, yy - y * y / n];
        [along - across, (along * along + across * across) * T::lit(2.0) / n]
    }
}
