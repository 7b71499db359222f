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
    /// Difference of the last match with this motion from it, px.
    last: [T; 2],
    /// Sum of the scores of these differences from match to match, [`score`], and their number.
    scores: [T; 2],
}

impl<T: Scalar> Shift<T> {
    pub(super) const NONE: Self =
        Self { at: [T::ZERO; 2], excess: 0, last: [T::ZERO; 2], scores: [T::ZERO; 2] };

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
            let [sum, number] = self.scores;
            self.scores = [sum + score([x - self.last[0], y - self.last[1]]), number + T::ONE];
            self.last = [x, y];
        } else {
            self.excess -= 1;
        }
    }

    /// Sum of the scores of the matches with this motion, and their number.
    pub(super) fn spread(&self) -> [T; 2] {
        self.scores
    }
}

/// `cos 2a` with the angle `a` between the rows and the change of displacement from the match before: 1 along rows, -1
/// across them. Noise alone has
/// the mean 0 and the variance 1/2; depth makes it positive; no match weighs more than 1.
fn score<T: Scalar>([along, across]: [T; 2]) -> T {
    let [xx, yy] = [along * along, across * across];
    let all = xx + yy;
    if all > T::ZERO { (xx - yy) / all } else { T::ZERO }
}
