//! Data association of a batch, one pass at a time (`ESTIMATOR.md`, section 13).
//!
//! The batch is tracked from the champion and then from the challenger, as far as they exist, until the gate of one
//! accepts it. If both exist and reject the batch, it supports no hypothesis. If one of them does not exist, a batch
//! that is not accepted is searched with a wide loss, and a valid pose starts a new challenger. A challenger that has
//! rejected the batch is replaced only if the pose found fits clearly better. Before the first champion, a search with
//! the baseline turned may come first.

use super::association_result::{AssociationResult, Rejected, Support};
use super::hypotheses::Hypotheses;
use super::hypothesis::Hypothesis;
use super::key_frame::Moved;
use super::turn::Turn;
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::pixel_row_offset;
use crate::config::Context;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::pair::evaluate::EvaluatedPose;
use crate::pair::solver::PairSolver;
use crate::scalar::Scalar;
use crate::state::Stop;
use crate::thresholds::{CLEARLY_BETTER, OPEN_COST, TRACK_PASSES, TRUNCATED_PX};

/// Number of passes reserved after a search with the baseline turned: a comparison with the challenger, a track from
/// the challenger, a search of the least length, and another comparison. Track and search include their evaluations.
const AFTER_TURNED: u16 = 2 * TRACK_PASSES + 2;

/// Stage of an association.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// No batch is being associated.
    Idle,
    /// Searches with the baseline turned, before the first champion. If the pose found fits clearly better than the
    /// challenger, or there is no challenger, the batch is refused. Otherwise it is then tracked from the challenger.
    Turned(Turn),
    /// Tracks from the champion.
    Champion,
    /// Tracks from the challenger.
    Challenger,
    /// Searches with a wide loss, from the champion or from the factory extrinsics.
    Search,
    /// Compares the pose that a search has found with the pose of the challenger, which has rejected the batch.
    Compare,
    /// No stage is left.
    Done(Support),
}

/// Working memory, shared by solver and evaluation.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
enum Work<T: Scalar> {
    None,
    Solver(PairSolver<T>),
    Evaluated(EvaluatedPose<T>),
}

/// Association of one batch.
#[derive(Debug, Clone)]
pub(super) struct Association<T: Scalar> {
    stage: Stage,
    work: Work<T>,
    rejected: Rejected,
    /// Motion of the scene of the batch since the key frame.
    moved: Moved,
    /// Passes taken, evaluations and comparisons included.
    passes: u16,
    /// Reason for the end of the last solver.
    stop: Stop,
}

/// Settings, and the hypotheses that a batch may support.
#[derive(Debug, Clone, Copy)]
pub(super) struct AssociationContext<'a, T: Scalar> {
    pub(super) context: &'a Context<'a, T>,
    pub(super) hypotheses: &'a Hypotheses<T>,
}

impl<T: Scalar> Association<T> {
    /// An association without a batch.
    pub(super) const IDLE: Self = Self {
        stage: Stage::Idle,
        work: Work::None,
        rejected: Rejected { by_champion: false, by_challenger: false },
        moved: Moved::FAR,
        passes: 0,
        stop: Stop::PassesSpent,
    };

    /// Returns whether stages are left.
    pub(super) fn is_open(&self) -> bool {
        !matches!(self.stage, Stage::Idle | Stage::Done(_))
    }

    /// Returns whether the last batch repeated the scene of the last pair that was added.
    pub(super) fn is_repeated(&self) -> bool {
        self.moved.is_repeated()
    }

    /// Drops the batch and its result.
    pub(super) fn close(&mut self) {
        self.stage = Stage::Idle;
    }

    /// Begins a batch.
    ///
    /// * `moved`: motion of the scene of the batch since the key frame.
    /// * `turn`: turn of the baseline to try first. The turn is not tried if most matches fit the challenger, or if the
    ///   configuration allows too few passes.
    #[inline(never)]
    pub(super) fn open(
        &mut self,
        with: &AssociationContext<'_, T>,
        pairs: &[RayPair<T>],
        moved: Moved,
        turn: Option<Turn>,
    ) {
        self.rejected = Rejected::default();
        self.moved = moved;
        self.passes = 0;
        let is_affordable = with.context.config.max_passes >= 2 * AFTER_TURNED;
        match turn.filter(|_| is_affordable && with.leaves_open(pairs)) {
            Some(turn) => self.enter(Stage::Turned(turn), with),
            None => self.enter(Stage::Champion, with),
        }
    }

    /// Enters a stage, or a later stage if its hypothesis does not exist. If a track cannot start, the search follows.
    #[inline(never)]
    fn enter(&mut self, stage: Stage, with: &AssociationContext<'_, T>) {
        if let Stage::Turned(turn) = stage {
            self.stage = stage;
            let start = turn.of(with.context.factory).unwrap_or(with.context.factory_pose);
            self.search(with, start, AFTER_TURNED);
            return;
        }
        let (champion, challenger) = (with.hypotheses.champion(), with.hypotheses.challenger());
        let (stage, hypothesis) = match stage {
            Stage::Champion if champion.is_some() => (stage, champion),
            Stage::Champion | Stage::Challenger => (Stage::Challenger, challenger),
            _ => (stage, None),
        };
        self.stage = stage;
        if !hypothesis.is_some_and(|hypothesis| self.track(hypothesis, with)) {
            self.stage = Stage::Search;
            let start = with.hypotheses.search_start().unwrap_or(with.context.factory_pose);
            // If the challenger has rejected the batch, a comparison with it takes one more pass.
            self.search(with, start, u16::from(self.rejected.by_challenger));
        }
    }

    /// Starts a track from a hypothesis. Returns false if the hypothesis has no covariance, or if the covariance of the
    /// start has no inverse.
    #[inline(never)]
    fn track(&mut self, hypothesis: &Hypothesis<T>, with: &AssociationContext<'_, T>) -> bool {
        let Context { config, focal, .. } = *with.context;
        let start = hypothesis.track_start(with.context);
        let solver = start.and_then(|start| PairSolver::track(config, focal, &start));
        match solver {
            Some(solver) => {
                self.work = Work::Solver(solver);
                true
            }
            None => false,
        }
    }

    /// Starts a search.
    ///
    /// * `after`: number of passes reserved after the search.
    #[inline(never)]
    fn search(
        &mut self,
        with: &AssociationContext<'_, T>,
        start: RectifyingRotations<T>,
        after: u16,
    ) {
        let used = self.passes.saturating_add(after);
        self.work = Work::Solver(with.search(start, used));
    }

    /// Takes one more pass, unless no stage is left.
    ///
    /// # Errors
    /// [`Rejection`]: the batch has no result.
    pub(super) fn advance(
        &mut self,
        with: &AssociationContext<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        self.passes = self.passes.saturating_add(1);
        if let Stage::Turned(turn) = self.stage {
            return self.try_turned(turn, with, matches);
        }
        match &mut self.work {
            Work::Solver(solver) if !solver.is_done() => solver.advance(matches),
            Work::Solver(_) => {
                self.evaluate(matches)?;
                let next = self.decide(with)?;
                self.stage = next;
                if matches!(next, Stage::Challenger | Stage::Search) {
                    self.enter(next, with);
                }
                Ok(())
            }
            Work::Evaluated(evaluated) => {
                let better = with.is_better(&evaluated.measurement.pose, matches);
                self.stage = Stage::Done(if better { Support::New } else { Support::None });
                Ok(())
            }
            Work::None => Ok(()),
        }
    }

    /// Takes one more pass with the baseline turned. If the turned pose does not fit clearly better than the
    /// challenger, the batch is then tracked from the challenger.
    ///
    /// # Errors
    /// [`Rejection::Behind`], [`Rejection::Columns`]: a turned baseline fits, and fits clearly better than the
    /// challenger if there is one. Otherwise, without a challenger, the error of the search, for instance
    /// [`Rejection::NoConsensus`].
    #[inline(never)]
    fn try_turned(
        &mut self,
        turn: Turn,
        with: &AssociationContext<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        let fits = match &mut self.work {
            Work::Solver(solver) if !solver.is_done() => solver.advance(matches),
            Work::Solver(_) => self.evaluate(matches).and_then(|()| self.check_scene(with)),
            Work::Evaluated(evaluated) if with.is_better(&evaluated.measurement.pose, matches) => {
                return Err(turn.error());
            }
            Work::Evaluated(_) | Work::None => Err(Rejection::NoConsensus),
        };
        if fits.is_err() && with.hypotheses.challenger().is_some() {
            self.enter(Stage::Challenger, with);
            return Ok(());
        }
        fits
    }

    /// Checks that the evaluated pose is an optimum, and that most of the points that fit are clearly in front of the
    /// cameras.
    ///
    /// # Errors
    /// As [`AssociationContext::check`]; [`Rejection::NoConsensus`] also if the points are not clearly in front.
    fn check_scene(&self, with: &AssociationContext<'_, T>) -> Result<(), Rejection> {
        match &self.work {
            Work::Evaluated(evaluated) if evaluated.is_clearly_in_front() => with.check(evaluated),
            _ => Err(Rejection::NoConsensus),
        }
    }

    /// Evaluates the pose of the solver. The result replaces the solver in memory.
    ///
    /// # Errors
    /// [`Rejection::TooFew`], [`Rejection::Unobservable`].
    #[inline(never)]
    fn evaluate(&mut self, matches: &[RayPair<T>]) -> Result<(), Rejection> {
        let Work::Solver(solver) = &self.work else {
            return Ok(());
        };
        self.stop = solver.stop();
        let iterate = *solver.iterate();
        self.clear_evaluation();
        match &mut self.work {
            Work::Evaluated(evaluated) => iterate.evaluate(matches, evaluated),
            _ => Ok(()),
        }
    }

    /// Replaces the working memory by an empty evaluation. Out of line, to keep the new value off the caller's stack.
    #[inline(never)]
    fn clear_evaluation(&mut self) {
        self.work = Work::Evaluated(EvaluatedPose::NONE);
    }

    /// Returns the stage after an evaluation, and notes a hypothesis that rejects the batch. After a track the gate of
    /// its hypothesis decides; after a search the check of the pose decides.
    ///
    /// # Errors
    /// As [`AssociationContext::check`].
    #[inline(never)]
    fn decide(&mut self, with: &AssociationContext<'_, T>) -> Result<Stage, Rejection> {
        let AssociationContext { context, hypotheses } = *with;
        let Work::Evaluated(evaluated) = &self.work else {
            return Err(Rejection::NotBegun);
        };
        match self.stage {
            Stage::Champion => {
                if hypotheses.gate_of_champion(evaluated, context) {
                    return Ok(Stage::Done(Support::Champion));
                }
                self.rejected.by_champion = true;
                Ok(Stage::Challenger)
            }
            Stage::Challenger => {
                if hypotheses.gate_of_challenger(evaluated, context) {
                    return Ok(Stage::Done(Support::Challenger));
                }
                self.rejected.by_challenger = true;
                let done = self.rejected.by_champion;
                Ok(if done { Stage::Done(Support::None) } else { Stage::Search })
            }
            _ => {
                with.check(evaluated)?;
                let compare = self.rejected.by_challenger;
                Ok(if compare { Stage::Compare } else { Stage::Done(Support::New) })
            }
        }
    }

    /// Returns whether the association is in the stage with a turned baseline.
    pub(super) fn is_turned(&self) -> bool {
        matches!(self.stage, Stage::Turned(_))
    }

    /// Returns the hypotheses whose gates have rejected the batch so far.
    pub(super) fn rejected(&self) -> Rejected {
        self.rejected
    }

    /// Returns the result; `None` while stages are left, and without a batch.
    pub(super) fn result(&self) -> Option<AssociationResult<'_, T>> {
        let (Stage::Done(support), Work::Evaluated(evaluated)) = (self.stage, &self.work) else {
            return None;
        };
        Some(AssociationResult {
            support,
            evaluated,
            rejected: self.rejected,
            moved: self.moved,
            passes: self.passes,
            stop: self.stop,
        })
    }
}

impl<T: Scalar> AssociationContext<'_, T> {
    /// Returns a search within the passes left.
    ///
    /// * `used`: passes taken plus passes reserved after the search.
    fn search(&self, start: RectifyingRotations<T>, used: u16) -> PairSolver<T> {
        let Context { config, focal, .. } = *self.context;
        // A search needs at least the passes of a track.
        let left = config.max_passes.saturating_sub(used).max(TRACK_PASSES);
        PairSolver::search(config, focal, start, left)
    }

    /// Checks that a pose found by a search is an optimum of a valid scene with five observable directions.
    ///
    /// # Errors
    /// [`Rejection::Behind`], [`Rejection::NoDepth`], [`Rejection::NoConsensus`], [`Rejection::Unobservable`].
    fn check(&self, evaluated: &EvaluatedPose<T>) -> Result<(), Rejection> {
        let needed = self.context.config.min_correspondences;
        if let Some(why) = evaluated.no_scene(needed) {
            return Err(why);
        }
        if !evaluated.is_found(needed) {
            return Err(Rejection::NoConsensus);
        }
        if evaluated.measurement.moments.at_frame().information.is_observable() {
            Ok(())
        } else {
            Err(Rejection::Unobservable)
        }
    }

    /// Returns whether the mean truncated cost of a pose is lower than that of the challenger by more than
    /// [`CLEARLY_BETTER`]; true without a challenger.
    fn is_better(&self, pose: &RectifyingRotations<T>, pairs: &[RayPair<T>]) -> bool {
        self.hypotheses.challenger().is_none_or(|challenger| {
            let [new, old] = [pose, challenger.pose()].map(|pose| self.cost(pose, pairs));
            new < old - T::lit(CLEARLY_BETTER)
        })
    }

    /// Returns whether another pose may fit clearly better than the challenger, because many matches do not fit the
    /// challenger; true without a challenger.
    fn leaves_open(&self, pairs: &[RayPair<T>]) -> bool {
        let challenger = self.hypotheses.challenger();
        challenger.is_none_or(|challenger| self.cost(challenger.pose(), pairs) > T::lit(OPEN_COST))
    }

    /// Returns the mean truncated cost of a pose, 0 to 1.
    #[inline(never)]
    fn cost(&self, pose: &RectifyingRotations<T>, pairs: &[RayPair<T>]) -> T {
        let limit = T::lit(TRUNCATED_PX) / self.context.focal;
        let cost = |pair: &RayPair<T>| {
            pixel_row_offset(pose, pair).map_or(T::ONE, |e| (e * e / (limit * limit)).min(T::ONE))
        };
        let sum = pairs.iter().fold(T::ZERO, |sum, pair| sum + cost(pair));
        sum / T::count(u32::try_from(pairs.len()).unwrap_or(u32::MAX))
    }
}
