//! Champion and challenger: how hypotheses start, gain support, are promoted and end (`ESTIMATOR.md`, section 13).

use super::association_result::{AssociationResult, Rejected, Support};
use super::change_detector::{ChangeDetector, Finding};
use super::hypothesis::{Hypothesis, Update};
use super::key_frame::Moved;
use super::lens_reference::LensReference;
use super::prior::Prior;
use super::turn::Turn;
use crate::config::Context;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::pair_report::Fused;
use crate::pair::evaluate::{EvaluatedPose, PairMeasurement};
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{LOST_AFTER, MAX_FAILED, MIN_AGREED, MIN_REFERENCE_PAIRS, YOUNG_SLACK};

/// The reported hypothesis.
#[derive(Debug, Clone)]
struct Champion<T: Scalar> {
    hypothesis: Hypothesis<T>,
    detector: ChangeDetector<T>,
}

impl<T: Scalar> Champion<T> {
    /// A champion without pairs. A promotion or a prior fills it in place.
    const EMPTY: Self = Self { hypothesis: Hypothesis::EMPTY, detector: ChangeDetector::NEW };

    /// Adds a pair. Returns the finding of the change detector.
    ///
    /// # Errors
    /// [`Rejection`]; the champion is unchanged.
    #[inline(never)]
    fn add(
        &mut self,
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
    ) -> Result<Finding, Rejection> {
        let mut update = Update::NONE;
        self.hypothesis.next_update(measurement, context, &mut update)?;
        let mode = self.hypothesis.mode();
        self.hypothesis.apply(measurement, &mut update, context);
        let Self { hypothesis, detector } = self;
        if hypothesis.mode() != mode {
            // The variance of the window assumes another kind of rig (rigid or vibrating) for its earlier pairs, or the
            // frame of the sums has changed ([`Hypothesis::apply`]) and the window's moments are in the old frame.
            detector.restart();
        }
        Ok(detector.add(hypothesis, &update.pair, measurement, context))
    }

    /// Adds a pair, and replaces the sums of the hypothesis by the window when the rig has changed, and again once the
    /// window holds only later pairs. Returns [`Fused::Renewed`] only for the first of these two replacements.
    ///
    /// # Errors
    /// [`Rejection`]; the champion is unchanged.
    fn fuse(
        &mut self,
        measurement: &PairMeasurement<T>,
        reference: &mut LensReference<T>,
        context: &Context<'_, T>,
    ) -> Result<Fused, Rejection> {
        let finding = self.add(measurement, context)?;
        let Self { hypothesis, detector } = self;
        let is_change = finding == Finding::Changed;
        // The lens is learnt only at the change itself. At the renewal after it ([`Finding::Settled`]) it has already
        // been learnt from the sums before the change.
        let learned = is_change.then(|| reference.with_knowledge_of(hypothesis, context));
        let is_renewed = finding != Finding::Same && detector.renew(hypothesis, is_change, context);
        let Some(learned) = learned.filter(|_| is_renewed) else { return Ok(Fused::Added) };
        *reference = learned;
        Ok(Fused::Renewed)
    }
}

/// A hypothesis under test.
#[derive(Debug, Clone)]
struct Challenger<T: Scalar> {
    hypothesis: Hypothesis<T>,
    /// Number of pairs that agree with the challenger. Copied pairs do not count, and the pair that began the
    /// challenger counts only if there is a champion.
    agreed: u16,
    /// Number of pairs that contradict the challenger: its gate rejects them, they support the champion, or they cannot
    /// be added to the challenger.
    failed: u16,
}

impl<T: Scalar> Challenger<T> {
    const EMPTY: Self = Self { hypothesis: Hypothesis::EMPTY, agreed: 0, failed: 0 };

    /// Adds a pair that agrees. A repeated scene is not added to the sums.
    ///
    /// # Errors
    /// [`Rejection`]; the challenger is unchanged.
    #[inline(never)]
    fn add(
        &mut self,
        measurement: &PairMeasurement<T>,
        moved: Moved,
        context: &Context<'_, T>,
    ) -> Result<(), Rejection> {
        if !moved.is_repeated() {
            let mut update = Update::NONE;
            self.hypothesis.next_update(measurement, context, &mut update)?;
            self.hypothesis.apply(measurement, &mut update, context);
        }
        // A copied pair always agrees with its original, so it does not count.
        self.agreed = self.agreed.saturating_add(u16::from(!moved.is_copy()));
        Ok(())
    }
}

/// Champion and challenger. RAM: about 2.5 kB in `f32`.
#[derive(Debug, Clone)]
pub(super) struct Hypotheses<T: Scalar> {
    champion: Option<Champion<T>>,
    challenger: Option<Challenger<T>>,
    /// Number of successive pairs that disagree with the champion.
    rejected: u16,
    /// Whether pairs have supported the champion since it was restored.
    is_confirmed: bool,
    /// Number of pairs begun before the first champion, since the caller last discarded a solved pair.
    begun: u16,
}

impl<T: Scalar> Hypotheses<T> {
    pub(super) const NONE: Self =
        Self { champion: None, challenger: None, rejected: 0, is_confirmed: false, begun: 0 };

    /// Drops both hypotheses. Works field by field, because [`Hypotheses::NONE`] would copy 2.5 kB.
    pub(super) fn clear(&mut self) {
        (self.champion, self.challenger) = (None, None);
        (self.rejected, self.is_confirmed, self.begun) = (0, false, 0);
    }

    /// Counts the next pair, and returns the turn of the baseline that it tries first; `None` once there is a champion.
    /// If one pair agrees with a challenger, the next pair tries a quarter turn; if two pairs agree, the next pair
    /// tries a quarter turn in the other direction. Without a challenger, every second pair from the fourth on tries
    /// the next turn of the cycle. A challenger needs no test of a half turn, because a search refuses poses with
    /// points behind the cameras.
    pub(super) fn next_turn(&mut self) -> Option<Turn> {
        if self.champion.is_some() {
            return None;
        }
        self.begun = self.begun.saturating_add(1);
        match &self.challenger {
            Some(challenger) => match challenger.agreed {
                1 => Some(Turn::Quarter),
                2 => Some(Turn::ThreeQuarters),
                _ => None,
            },
            None if self.begun > MIN_AGREED && self.begun.is_multiple_of(2) => {
                Some(Turn::of_number(self.begun / 2))
            }
            None => None,
        }
    }

    /// Resets the count of pairs begun, because the caller has discarded a solved pair. If pairs are not fused, the
    /// lack of a challenger does not mean that they disagree.
    pub(super) fn forget_begun(&mut self) {
        self.begun = 0;
    }

    /// Drops a challenger because a turned baseline fits better.
    pub(super) fn drop_challenger(&mut self) {
        self.challenger = None;
    }

    /// Returns the state of the estimate, according to the last pairs.
    pub(super) fn state(&self) -> State {
        match (&self.champion, &self.challenger) {
            (None, _) => State::Acquiring,
            _ if self.rejected >= LOST_AFTER => State::Lost,
            (Some(_), None) if self.rejected == 0 => State::Locked,
            _ => State::Suspect,
        }
    }

    /// Returns whether pairs have supported the estimate: three that agreed with each other, or one after a restore.
    pub(super) fn is_confirmed(&self) -> bool {
        self.is_confirmed
    }

    /// Returns the reported hypothesis: the champion, or the challenger before the first champion.
    pub(super) fn reported(&self) -> Option<&Hypothesis<T>> {
        self.champion().or_else(|| self.challenger())
    }

    pub(super) fn champion(&self) -> Option<&Hypothesis<T>> {
        self.champion.as_ref().map(|champion| &champion.hypothesis)
    }

    pub(super) fn challenger(&self) -> Option<&Hypothesis<T>> {
        self.challenger.as_ref().map(|challenger| &challenger.hypothesis)
    }

    /// Returns the pose of the champion as the start of a search. `None` if the search starts at the factory
    /// extrinsics: without a champion, and at every second pair of a lost rig.
    pub(super) fn search_start(&self) -> Option<RectifyingRotations<T>> {
        let afresh = self.rejected >= LOST_AFTER && self.rejected.is_multiple_of(2);
        self.champion().filter(|_| !afresh).map(|champion| *champion.pose())
    }

    /// Returns whether a pair is inside the champion's gate.
    pub(super) fn gate_of_champion(
        &self,
        evaluated: &EvaluatedPose<T>,
        context: &Context<'_, T>,
    ) -> bool {
        self.champion().is_some_and(|champion| champion.gate(evaluated, T::ONE, context))
    }

    /// Returns whether a pair has a clear peak and is inside the challenger's gate.
    pub(super) fn gate_of_challenger(
        &self,
        evaluated: &EvaluatedPose<T>,
        context: &Context<'_, T>,
    ) -> bool {
        // Without a champion, the challenger is based on few pairs and may be a few standard deviations off.
        let slack = if self.champion.is_none() { T::lit(YOUNG_SLACK) } else { T::ONE };
        self.challenger()
            .filter(|_| evaluated.has_clear_peak())
            .is_some_and(|challenger| challenger.gate(evaluated, slack, context))
    }

    /// Counts a pair against the hypotheses whose gates rejected it. Drops the challenger if at least [`MAX_FAILED`]
    /// pairs contradict it, and more than half as many as agree with it.
    pub(super) fn count(&mut self, rejected: Rejected) {
        if rejected.by_champion {
            self.rejected = self.rejected.saturating_add(1);
        }
        if rejected.by_challenger
            && let Some(Challenger { agreed, .. }) = &self.challenger
        {
            self.contradict_challenger(agreed / 2);
        }
    }

    /// Counts a pair against the challenger. Drops the challenger if the number of such pairs is at least
    /// [`MAX_FAILED`] and exceeds `tolerated`.
    fn contradict_challenger(&mut self, tolerated: u16) {
        if let Some(challenger) = &mut self.challenger {
            challenger.failed = challenger.failed.saturating_add(1);
            if challenger.failed >= MAX_FAILED && challenger.failed > tolerated {
                self.challenger = None;
            }
        }
    }

    /// Fuses an associated pair.
    ///
    /// * `reference`: takes the knowledge of the lens from sums that are dropped.
    ///
    /// # Errors
    /// [`Rejection`]; the champion's sums are unchanged. The pair counts against the hypothesis that it supports and
    /// against the hypotheses that rejected it, so a challenger may be dropped.
    pub(super) fn fuse(
        &mut self,
        result: &AssociationResult<'_, T>,
        reference: &mut LensReference<T>,
        context: &Context<'_, T>,
    ) -> Result<Fused, Rejection> {
        let fused = self.add(result, reference, context);
        if fused.is_err() {
            let AssociationResult { support, rejected, .. } = *result;
            self.count(Rejected {
                by_champion: rejected.by_champion || support == Support::Champion,
                by_challenger: rejected.by_challenger || support == Support::Challenger,
            });
        }
        fused
    }

    /// Adds a pair to the hypothesis that it supports. A pair that supports the champion counts against the challenger.
    #[inline(never)]
    fn add(
        &mut self,
        result: &AssociationResult<'_, T>,
        reference: &mut LensReference<T>,
        context: &Context<'_, T>,
    ) -> Result<Fused, Rejection> {
        match result.support {
            Support::Champion => {
                let fused = if result.moved.is_repeated() {
                    Fused::Repeated
                } else {
                    let champion = self.champion.as_mut().ok_or(Rejection::NotBegun)?;
                    champion.fuse(&result.evaluated.measurement, reference, context)?
                };
                (self.rejected, self.is_confirmed) = (0, true);
                self.contradict_challenger(0);
                Ok(fused)
            }
            Support::Challenger => {
                let challenger = self.challenger.as_mut().ok_or(Rejection::NotBegun)?;
                challenger.add(&result.evaluated.measurement, result.moved, context)?;
                self.count(result.rejected);
                Ok(self.promote(reference, context))
            }
            Support::New => {
                self.begin_challenger(result, context)?;
                Ok(if self.champion.is_some() { Fused::KeptApart } else { Fused::Added })
            }
            Support::None => Err(Rejection::Disagrees),
        }
    }

    /// Starts a challenger with a pair, in place of any other challenger.
    #[inline(never)]
    fn begin_challenger(
        &mut self,
        result: &AssociationResult<'_, T>,
        context: &Context<'_, T>,
    ) -> Result<(), Rejection> {
        let measurement = &result.evaluated.measurement;
        let mut update = Update::NONE;
        Hypothesis::first_update(measurement, context, &mut update)?;
        self.count(result.rejected);
        self.clear_challenger();
        if let Some(challenger) = &mut self.challenger {
            challenger.hypothesis.begin(measurement, &update, context);
            challenger.agreed = u16::from(self.champion.is_some());
        }
        Ok(())
    }

    /// Replaces the challenger by an empty one. Out of line, to keep the new value off the caller's stack.
    #[inline(never)]
    fn clear_challenger(&mut self) {
        self.challenger = Some(Challenger::EMPTY);
    }

    /// Creates an empty champion if no champion exists. Out of line, like [`Hypotheses::clear_challenger`].
    #[inline(never)]
    fn make_champion(&mut self) {
        if self.champion.is_none() {
            self.champion = Some(Champion::EMPTY);
        }
    }

    /// Promotes the challenger to champion once [`MIN_AGREED`] pairs agree with it and its `R` is certain; if it does not
    /// differ from the champion by more than chance, once [`MIN_REFERENCE_PAIRS`] do. Until then the champion takes over
    /// the noise of such a challenger: a track assumes the noise of the pairs before, so a champion rejects pairs of
    /// much larger noise. If this was the reason, the next two pairs support the champion and end the challenger.
    #[inline(never)]
    fn promote(&mut self, reference: &mut LensReference<T>, context: &Context<'_, T>) -> Fused {
        let had_champion = self.champion.is_some();
        let is_supported = self.challenger.as_ref().is_some_and(|challenger| {
            challenger.agreed >= MIN_AGREED && challenger.hypothesis.is_certain(context)
        });
        if !is_supported {
            return if had_champion { Fused::KeptApart } else { Fused::Added };
        }
        if let (Some(champion), Some(challenger)) = (&mut self.champion, &self.challenger)
            && u32::from(challenger.agreed) < MIN_REFERENCE_PAIRS
            && !challenger.hypothesis.departs_from(&champion.hypothesis, context)
        {
            champion.hypothesis.take_noise_of(&challenger.hypothesis);
            return Fused::KeptApart;
        }
        if let Some(champion) = self.champion() {
            *reference = reference.with_knowledge_of(champion, context);
        }
        self.make_champion();
        if let (Some(champion), Some(challenger)) = (&mut self.champion, &self.challenger) {
            champion.hypothesis = challenger.hypothesis;
            champion.hypothesis.reframe();
            champion.detector = ChangeDetector::NEW;
        }
        self.challenger = None;
        (self.rejected, self.is_confirmed) = (0, true);
        if had_champion { Fused::TookOver } else { Fused::Added }
    }

    /// Starts a champion from a prior. The estimate is suspect until a pair supports it. Returns whether the optimum of
    /// the prior is near its pose.
    pub(super) fn resume(&mut self, prior: &Prior<T>, context: &Context<'_, T>) -> bool {
        self.make_champion();
        (self.rejected, self.is_confirmed) = (1, false);
        let champion = self.champion.as_mut();
        champion.is_some_and(|champion| champion.hypothesis.resume(prior, context))
    }
}

#[cfg(test)]
mod tests;
