//! Steps of a pair, one per call: first the passes of the solver, then the fusion.

use super::Calibrator;
use crate::config::LensTracking;
use crate::error::Rejection;
use crate::outcome::cause::Causes;
use crate::outcome::pair_report::{Fused, Outcome, PairReport};
use crate::scalar::Scalar;
use crate::state::State;

/// Progress of the pair in the batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// Matches arrive.
    Collecting,
    /// The solver takes passes.
    Solving,
    /// The pair is solved; the next step fuses it.
    Solved,
    /// The pair has an outcome. Only health and witnesses still read its matches.
    Ended,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Takes one step of the pair; returns the outcome once the pair has ended. The first step begins the pair with the
    /// matches pushed so far and takes its first pass. Each further step takes one pass, and the last step fuses the
    /// result. If [`crate::Config::with_max_passes`] allows nine passes or more, a pair takes at most three steps more
    /// than this limit.
    ///
    /// The calibration in use never changes. A rejected pair does not change the extrinsics of a confirmed estimate.
    /// After [`Rejection::Disagrees`] the standard deviations of the estimate may be larger, because the pair may show
    /// a vibration. A rejected pair counts against each estimate that it was compared with. No pair counts in the paper
    /// preset, and none counts while the calibrator is frozen. A batch with too few matches ([`Rejection::TooFew`] in
    /// the first step) is not compared. Effects of the pairs that count:
    /// - A locked estimate becomes [`State::Suspect`], and [`State::Lost`] after ten such pairs in a row. The next pair
    ///   that agrees with the estimate locks it again; if there is a challenger, this may take two such pairs.
    /// - A challenger, or an estimate that is still [`State::Acquiring`], is dropped once at least two pairs disagree
    ///   with it and their number exceeds half the number of its supporting pairs.
    /// - A pair that agrees with a confirmed estimate counts against the challenger too. It drops the challenger if a
    ///   pair has counted against it before.
    /// - Before the first lock, a pair that fits a turned baseline clearly better than the estimate
    ///   ([`Rejection::Behind`], [`Rejection::Columns`]) drops the estimate at once.
    ///
    /// If no estimate remains, [`Calibrator::proposal`] is `None` until a pair is fused.
    pub fn advance_pair(&mut self) -> Option<Outcome<T>> {
        match self.step {
            Step::Collecting | Step::Ended => self.begin(),
            Step::Solving => self.take_pass(),
            Step::Solved => Some(self.end()),
        }
    }

    // Out of line, so that the stack of this step is free again after it.
    #[inline(never)]
    fn begin(&mut self) -> Option<Outcome<T>> {
        if self.step == Step::Ended {
            // A pair that has ended is not solved again.
            self.discard_pair();
        }
        let context = self.estimator.context(&self.config, &self.factory);
        if let Err(why) = self.estimator.begin(&context, self.batch.pairs()) {
            return Some(self.unsolved(why));
        }
        self.rejection = None;
        self.step = Step::Solving;
        None
    }

    #[inline(never)]
    fn take_pass(&mut self) -> Option<Outcome<T>> {
        let context = self.estimator.context(&self.config, &self.factory);
        match self.estimator.advance(&context, self.batch.pairs(), self.frozen) {
            Ok(is_solved) => {
                self.step = if is_solved { Step::Solved } else { Step::Solving };
                None
            }
            Err(why) => Some(self.unsolved(why)),
        }
    }

    #[inline(never)]
    fn end(&mut self) -> Outcome<T> {
        match self.report() {
            Ok(pair) => Outcome { pair: Some(pair), fused: self.fuse() },
            Err(why) => self.unsolved(why),
        }
    }

    #[inline(never)]
    fn report(&mut self) -> Result<PairReport<T>, Rejection> {
        let context = self.estimator.context(&self.config, &self.factory);
        self.estimator.report(&context, self.batch.pairs())
    }

    /// Ends a pair that could not be solved, and counts the mistake that it shows, unless the calibrator is frozen.
    /// Keeps the matches of a frame that is still arriving.
    pub(super) fn unsolved(&mut self, why: Rejection) -> Outcome<T> {
        if !self.batch.is_arriving() {
            self.step = Step::Ended;
        }
        self.rejection = Some(why);
        let size = self.factory.cameras.left.intrinsics().size;
        if let Some(cause) = self.batch.cause_of(why, size).filter(|_| !self.frozen) {
            self.causes.add(cause);
        }
        Outcome { pair: None, fused: Err(why) }
    }

    #[inline(never)]
    fn fuse(&mut self) -> Result<Fused, Rejection> {
        self.step = Step::Ended;
        if self.frozen {
            self.estimator.discard();
            self.rejection = Some(Rejection::Frozen);
            return Err(Rejection::Frozen);
        }
        let context = self.estimator.context(&self.config, &self.factory);
        let fused = self.estimator.fuse(&context);
        self.rejection = fused.err();
        if fused.is_ok() && !self.estimator.is_repeated() && self.batch.is_moved_alike() {
            self.relief.add(self.batch.spread());
        }
        match self.batch.cause().filter(|_| fused.is_ok()) {
            Some(cause) => self.causes.add(cause),
            None if self.state() == State::Locked => self.causes = Causes::NONE,
            None => {}
        }
        let corrects = fused.is_ok() && self.config.lens_tracking == LensTracking::Compensate;
        if corrects && self.correct_lens() { Ok(Fused::LensCorrected) } else { fused }
    }
}
