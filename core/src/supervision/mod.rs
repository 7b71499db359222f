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
mod optimum;
mod stillness;

use filter::Advance;
pub(crate) use filter::Filter;
pub(crate) use inquiry::{Finding, Inquiry, Refused, SpeaksFor, Subject};
pub(crate) use stillness::Stillness;

use crate::config::Config;
use crate::error::{Refusal, RestoreError};
use crate::extrinsics::Extrinsics;
use crate::record::{Reader, Writer};
use crate::rectification::RectifyingRotations;
use crate::robust::{Evidence, Judged};
use crate::scalar::Scalar;
use champion::Champion;
use inquiry::LOST_AFTER;

/// Pairs that a challenger needs behind it.
const MIN_AGREED: u16 = 3;

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

codes! { State { Acquiring = 0, Locked = 1, Suspect = 2, Lost = 3 } }

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

codes! { Fused { Added = 0, Repeated = 1, KeptApart = 2, Renewed = 3, TookOver = 4 } }

/// What every hypothesis goes back to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lineage<T: Scalar> {
    pub(crate) factory: RectifyingRotations<T>,
    /// Information on each unknown about the factory extrinsics, 1/rad^2.
    pub(crate) prior: T,
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

impl<T: Scalar> Challenger<T> {
    const EMPTY: Self = Self { filter: Filter::EMPTY, agreed: 0, failed: 0 };

    #[inline(never)]
    fn add(
        &mut self,
        evidence: &Evidence<T>,
        repeated: bool,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let mut advance = Advance::NONE;
        self.filter.next(evidence, repeated, lineage, allowed, &mut advance)?;
        self.filter.take(evidence, &advance, repeated, lineage);
        self.agreed = self.agreed.saturating_add(1);
        Ok(())
    }
}

/// Champion and challenger. RAM: about 2 kB in `f32`.
#[derive(Debug, Clone)]
pub(crate) struct Supervisor<T: Scalar> {
    champion: Option<Champion<T>>,
    challenger: Option<Challenger<T>>,
    /// Pairs in a row that disagree with the champion.
    rejected: u16,
    /// Changes with every pair that is begun or has been dealt with.
    round: u32,
}

impl<T: Scalar> Supervisor<T> {
    /// Numbers and words in the longest record.
    pub(crate) const NUMBERS: usize = Champion::<T>::NUMBERS + Filter::<T>::NUMBERS;
    pub(crate) const WORDS: usize = Champion::<T>::WORDS + Filter::<T>::WORDS + 5;

    pub(crate) const fn new() -> Self {
        Self { champion: None, challenger: None, rejected: 0, round: 0 }
    }

    pub(crate) fn forget(&mut self) {
        *self = Self { round: self.round.wrapping_add(1), ..Self::new() };
    }

    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        to.flag(self.champion.is_some());
        if let Some(champion) = &self.champion {
            champion.write(to);
        }
        to.flag(self.challenger.is_some());
        if let Some(Challenger { filter, agreed, failed }) = &self.challenger {
            filter.write(to);
            to.word((*agreed).into());
            to.word((*failed).into());
        }
        to.word(self.rejected.into());
    }

    /// In the place of one without pairs, or of what a failure has left. The champion is suspect until a
    /// pair confirms it.
    #[inline(never)]
    pub(crate) fn read(
        &mut self,
        from: &mut Reader<'_>,
        lineage: &Lineage<T>,
    ) -> Result<(), RestoreError> {
        let small = |word: u32| u16::try_from(word).map_err(|_| RestoreError::Absurd);
        if from.flag()? {
            self.make_room();
            let champion = self.champion.as_mut().ok_or(RestoreError::NotFresh)?;
            champion.read(from, lineage)?;
        }
        if from.flag()? {
            self.vacate();
            let challenger = self.challenger.as_mut().ok_or(RestoreError::NotFresh)?;
            challenger.filter.read(from, lineage)?;
            challenger.agreed = small(from.word()?)?;
            challenger.failed = small(from.word()?)?;
        }
        let rejected = small(from.word()?)?;
        if self.champion.is_some() {
            self.rejected = rejected.clamp(1, LOST_AFTER - 1);
        }
        Ok(())
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

    /// Another pair is begun: reports of those before it are stale.
    pub(crate) fn begin_round(&mut self) {
        self.round = self.round.wrapping_add(1);
    }

    /// Where a search starts: at the champion, and when that is lost every second time afresh.
    fn search_start(&self) -> Option<RectifyingRotations<T>> {
        let afresh = self.rejected >= LOST_AFTER && self.rejected.is_multiple_of(2);
        self.champion().filter(|_| !afresh).map(|filter| *filter.pose())
    }

    /// Distance of a pair that agrees with the champion, over the scatter of pairs.
    fn champion_agrees(&self, judged: &Judged<T>, lineage: &Lineage<T>) -> Option<T> {
        self.champion()?.agreement(judged, T::ONE, lineage)
    }

    /// The same for the challenger.
    fn challenger_agrees(&self, judged: &Judged<T>, lineage: &Lineage<T>) -> Option<T> {
        // A young hypothesis without a rival may be a few deviations off.
        let slack = if self.champion.is_none() { T::lit(2.0) } else { T::ONE };
        let challenger = self.challenger().filter(|_| judged.has_clear_peak())?;
        challenger.agreement(judged, slack, lineage)
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
        finding: &Finding<'_, T>,
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

    #[inline(never)]
    fn admit(
        &mut self,
        finding: &Finding<'_, T>,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<Fused, Refusal> {
        let evidence = &finding.judged.evidence;
        let repeated = finding.repeated;
        match finding.speaks_for {
            SpeaksFor::Champion => {
                let champion = self.champion.as_mut().ok_or(Refusal::Stale)?;
                let moved =
                    champion.add(evidence, finding.surprise, repeated, lineage, &allowed)?;
                let renewed = moved && champion.renew(lineage, allowed);
                self.rejected = 0;
                self.contradict_challenger();
                Ok(match (renewed, repeated) {
                    (true, _) => Fused::Renewed,
                    (false, true) => Fused::Repeated,
                    (false, false) => Fused::Added,
                })
            }
            SpeaksFor::Challenger => {
                let challenger = self.challenger.as_mut().ok_or(Refusal::Stale)?;
                challenger.add(evidence, repeated, lineage, allowed)?;
                self.count(finding.refused);
                Ok(self.promote(lineage))
            }
            SpeaksFor::Itself => {
                self.found(finding, lineage, allowed)?;
                Ok(if self.champion.is_some() { Fused::KeptApart } else { Fused::Added })
            }
            SpeaksFor::Nobody => Err(Refusal::Disagrees),
        }
    }

    /// Founds a challenger on a pair, in the place of any other.
    #[inline(never)]
    fn found(
        &mut self,
        finding: &Finding<'_, T>,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let evidence = &finding.judged.evidence;
        let mut advance = Advance::NONE;
        Filter::first(evidence, lineage, allowed, &mut advance)?;
        self.count(finding.refused);
        self.vacate();
        if let Some(challenger) = &mut self.challenger {
            challenger.filter.found(evidence, &advance, lineage);
            challenger.agreed = u16::from(self.champion.is_some());
        }
        Ok(())
    }

    /// A challenger without pairs. By itself: what is moved into place passes through the stack.
    #[inline(never)]
    fn vacate(&mut self) {
        self.challenger = Some(Challenger::EMPTY);
    }

    /// A champion without pairs, if there is none.
    #[inline(never)]
    fn make_room(&mut self) {
        if self.champion.is_none() {
            self.champion = Some(Champion::EMPTY);
        }
    }

    /// Lets the challenger take over if enough pairs are behind it.
    #[inline(never)]
    fn promote(&mut self, lineage: &Lineage<T>) -> Fused {
        let had_champion = self.champion.is_some();
        let takes_over = self.challenger.as_ref().is_some_and(|challenger| {
            challenger.agreed >= MIN_AGREED
                && challenger.filter.is_certain(lineage)
                && self.champion().is_none_or(|old| challenger.filter.departs_from(old, lineage))
        });
        if !takes_over {
            return if had_champion { Fused::KeptApart } else { Fused::Added };
        }
        self.make_room();
        if let (Some(champion), Some(challenger)) = (&mut self.champion, &self.challenger) {
            champion.crown(&challenger.filter);
        }
        self.challenger = None;
        self.rejected = 0;
        if had_champion { Fused::TookOver } else { Fused::Added }
    }

    /// After a pair that agrees with the champion.
    fn contradict_challenger(&mut self) {
        if let Some(challenger) = &mut self.challenger {
            challenger.failed = challenger.failed.saturating_add(1);
            if challenger.failed >= 2 {
                self.challenger = None;
            }
        }
    }
}
