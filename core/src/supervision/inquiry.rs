//! What is asked of a batch, a pass at a time: does it agree with the champion, or else with the
//! challenger, or else with anything at all?

use super::{Lineage, Supervisor};
use crate::batch::Matches;
use crate::config::Config;
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::rectification::RectifyingRotations;
use crate::report::Stop;
use crate::residual::row_offset;
use crate::robust::{Descent, Judged, Known, TRACK_PASSES};
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
#[derive(Debug, Clone, Copy)]
pub(crate) struct Finding<'a, T: Scalar> {
    pub(crate) speaks_for: SpeaksFor,
    pub(crate) judged: &'a Judged<T>,
    /// Distance from the estimate that it speaks for, over the scatter of pairs.
    pub(crate) surprise: T,
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

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    /// Nothing: there is no batch.
    None,
    Champion,
    Challenger,
    Search,
    /// Whether what was found fits the batch better than the challenger.
    Compare,
    Answered(SpeaksFor),
}

/// What is worked on: the way to a pose, then the judgement of it, one in the place of the other.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
enum Work<T: Scalar> {
    None,
    Descent(Descent<T>),
    Judged(Judged<T>),
}

/// A batch being asked.
#[derive(Debug, Clone)]
pub(crate) struct Inquiry<T: Scalar> {
    question: Question,
    work: Work<T>,
    refused: Refused,
    repeated: bool,
    round: u32,
    passes: u16,
    stop: Stop,
    surprise: T,
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
    pub(crate) const NONE: Self = Self {
        question: Question::None,
        work: Work::None,
        refused: Refused { by_champion: false, by_challenger: false },
        repeated: false,
        round: 0,
        passes: 0,
        stop: Stop::PassLimit,
        surprise: T::ZERO,
    };

    /// Whether there are questions left.
    pub(crate) fn is_open(&self) -> bool {
        !matches!(self.question, Question::None | Question::Answered(_))
    }

    /// Drops the batch and all that it was asked.
    pub(crate) fn close(&mut self) {
        self.question = Question::None;
    }

    /// Asks a new batch the first question.
    #[inline(never)]
    pub(crate) fn open(&mut self, subject: &Subject<'_, T>, repeated: bool) {
        self.refused = Refused::default();
        self.repeated = repeated;
        self.round = subject.supervisor.round();
        self.passes = 0;
        self.ask(Question::Champion, subject);
    }

    /// Asks a question, or the next one if there is nobody to ask about.
    #[inline(never)]
    fn ask(&mut self, question: Question, subject: &Subject<'_, T>) {
        let (champion, challenger) =
            (subject.supervisor.champion(), subject.supervisor.challenger());
        let (asked, filter) = match question {
            Question::Champion if champion.is_some() => (question, champion),
            Question::Champion | Question::Challenger => (Question::Challenger, challenger),
            _ => (question, None),
        };
        self.question = asked;
        if !filter.is_some_and(|filter| self.track(filter, subject)) {
            self.question = Question::Search;
            self.search(subject);
        }
    }

    /// Sets out from a running estimate, if that can be.
    #[inline(never)]
    fn track(&mut self, filter: &super::Filter<T>, subject: &Subject<'_, T>) -> bool {
        let known = filter.known(subject.lineage);
        let track = |known: Known<T>| Descent::track(subject.config, subject.focal, &known);
        match known.and_then(track) {
            Some(descent) => {
                self.work = Work::Descent(descent);
                true
            }
            None => false,
        }
    }

    /// Sets out from afar.
    #[inline(never)]
    fn search(&mut self, subject: &Subject<'_, T>) {
        self.work = Work::Descent(subject.search(self.used()));
    }

    /// Passes that are gone, or needed after a search.
    fn used(&self) -> u16 {
        self.passes.saturating_add(u16::from(self.refused.by_challenger))
    }

    /// Takes one more pass, unless there are no questions left.
    ///
    /// # Errors
    /// [`PairError`]: the batch gives no answer.
    pub(crate) fn advance(
        &mut self,
        subject: &Subject<'_, T>,
        matches: Matches<'_, T>,
    ) -> Result<(), PairError> {
        self.passes = self.passes.saturating_add(1);
        match &mut self.work {
            Work::Descent(descent) if !descent.is_done() => descent.advance(matches),
            Work::Descent(_) => {
                self.judge(matches)?;
                let next = self.next(subject)?;
                self.question = next;
                if matches!(next, Question::Challenger | Question::Search) {
                    self.ask(next, subject);
                }
                Ok(())
            }
            Work::Judged(judged) => {
                let better = subject.is_better(&judged.evidence.pose, matches.pairs);
                let speaks = if better { SpeaksFor::Itself } else { SpeaksFor::Nobody };
                self.question = Question::Answered(speaks);
                Ok(())
            }
            Work::None => Ok(()),
        }
    }

    #[inline(never)]
    fn judge(&mut self, matches: Matches<'_, T>) -> Result<(), PairError> {
        let Work::Descent(descent) = &self.work else {
            return Ok(());
        };
        self.stop = descent.stop();
        let outlook = *descent.outlook();
        self.clear_judgement();
        match &mut self.work {
            Work::Judged(judged) => outlook.judge(matches, judged),
            _ => Ok(()),
        }
    }

    /// By itself: what is moved into place passes through the stack.
    #[inline(never)]
    fn clear_judgement(&mut self) {
        self.work = Work::Judged(Judged::NOTHING);
    }

    /// The next question after a judgement, or the answer.
    #[inline(never)]
    fn next(&mut self, subject: &Subject<'_, T>) -> Result<Question, PairError> {
        let supervisor = subject.supervisor;
        let Work::Judged(judged) = &self.work else {
            return Err(PairError::NotBegun);
        };
        match self.question {
            Question::Champion => {
                if let Some(surprise) = supervisor.champion_agrees(judged, subject.lineage) {
                    self.surprise = surprise;
                    return heard(SpeaksFor::Champion, judged);
                }
                self.refused.by_champion = true;
                Ok(Question::Challenger)
            }
            Question::Challenger => {
                if let Some(surprise) = supervisor.challenger_agrees(judged, subject.lineage) {
                    self.surprise = surprise;
                    return heard(SpeaksFor::Challenger, judged);
                }
                self.refused.by_challenger = true;
                Ok(if self.refused.by_champion {
                    Question::Answered(SpeaksFor::Nobody)
                } else {
                    Question::Search
                })
            }
            _ => {
                subject.found(judged)?;
                Ok(if self.refused.by_challenger {
                    Question::Compare
                } else {
                    Question::Answered(SpeaksFor::Itself)
                })
            }
        }
    }

    /// Who the batch disagrees with so far.
    pub(crate) fn refused(&self) -> Refused {
        self.refused
    }

    /// What came of the questions, once there are none left.
    pub(crate) fn finding(&self) -> Option<Finding<'_, T>> {
        let (Question::Answered(speaks_for), Work::Judged(judged)) = (self.question, &self.work)
        else {
            return None;
        };
        Some(Finding {
            speaks_for,
            judged,
            surprise: self.surprise,
            refused: self.refused,
            repeated: self.repeated,
            round: self.round,
            passes: self.passes,
            stop: self.stop,
        })
    }
}

/// A batch that agrees, if it says anything at all of the baseline.
fn heard<T: Scalar>(speaks_for: SpeaksFor, judged: &Judged<T>) -> Result<Question, PairError> {
    if judged.speaks_of_baseline {
        Ok(Question::Answered(speaks_for))
    } else {
        Err(PairError::Unobservable)
    }
}

impl<T: Scalar> Subject<'_, T> {
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
        if judged.speaks_of_baseline && evidence.moments.at_frame().information.is_observable() {
            Ok(())
        } else {
            Err(PairError::Unobservable)
        }
    }

    /// Whether a pose fits the batch clearly better than the challenger's.
    #[inline(never)]
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
