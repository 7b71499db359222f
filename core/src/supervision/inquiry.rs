//! What is asked of a batch, a pass at a time: does it agree with the champion, or else with the
//! challenger, or else with anything at all?

use super::{Lineage, Supervisor};
use crate::config::Config;
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::rectification::RectifyingRotations;
use crate::report::Stop;
use crate::residual::row_offset;
use crate::robust::{Descent, Judged, TRACK_PASSES};
use crate::scalar::Scalar;

/// A row offset counts fully from here on when two poses are compared, px.
const TRUNCATED_PX: f64 = 2.0;

/// A new hypothesis replaces a challenger if its mean truncated cost is lower by this.
const CLEARLY_BETTER: f64 = 0.04;

/// Rejected pairs in a row after which the rig is lost.
pub(super) const LOST_AFTER: u16 = 10;

/// A batch of no more correspondences may take twice the passes.
const FEW: usize = 128;

/// Which hypothesis a pair speaks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpeaksFor {
    Champion,
    Challenger,
    /// For a rig that nobody stands for yet.
    Itself,
    /// For one that is no better than the challenger, with whom it disagrees.
    Nobody,
}

/// What came of the questions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Finding<T: Scalar> {
    pub(crate) speaks_for: SpeaksFor,
    pub(crate) judged: Judged<T>,
    pub(crate) refused: Refused,
    pub(crate) repeated: bool,
    /// State of the supervisor that the questions were asked in.
    pub(crate) round: u32,
    pub(crate) passes: u16,
    pub(crate) stop: Stop,
}

/// Who a pair disagrees with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Refused {
    pub(crate) by_champion: bool,
    pub(crate) by_challenger: bool,
}

#[derive(Debug, Clone)]
enum Question<T: Scalar> {
    Champion(Descent<T>),
    Challenger(Descent<T>),
    Search(Descent<T>),
    Compare(Judged<T>, Stop),
}

/// A batch being asked.
#[derive(Debug, Clone)]
pub(crate) struct Inquiry<T: Scalar> {
    question: Question<T>,
    refused: Refused,
    repeated: bool,
    passes: u16,
}

/// All that the questions are about.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Subject<'a, T: Scalar> {
    pub(crate) config: &'a Config,
    pub(crate) focal: T,
    /// Correspondences in the batch.
    pub(crate) pairs: usize,
    pub(crate) supervisor: &'a Supervisor<T>,
    pub(crate) lineage: &'a Lineage<T>,
}

impl<T: Scalar> Inquiry<T> {
    pub(crate) fn new(subject: &Subject<'_, T>, repeated: bool) -> Self {
        let mut inquiry = Self {
            question: Question::Search(subject.search(0)),
            refused: Refused::default(),
            repeated,
            passes: 0,
        };
        if let Some(next) = subject.champion().or_else(|| subject.challenger()) {
            inquiry.question = next;
        }
        inquiry
    }

    /// Takes one more pass; what came of it once there are no questions left.
    ///
    /// # Errors
    /// [`PairError`]: the batch gives no answer.
    pub(crate) fn advance(
        &mut self,
        subject: &Subject<'_, T>,
        pairs: &[RayPair<T>],
    ) -> Result<Option<Finding<T>>, PairError> {
        self.passes = self.passes.saturating_add(1);
        let descent = match &mut self.question {
            Question::Compare(judged, stop) => {
                let (judged, stop) = (*judged, *stop);
                let better = subject.is_better(&judged.evidence.pose, pairs);
                let speaks = if better { SpeaksFor::Itself } else { SpeaksFor::Nobody };
                return Ok(Some(self.finding(subject, speaks, judged, stop)));
            }
            Question::Champion(descent)
            | Question::Challenger(descent)
            | Question::Search(descent) => descent,
        };
        if !descent.is_done() {
            descent.advance(pairs)?;
            return Ok(None);
        }
        let judged = descent.judge(pairs).ok_or(PairError::Unobservable)?;
        let stop = descent.stop();
        self.answer(subject, judged, stop)
    }

    fn answer(
        &mut self,
        subject: &Subject<'_, T>,
        judged: Judged<T>,
        stop: Stop,
    ) -> Result<Option<Finding<T>>, PairError> {
        let supervisor = subject.supervisor;
        let next = match &self.question {
            Question::Champion(_) => {
                if supervisor.champion_agrees(&judged, subject.lineage) {
                    return self.heard(subject, SpeaksFor::Champion, judged, stop);
                }
                self.refused.by_champion = true;
                subject
                    .challenger()
                    .unwrap_or_else(|| Question::Search(subject.search(self.passes)))
            }
            Question::Challenger(_) => {
                if supervisor.challenger_agrees(&judged, subject.lineage) {
                    return self.heard(subject, SpeaksFor::Challenger, judged, stop);
                }
                self.refused.by_challenger = true;
                if self.refused.by_champion {
                    return Ok(Some(self.finding(subject, SpeaksFor::Nobody, judged, stop)));
                }
                Question::Search(subject.search(self.passes.saturating_add(1)))
            }
            Question::Search(_) | Question::Compare(..) => {
                subject.found(&judged)?;
                if !self.refused.by_challenger {
                    return Ok(Some(self.finding(subject, SpeaksFor::Itself, judged, stop)));
                }
                Question::Compare(judged, stop)
            }
        };
        self.question = next;
        Ok(None)
    }

    /// A batch that agrees, if it says anything at all of the baseline.
    fn heard(
        &self,
        subject: &Subject<'_, T>,
        speaks_for: SpeaksFor,
        judged: Judged<T>,
        stop: Stop,
    ) -> Result<Option<Finding<T>>, PairError> {
        if judged.speaks_of_baseline {
            Ok(Some(self.finding(subject, speaks_for, judged, stop)))
        } else {
            Err(PairError::Unobservable)
        }
    }

    /// Who the batch disagrees with so far.
    pub(crate) fn refused(&self) -> Refused {
        self.refused
    }

    fn finding(
        &self,
        subject: &Subject<'_, T>,
        speaks_for: SpeaksFor,
        judged: Judged<T>,
        stop: Stop,
    ) -> Finding<T> {
        Finding {
            speaks_for,
            judged,
            refused: self.refused,
            repeated: self.repeated,
            round: subject.supervisor.round(),
            passes: self.passes,
            stop,
        }
    }
}

impl<T: Scalar> Subject<'_, T> {
    fn champion(&self) -> Option<Question<T>> {
        let filter = self.supervisor.champion()?;
        self.track(filter).map(Question::Champion)
    }

    fn challenger(&self) -> Option<Question<T>> {
        let filter = self.supervisor.challenger()?;
        self.track(filter).map(Question::Challenger)
    }

    fn track(&self, filter: &super::Filter<T>) -> Option<Descent<T>> {
        Descent::track(self.config, self.focal, &filter.known(self.lineage)?)
    }

    /// * `used`: passes that are gone, or needed after it.
    fn search(&self, used: u16) -> Descent<T> {
        let start = self.supervisor.search_start().unwrap_or(self.lineage.factory);
        // One is left for the judgement even where the configuration leaves none.
        let left = self.config.max_passes.saturating_sub(used).max(TRACK_PASSES);
        let search = Descent::search(self.config, self.focal, start, left);
        if self.pairs <= FEW { search.among_few() } else { search }
    }

    /// Whether a pose found from afar is one, and determined.
    fn found(&self, judged: &Judged<T>) -> Result<(), PairError> {
        if !judged.is_found(self.config.min_correspondences.into()) {
            return Err(PairError::NoConsensus);
        }
        let evidence = &judged.evidence;
        if judged.speaks_of_baseline && evidence.seen_at(&evidence.pose).information.is_observable()
        {
            Ok(())
        } else {
            Err(PairError::Unobservable)
        }
    }

    /// Whether a pose fits the batch clearly better than the challenger's.
    fn is_better(&self, pose: &RectifyingRotations<T>, pairs: &[RayPair<T>]) -> bool {
        let Some(challenger) = self.supervisor.challenger() else {
            return true;
        };
        let limit = T::lit(TRUNCATED_PX) / self.focal;
        let cost = |pose: &RectifyingRotations<T>, pair: &RayPair<T>| {
            row_offset(pose, pair).map_or(T::ONE, |e| (e * e / (limit * limit)).min(T::ONE))
        };
        let [mut new, mut old] = [T::ZERO; 2];
        for pair in pairs {
            new += cost(pose, pair);
            old += cost(challenger.pose(), pair);
        }
        let count = T::count(u32::try_from(pairs.len()).unwrap_or(u32::MAX));
        new < old - T::lit(CLEARLY_BETTER) * count
    }
}
