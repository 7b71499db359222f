//! Steps of a pair, one per call: first the passes of the solver, then the fusion, then the verdict.

use super::{Calibrator, applicable_of, context};
use crate::batch::row_grid::Rows;
use crate::batch::row_offset::DIFFERENCE_VARIANCE;
use crate::config::LensTracking;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::cause::Cause;
use crate::outcome::judge::Evidence;
use crate::outcome::pair_report::{Fused, Outcome, PairReport};
use crate::outcome::recent::Recent;
use crate::outcome::verdict::Verdict;
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
    /// The pair is fused or refused; the next step forms the verdict.
    Judging {
        /// Whether the pair has a solution of its own.
        solved: bool,
        fused: Result<Fused, Rejection>,
    },
    /// The pair has an outcome. Only details and witnesses still read its matches.
    Ended,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Takes one step of the pair; returns the outcome once the pair has ended. The first step begins the pair with the
    /// matches pushed so far and takes its first pass. Each further step takes one pass; the last two steps fuse the
    /// result and form the verdict. If [`crate::Config::with_max_passes`] allows nine passes or more, a pair takes at
    /// most four steps more than this limit.
    ///
    /// The calibration in use never changes. A rejected pair does not change the extrinsics of a confirmed estimate.
    /// After [`Rejection::Disagrees`] the standard deviations of the estimate may be larger, because the pair may show
    /// a vibration. A rejected pair counts against each estimate that it was compared with. No pair counts while the
    /// calibrator is frozen. A batch with too few matches ([`Rejection::TooFew`] in the first step) is not compared.
    /// Effects of the pairs that count:
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
            Step::Solved => self.fuse(),
            Step::Judging { solved, fused } => Some(self.end(solved, fused)),
        }
    }

    // Out of line, so that the stack of this step is free again after it.
    #[inline(never)]
    fn begin(&mut self) -> Option<Outcome<T>> {
        if self.step == Step::Ended {
            // A pair that has ended is not solved again.
            self.abandon_pair();
        }
        let is_enough = self.batch.matches().len() >= self.config.min_correspondences.into();
        if self.measure_rows() == Rows::NotMeasured && is_enough {
            return Some(self.unsolved(Rejection::RowsNotMeasured));
        }
        let context = context(&self.config, &self.factory, &self.fusion);
        if let Err(why) = self.fusion.begin(&context, self.batch.matches()) {
            return Some(self.unsolved(why));
        }
        self.step = Step::Solving;
        None
    }

    /// Returns how the matcher has measured the rows of the batch.
    fn measure_rows(&mut self) -> Rows<T> {
        let (in_use, rays) = (&self.in_use, *self.fusion.reference().correction());
        let change = (in_use.correction != rays).then(|| rays.change_to(&in_use.correction));
        let rotations = RectifyingRotations::from(&in_use.extrinsics);
        self.batch.measure_rows(&rotations, change.as_ref(), self.factory.cameras.mean_focal())
    }

    #[inline(never)]
    fn take_pass(&mut self) -> Option<Outcome<T>> {
        let context = context(&self.config, &self.factory, &self.fusion);
        match self.fusion.advance(&context, self.batch.matches(), self.frozen) {
            Ok(is_solved) => self.step = if is_solved { Step::Solved } else { Step::Solving },
            Err(why) => {
                self.step = Step::Judging { solved: false, fused: Err(why) };
                self.next = None;
            }
        }
        None
    }

    #[inline(never)]
    fn fuse(&mut self) -> Option<Outcome<T>> {
        let context = context(&self.config, &self.factory, &self.fusion);
        self.step = match self.fusion.check(&context) {
            Ok(()) => Step::Judging { solved: true, fused: self.add() },
            Err(why) => Step::Judging { solved: false, fused: Err(why) },
        };
        // The estimate has changed.
        self.next = None;
        self.recent.forget_next();
        None
    }

    #[inline(never)]
    pub(super) fn end(&mut self, solved: bool, fused: Result<Fused, Rejection>) -> Outcome<T> {
        if !solved {
            return self.unsolved(fused.err().unwrap_or(Rejection::NotBegun));
        }
        self.step = Step::Ended;
        let mut outcome = self.outcome(fused);
        self.judge(outcome.pair.as_ref());
        self.finish(&mut outcome.fused);
        outcome
    }

    /// Ends a pair that was solved and judged. If its estimate begins again with a corrected lens, no pair supports the
    /// new one yet.
    #[inline(never)]
    fn finish(&mut self, fused: &mut Result<Fused, Rejection>) {
        if self.frozen {
            self.fusion.discard();
        } else {
            self.fusion.close();
        }
        let corrects =
            fused.is_ok() && !self.frozen && self.config.lens_tracking == LensTracking::Compensate;
        if corrects && self.correct_lens() {
            self.judge(None);
            *fused = Ok(Fused::LensCorrected);
        }
    }

    /// Returns the outcome of the solved pair.
    // Out of line, so that the report is written in place.
    #[inline(never)]
    fn outcome(&self, fused: Result<Fused, Rejection>) -> Outcome<T> {
        let context = context(&self.config, &self.factory, &self.fusion);
        Outcome { pair: self.fusion.report(&context), fused }
    }

    /// Ends a pair that could not be solved, and counts the mistake that it shows, unless the calibrator is frozen.
    /// Keeps the matches of a frame that is still arriving.
    pub(super) fn unsolved(&mut self, why: Rejection) -> Outcome<T> {
        let size = self.factory.cameras.left.intrinsics().size;
        if let Some(cause) = Cause::of_unsolved(&self.batch, why, size).filter(|_| !self.frozen) {
            self.causes.add(cause);
        }
        if !self.batch.is_arriving() {
            self.step = Step::Ended;
            self.judge(None);
        }
        Outcome { pair: None, fused: Err(why) }
    }

    /// Forms the verdict after a pair.
    ///
    /// * `pair`: report of the pair; `None` if it could not be solved.
    fn judge(&mut self, pair: Option<&PairReport<T>>) {
        // The proposal is borrowed: moving it out of the option would take its stack space twice.
        let proposal = self.proposal();
        let proposal = proposal.as_ref();
        let rows_px = self.fusion.noise() * T::lit(DIFFERENCE_VARIANCE).sqrt();
        let alike = self.batch.is_moved_alike() && !self.relief.is_shown();
        let of_estimate =
            || proposal.and_then(|found| found.cause(&self.config.lens_prior, rows_px, alike));
        let evidence = Evidence {
            config: &self.config,
            in_use: &self.in_use,
            proposal,
            rays: *self.fusion.reference().correction(),
            focal: self.factory.cameras.mean_focal(),
            state: self.fusion.state(),
            confirmed: self.fusion.is_confirmed(),
            rejected: self.fusion.is_rejected(),
            repeated: pair.is_some() && self.fusion.is_repeated(),
            cause: Cause::of_pixels(&self.batch).or_else(of_estimate),
            likeliest: self.causes.likeliest(),
        };
        self.next = proposal.and_then(|proposal| applicable_of(proposal).ok());
        let matches = self.batch.matches();
        let agrees = evidence.judge(matches, pair, &mut self.recent, &mut self.verdict);
        if let Some(agrees) = agrees.filter(|_| !self.frozen) {
            self.causes.compare(agrees);
        }
    }

    /// Forgets the last pairs and their verdict.
    pub(super) fn forget_verdict(&mut self) {
        (self.recent, self.verdict, self.next) = (Recent::NONE, Verdict::NONE, None);
    }

    /// Fuses the solved pair, unless the calibrator is frozen.
    #[inline(never)]
    fn add(&mut self) -> Result<Fused, Rejection> {
        if self.frozen {
            return Err(Rejection::Frozen);
        }
        let context = context(&self.config, &self.factory, &self.fusion);
        let fused = self.fusion.fuse(&context, self.batch.matches());
        if fused.is_ok() && !self.fusion.is_repeated() && self.batch.is_moved_alike() {
            self.relief.add(self.batch.spread());
        }
        match (fused, Cause::of_pixels(&self.batch)) {
            (Ok(_), Some(cause)) => self.causes.add(cause),
            _ if self.state() == State::Locked => self.causes.forget(),
            _ => {}
        }
        fused
    }
}
