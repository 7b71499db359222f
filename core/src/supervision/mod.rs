//! Many pairs into one estimate that can be wrong and find out.
//!
//! The *champion* is the hypothesis that is reported. A pair that disagrees with it is not thrown
//! away: it founds a *challenger*, which gathers the pairs that agree with it. Three in all, if they
//! speak of another rig, and the challenger takes over, with its own sums; if the pairs return to the
//! champion, the challenger is dropped. A gate without this way out locks on a wrong answer and refuses
//! the truth.

mod champion;
mod filter;
mod halves;
mod inquiry;
mod stillness;

pub(crate) use filter::Filter;
pub(crate) use inquiry::{Finding, Inquiry, Refused, SpeaksFor, Subject};
pub(crate) use stillness::Stillness;

use crate::config::Config;
use crate::error::Refusal;
use crate::extrinsics::Extrinsics;
use crate::information::Information;
use crate::rectification::RectifyingRotations;
use crate::robust::Judged;
use crate::scalar::Scalar;
use champion::Champion;
use inquiry::LOST_AFTER;

/// Pairs that a challenger needs behind it.
const MIN_AGREED: u16 = 3;

/// Standard deviation of the weakest direction above which nothing is locked, rad.
const MAX_LOCKED_SD: f64 = 0.12;

/// How far the estimate can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum State {
    /// Not enough pairs agree yet.
    Acquiring,
    /// The last pair agrees with the estimate.
    Locked,
    /// The last pairs disagree with the estimate, or some did and speak for another.
    Suspect,
    /// Ten pairs in a row disagree with the estimate, and no three with each other.
    Lost,
}

impl core::fmt::Display for State {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Acquiring => "acquiring",
            Self::Locked => "locked",
            Self::Suspect => "suspect",
            Self::Lost => "lost",
        })
    }
}

/// What became of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fused {
    /// It is part of the estimate.
    Added,
    /// It shows the scene of the pair before it, in whose place it counts.
    Repeated,
    /// It disagrees with the estimate and is kept apart, for another one.
    KeptApart,
    /// It is part of the estimate, and the pairs of late have replaced the older ones: the rig drifts.
    Renewed,
    /// The pairs kept apart agree with each other: theirs is the estimate now.
    TookOver,
}

/// What every hypothesis goes back to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lineage<T: Scalar> {
    pub(crate) factory: RectifyingRotations<T>,
    /// About the factory extrinsics.
    pub(crate) prior: Information<T>,
    /// Pairs beyond which the oldest fade.
    pub(crate) memory: u32,
}

impl<T: Scalar> Lineage<T> {
    pub(crate) fn new(config: &Config, factory: &Extrinsics<T>) -> Self {
        Self {
            factory: RectifyingRotations::from(factory),
            prior: config.prior(),
            memory: config.memory_pairs,
        }
    }

    /// What is left of older pairs after one more, once there are as many as the memory holds.
    fn fading(&self) -> T {
        T::ONE - T::ONE / T::count(self.memory)
    }
}

/// A hypothesis on trial.
#[derive(Debug, Clone)]
struct Challenger<T: Scalar> {
    filter: Filter<T>,
    agreed: u16,
    failed: u16,
}

/// Champion and challenger. RAM: about 2 kB in `f32`.
#[derive(Debug, Clone)]
pub(crate) struct Supervisor<T: Scalar> {
    champion: Option<Champion<T>>,
    challenger: Option<Challenger<T>>,
    /// Pairs in a row that disagree with the champion.
    rejected: u16,
    /// Changes with every pair that has been dealt with.
    round: u32,
}

impl<T: Scalar> Supervisor<T> {
    pub(crate) const fn new() -> Self {
        Self { champion: None, challenger: None, rejected: 0, round: 0 }
    }

    pub(crate) fn forget(&mut self) {
        *self = Self { round: self.round.wrapping_add(1), ..Self::new() };
    }

    pub(crate) fn state(&self) -> State {
        match (&self.champion, &self.challenger) {
            (None, _) => State::Acquiring,
            _ if self.rejected >= LOST_AFTER => State::Lost,
            (Some(_), None) if self.rejected == 0 => State::Locked,
            _ => State::Suspect,
        }
    }

    /// The hypothesis that is reported: while there is no champion, the challenger.
    pub(crate) fn reported(&self) -> Option<&Filter<T>> {
        self.champion().or_else(|| self.challenger())
    }

    fn champion(&self) -> Option<&Filter<T>> {
        self.champion.as_ref().map(|champion| &champion.filter)
    }

    fn challenger(&self) -> Option<&Filter<T>> {
        self.challenger.as_ref().map(|challenger| &challenger.filter)
    }

    fn round(&self) -> u32 {
        self.round
    }

    /// Where a search starts: at the champion, and when that is lost every second time afresh.
    fn search_start(&self) -> Option<RectifyingRotations<T>> {
        let afresh = self.rejected >= LOST_AFTER && self.rejected.is_multiple_of(2);
        self.champion().filter(|_| !afresh).map(|filter| *filter.pose())
    }

    fn champion_agrees(&self, judged: &Judged<T>, lineage: &Lineage<T>) -> bool {
        self.champion().is_some_and(|filter| filter.agrees(judged, T::ONE, lineage))
    }

    fn challenger_agrees(&self, judged: &Judged<T>, lineage: &Lineage<T>) -> bool {
        // A young hypothesis without a rival may be a few deviations off.
        let slack = if self.champion.is_none() { T::lit(2.0) } else { T::ONE };
        judged.has_clear_peak()
            && self.challenger().is_some_and(|filter| filter.agrees(judged, slack, lineage))
    }

    /// A batch that gave no answer: who it disagreed with before that.
    pub(crate) fn note_failure(&mut self, refused: Refused) {
        self.round = self.round.wrapping_add(1);
        self.count(refused);
    }

    fn count(&mut self, refused: Refused) {
        if refused.by_champion {
            self.rejected = self.rejected.saturating_add(1);
        }
        if refused.by_challenger
            && let Some(challenger) = &mut self.challenger
        {
            challenger.failed = challenger.failed.saturating_add(1);
            if challenger.failed >= 2 && challenger.failed > challenger.agreed / 2 {
                self.challenger = None;
            }
        }
    }

    /// Takes a pair in.
    ///
    /// * `allowed`: whether an estimate may be held at all.
    ///
    /// # Errors
    /// [`Refusal`]; the champion is as it was. A challenger may be given up.
    pub(crate) fn fuse(
        &mut self,
        finding: &Finding<T>,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<Fused, Refusal> {
        if finding.round != self.round {
            return Err(Refusal::Stale);
        }
        let fused = self.admit(finding, lineage, allowed);
        self.round = self.round.wrapping_add(1);
        if fused.is_err() {
            // A hypothesis whose pairs lead to what may not be is no better than one without pairs.
            let speaks_for = finding.speaks_for;
            self.count(Refused {
                by_champion: finding.refused.by_champion || speaks_for == SpeaksFor::Champion,
                by_challenger: finding.refused.by_challenger || speaks_for == SpeaksFor::Challenger,
            });
        }
        fused
    }

    fn admit(
        &mut self,
        finding: &Finding<T>,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<Fused, Refusal> {
        let judged = &finding.judged;
        let repeated = finding.repeated;
        match finding.speaks_for {
            SpeaksFor::Champion => {
                let champion = self.champion.as_ref().ok_or(Refusal::Stale)?;
                let (next, renewed) =
                    champion.with(judged, repeated, lineage).ok_or(Refusal::NoRig)?;
                allowed(next.filter.pose())?;
                self.champion = Some(next);
                self.rejected = 0;
                self.challenger = self.challenger.take().and_then(Challenger::contradicted);
                Ok(match (renewed, repeated) {
                    (true, _) => Fused::Renewed,
                    (false, true) => Fused::Repeated,
                    (false, false) => Fused::Added,
                })
            }
            SpeaksFor::Challenger => {
                let challenger = self.challenger.as_ref().ok_or(Refusal::Stale)?;
                let filter = challenger.filter.with(judged, repeated, lineage);
                let filter = filter.ok_or(Refusal::NoRig)?;
                allowed(filter.pose())?;
                let agreed = challenger.agreed.saturating_add(1);
                let next = Challenger { filter, agreed, failed: challenger.failed };
                self.count(finding.refused);
                Ok(self.promote(next, lineage))
            }
            SpeaksFor::Itself => {
                let filter = Filter::born(judged, lineage).ok_or(Refusal::NoRig)?;
                allowed(filter.pose())?;
                self.count(finding.refused);
                let agreed = u16::from(self.champion.is_some());
                self.challenger = Some(Challenger { filter, agreed, failed: 0 });
                Ok(if self.champion.is_some() { Fused::KeptApart } else { Fused::Added })
            }
            SpeaksFor::Nobody => Err(Refusal::Disagrees),
        }
    }

    /// The challenger takes over if enough pairs are behind it.
    fn promote(&mut self, challenger: Challenger<T>, lineage: &Lineage<T>) -> Fused {
        let locked = T::lit(MAX_LOCKED_SD);
        let certain = challenger
            .filter
            .deviations(lineage)
            .is_some_and(|sd| sd.rotation <= locked && sd.translation <= locked);
        let had_champion = self.champion.is_some();
        let departs =
            self.champion().is_none_or(|old| challenger.filter.departs_from(old, lineage));
        if challenger.agreed >= MIN_AGREED && certain && departs {
            self.champion = Some(Champion::crowned(challenger.filter.reframed()));
            self.challenger = None;
            self.rejected = 0;
            return if had_champion { Fused::TookOver } else { Fused::Added };
        }
        self.challenger = Some(challenger);
        if had_champion { Fused::KeptApart } else { Fused::Added }
    }
}

impl<T: Scalar> Challenger<T> {
    /// After a pair that agrees with the champion.
    fn contradicted(mut self) -> Option<Self> {
        self.failed = self.failed.saturating_add(1);
        (self.failed < 2).then_some(self)
    }
}
