//! Sums over the pairs of a run, for a log that does not keep its pairs.

use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Fused, State};

use super::refused::{self, CountByReason, WitnessCounts};
use super::step::{Step, Verdict};

/// Sums over pairs.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Totals {
    /// Number of pairs.
    pub(super) pairs: usize,
    /// Number of pairs fused.
    pub(super) accepted: usize,
    /// Number of correspondences offered.
    pub(super) matches: usize,
    /// Number of correspondences refused, by reason.
    pub(super) refused: CountByReason,
    /// Number of pairs not solved or not fused, by reason.
    pub(super) rejected: CountByReason,
    /// Results of range readings and of tracked matches.
    pub(super) witnessed: WitnessCounts,
    /// Errors of the accepted pairs as solved in the run.
    pub(super) tracked: Squares,
    /// Errors of the pairs solved alone.
    pub(super) alone: Squares,
    /// Number of pairs that have an estimate when solved alone.
    pub(super) alone_pairs: usize,
    /// First pair, from 0, after which the state was locked.
    pub(super) locked_at: Option<usize>,
    /// Whether the estimate has restarted with a corrected lens.
    pub(super) began_again: bool,
}

impl Totals {
    /// Adds the next pair.
    pub(super) fn add(&mut self, step: &Step) {
        let Step { offered, refused, witnessed, verdict, solved, alone, .. } = step;
        self.matches += offered;
        refused::add(&mut self.refused, refused);
        self.witnessed.add(witnessed);
        match verdict {
            Verdict::Accepted(how) => {
                self.accepted += 1;
                self.tracked.add(solved.and_then(|solved| solved.error));
                self.began_again |= *how == Fused::LensCorrected;
            }
            Verdict::Refused(why) => {
                *self.rejected.entry(refused::of_refusal(*why)).or_default() += 1;
            }
            Verdict::Failed(why) => {
                *self.rejected.entry(refused::snake_case(why)).or_default() += 1;
            }
        }
        self.alone.add(alone.and_then(|alone| alone.error));
        self.alone_pairs += usize::from(alone.is_some_and(|alone| alone.extrinsics.is_some()));
        if step.state() == Some(State::Locked) {
            self.locked_at = self.locked_at.or(Some(self.pairs));
        }
        self.pairs += 1;
    }
}

/// Sums of squares of deviations.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Squares {
    count: u32,
    sum: Deviation<f64>,
}

impl Squares {
    fn add(&mut self, deviation: Option<Deviation<f64>>) {
        let Some(Deviation { translation, rotation }) = deviation else { return };
        self.count = self.count.saturating_add(1);
        self.sum.translation += translation * translation;
        self.sum.rotation += rotation * rotation;
    }

    /// Root mean square, equal to [`Deviation::root_mean_square`] to the bit; `None` without deviations.
    pub(super) fn root_mean(&self) -> Option<Deviation<f64>> {
        let mean_root = |sum: f64| (sum / f64::from(self.count)).sqrt();
        let Deviation { translation, rotation } = self.sum;
        (self.count > 0).then(|| Deviation {
            translation: mean_root(translation),
            rotation: mean_root(rotation),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_mean_square_matches_the_core_to_the_bit() {
        let deviations =
            [0.1, 0.7, 1e-9, 0.3].map(|x| Deviation { translation: x, rotation: x / 3.0 });
        let mut squares = Squares::default();
        assert_eq!(squares.root_mean(), None);
        for deviation in deviations {
            squares.add(Some(deviation));
        }
        squares.add(None);
        assert_eq!(squares.root_mean(), Deviation::root_mean_square(deviations));
    }
}
