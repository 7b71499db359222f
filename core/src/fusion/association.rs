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
use crate::pair::iterate::Iterate;
use crate::pair::solver::PairSolver;
use crate::scalar::Scalar;
use crate::state::Stop;
use crate::thresholds::{CLEARLY_BETTER, OPEN_COST, TRACK_PASSES, TRUNCATED_PX};

/// Number of passes reserved after a search with the baseline turned: a comparison with the challenger, a track from
/// the challenger, a search of the least length, and another comparison. Track and search include their evaluations.
const AFTER_TURNED: u16 = 2 * TRACK_PASSES + 2;

/// Task of the next pass of an association.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
enum Task<T: Scalar> {
    /// No batch is being associated.
    Idle,
    /// A pass of a solver, or the evaluation of its pose.
    Solve(Start, PairSolver<T>),
    /// The pose is evaluated, and this follows.
    Evaluated(Next, EvaluatedPose<T>),
}

/// Start of a solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    /// A search with the baseline turned, before the first champion. If the pose found fits clearly better than the
    /// challenger, or there is no challenger, the batch is refused. Otherwise it is then tracked from the challenger.
    Turned(Turn),
    /// A track from the champion.
    Champion,
    /// A track from the challenger.
    Challenger,
    /// A search with a wide loss, from the champion or from the factory extrinsics.
    Search,
}

/// Task after the evaluation of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// A comparison of the pose found with the baseline turned with that of the challenger.
    CompareTurned(Turn),
    /// A comparison of the pose that a search has found with that of the challenger, which has rejected the batch.
    CompareFound,
    /// Nothing: the batch has a result.
    Done(Support),
    /// Nothing: the batch has no result.
    Refused,
}

/// Association of one batch.
#[derive(Debug, Clone)]
pub(super) struct Association<T: Scalar> {
    task: Task<T>,
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
        task: Task::Idle,
        rejected: Rejected { by_champion: false, by_challenger: false },
        moved: Moved::FAR,
        passes: 0,
        stop: Stop::PassesSpent,
    };

    /// Returns whether passes are left.
    pub(super) fn is_open(&self) -> bool {
        match self.task {
            Task::Idle | Task::Evaluated(Next::Done(_) | Next::Refused, _) => false,
            Task::Solve(..) | Task::Evaluated(..) => true,
        }
    }

    /// Returns whether the last batch repeated the scene of the last pair that was added.
    pub(super) fn is_repeated(&self) -> bool {
        self.moved.is_repeated()
    }

    /// Drops the batch and its result, and forgets the motion of its scene.
    pub(super) fn forget(&mut self) {
        (self.task, self.moved) = (Task::Idle, Moved::FAR);
    }

    /// Drops the batch and its result.
    pub(super) fn close(&mut self) {
        self.task = Task::Idle;
    }

    /// Begins a batch.
    ///
    /// * `moved`: motion of the scene of the batch since the key frame.
    /// * `turn`: turn of the baseline to try first. The turn is not tried if most matches fit the challenger, or if the
    ///   configuration allows too few passes.
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
            Some(turn) => self.enter(Start::Turned(turn), with),
            None => self.enter(Start::Champion, with),
        }
    }

    /// Starts a solver, or a later one if its hypothesis does not exist or its track cannot start.
    #[inline(never)]
    fn enter(&mut self, start: Start, with: &AssociationContext<'_, T>) {
        if let Start::Turned(turn) = start {
            let pose = turn.of(with.context.factory).unwrap_or(with.context.factory_pose);
            self.search(start, with, pose, AFTER_TURNED);
            return;
        }
        let (champion, challenger) = (with.hypotheses.champion(), with.hypotheses.challenger());
        let tracks = [
            (Start::Champion, champion.filter(|_| start == Start::Champion)),
            (Start::Challenger, challenger.filter(|_| start != Start::Search)),
        ];
        for (start, hypothesis) in tracks {
            if hypothesis.is_some_and(|hypothesis| self.track(start, hypothesis, with)) {
                return;
            }
        }
        let pose = with.hypotheses.search_start().unwrap_or(with.context.factory_pose);
        // If the challenger has rejected the batch, a comparison with it takes one more pass.
        self.search(Start::Search, with, pose, u16::from(self.rejected.by_challenger));
    }

    /// Starts a track from a hypothesis. Returns false if the hypothesis has no covariance, or if the covariance of the
    /// start has no inverse.
    #[inline(never)]
    fn track(
        &mut self,
        start: Start,
        hypothesis: &Hypothesis<T>,
        with: &AssociationContext<'_, T>,
    ) -> bool {
        let Context { config, focal, .. } = *with.context;
        let from = hypothesis.track_start(with.context);
        let solver = from.and_then(|from| PairSolver::track(config, focal, &from));
        match solver {
            Some(solver) => {
                self.task = Task::Solve(start, solver);
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
        start: Start,
        with: &AssociationContext<'_, T>,
        pose: RectifyingRotations<T>,
        after: u16,
    ) {
        let used = self.passes.saturating_add(after);
        self.task = Task::Solve(start, with.search(pose, used));
    }

    /// Takes one more pass, if one is left.
    ///
    /// # Errors
    /// [`Rejection`]: the batch has no result.
    pub(super) fn advance(
        &mut self,
        with: &AssociationContext<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        self.passes = self.passes.saturating_add(1);
        let is_turned = matches!(self.task, Task::Solve(Start::Turned(_), _));
        let taken = self.take_pass(with, matches);
        if taken.is_err() && is_turned && with.hypotheses.challenger().is_some() {
            self.enter(Start::Challenger, with);
            return Ok(());
        }
        taken
    }

    /// Takes a pass of the task.
    ///
    /// # Errors
    /// [`Rejection`]: the solver has no pose, or its pose fits no valid scene. [`Rejection::Behind`],
    /// [`Rejection::Columns`]: a turned baseline fits clearly better than the challenger, or there is no challenger.
    fn take_pass(
        &mut self,
        with: &AssociationContext<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        match &mut self.task {
            Task::Solve(_, solver) if !solver.is_done() => solver.advance(matches),
            Task::Solve(start, solver) => {
                let start = *start;
                self.stop = solver.stop();
                let iterate = *solver.iterate();
                self.evaluate(&iterate, matches)?;
                self.decide(start, with)
            }
            Task::Evaluated(Next::CompareTurned(turn), evaluated) => {
                if with.is_better(&evaluated.measurement.pose, matches) {
                    return Err(turn.error());
                }
                self.enter(Start::Challenger, with);
                Ok(())
            }
            Task::Evaluated(next @ Next::CompareFound, evaluated) => {
                let is_better = with.is_better(&evaluated.measurement.pose, matches);
                *next = Next::Done(if is_better { Support::New } else { Support::None });
                Ok(())
            }
            Task::Idle | Task::Evaluated(Next::Done(_) | Next::Refused, _) => Ok(()),
        }
    }

    /// Evaluates the pose of the solver. The result replaces the solver in memory.
    ///
    /// # Errors
    /// [`Rejection::TooFew`], [`Rejection::Unobservable`].
    #[inline(never)]
    fn evaluate(&mut self, iterate: &Iterate<T>, matches: &[RayPair<T>]) -> Result<(), Rejection> {
        self.clear_evaluation();
        match &mut self.task {
            Task::Evaluated(_, evaluated) => iterate.evaluate(matches, evaluated),
            Task::Idle | Task::Solve(..) => Ok(()),
        }
    }

    /// Replaces the solver by an empty evaluation.
    fn clear_evaluation(&mut self) {
        self.task = Task::Evaluated(Next::Refused, EvaluatedPose::NONE);
    }

    /// Sets what follows an evaluation, and notes a hypothesis that rejects the batch. After a track the gate of its
    /// hypothesis decides; after a search the check of the pose decides.
    ///
    /// * `start`: start of the solver whose pose has been evaluated.
    ///
    /// # Errors
    /// As [`AssociationContext::check`]; [`Rejection::NoConsensus`] also if a turned baseline has most of the points
    /// that fit not clearly in front of the cameras.
    fn decide(&mut self, start: Start, with: &AssociationContext<'_, T>) -> Result<(), Rejection> {
        let AssociationContext { context, hypotheses } = *with;
        let Task::Evaluated(next, evaluated) = &mut self.task else {
            return Err(Rejection::NotBegun);
        };
        match start {
            Start::Champion if hypotheses.gate_of_champion(evaluated, context) => {
                *next = Next::Done(Support::Champion);
            }
            Start::Champion => {
                self.rejected.by_champion = true;
                self.enter(Start::Challenger, with);
            }
            Start::Challenger if hypotheses.gate_of_challenger(evaluated, context) => {
                *next = Next::Done(Support::Challenger);
            }
            Start::Challenger => {
                self.rejected.by_challenger = true;
                if self.rejected.by_champion {
                    *next = Next::Done(Support::None);
                } else {
                    self.enter(Start::Search, with);
                }
            }
            Start::Search => {
                with.check(evaluated)?;
                let compares = self.rejected.by_challenger;
                *next = if compares { Next::CompareFound } else { Next::Done(Support::New) };
            }
            Start::Turned(turn) => {
                if !evaluated.is_clearly_in_front() {
                    return Err(Rejection::NoConsensus);
                }
                with.check(evaluated)?;
                *next = Next::CompareTurned(turn);
            }
        }
        Ok(())
    }

    /// Returns whether the last pass has compared a pose with the baseline turned.
    pub(super) fn is_turned(&self) -> bool {
        matches!(self.task, Task::Evaluated(Next::CompareTurned(_), _))
    }

    /// Returns the hypotheses whose gates have rejected the batch so far.
    pub(super) fn rejected(&self) -> Rejected {
        self.rejected
    }

    /// Returns the result; `None` while passes are left, and without a batch.
    pub(super) fn result(&self) -> Option<AssociationResult<'_, T>> {
        let Task::Evaluated(Next::Done(support), evaluated) = &self.task else { return None };
        Some(AssociationResult {
            support: *support,
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
    fn cost(&self, pose: &RectifyingRotations<T>, pairs: &[RayPair<T>]) -> T {
        let limit = T::lit(TRUNCATED_PX) / self.context.focal;
        let cost = |pair: &RayPair<T>| {
            pixel_row_offset(pose, pair).map_or(T::ONE, |e| (e * e / (limit * limit)).min(T::ONE))
        };
        let sum = pairs.iter().fold(T::ZERO, |sum, pair| sum + cost(pair));
        sum / T::count(u32::try_from(pairs.len()).unwrap_or(u32::MAX))
    }
}
