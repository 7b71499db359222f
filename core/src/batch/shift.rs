//! The displacement between the images that most matches share. If both sides show the same image, it is zero or a
//! constant shift.

use crate::batch::correspondence::Correspondence;
use crate::scalar::Scalar;
use crate::thresholds::ALIKE_PX;

/// Majority vote of Boyer and Moore (1991), in one pass and constant memory. If a share `p > 1/2` of the matches has a
/// common displacement, the vote finds it, with an excess of at least the share `2 p - 1` of all matches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift<T> {
    /// Candidate displacement: left pixel minus right pixel, px.
    at: [T; 2],
    /// Number of matches with this displacement minus number of other matches, since this displacement became the
    /// candidate.
    excess: u16,
    /// Number of matches.
    matches: u16,
    /// Displacement of the last match that agreed with the candidate within [`ALIKE_PX`], minus the candidate, px.
    last: [T; 2],
    /// Sum and number of the scores ([`score`]) of the changes of displacement between successive matches that agreed
    /// with the candidate.
    scores: [T; 2],
}

impl<T: Scalar> Shift<T> {
    pub(super) const NONE: Self =
        Self { at: [T::ZERO; 2], excess: 0, matches: 0, last: [T::ZERO; 2], scores: [T::ZERO; 2] };

    /// Counts a match for or against the candidate displacement.
    pub(super) fn add(&mut self, c: &Correspondence<T>) {
        let ([u_l, v_l], [u_r, v_r]) = (c.left, c.right);
        let moved = [u_l - u_r, v_l - v_r];
        self.matches = self.matches.saturating_add(1);
        if self.excess == 0 {
            *self = Self { at: moved, matches: self.matches, ..Self::NONE };
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

    /// Returns whether the excess is above a quarter of the matches. This holds if more than 5/8 of them have the same
    /// displacement.
    pub(super) fn is_common(&self) -> bool {
        self.excess > self.matches / 4
    }

    /// Returns the sum and the number of the scores ([`score`]) of the matches that agreed with the candidate.
    pub(super) fn spread(&self) -> [T; 2] {
        self.scores
    }
}

/// Returns `cos 2a`, where `a` is the angle between the rows and the change of displacement since the previous match: 1
/// along the rows, -1 across them. Noise alone gives a mean of 0 and a variance of 1/2. Depth makes the mean positive.
/// No match contributes more than 1 in magnitude.
fn score<T: Scalar>([along, across]: [T; 2]) -> T {
    let [xx, yy] = [along * along, across * across];
    let all = xx + yy;
    if all > T::ZERO { (xx - yy) / all } else { T::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matched(moved: f32) -> Correspondence<f32> {
        Correspondence {
            left: [500.0, 100.0],
            right: [500.0 - moved, 100.0],
            score: 1.0,
            grid_step: 0.0,
        }
    }

    #[test]
    fn a_displacement_is_common_beyond_five_eighths_of_the_matches() {
        for (alike, is_common) in [(120_u8, false), (124, false), (128, true), (200, true)] {
            // In the worst order, the others come last.
            let mut shift = Shift::NONE;
            (0..alike).for_each(|_| shift.add(&matched(3.0)));
            for other in alike..200 {
                shift.add(&matched(10.0 * f32::from(other)));
            }
            assert_eq!(shift.is_common(), is_common, "{alike}");
        }
    }
}
