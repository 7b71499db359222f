//! Fusion of many pairs with two hypotheses, data association and change detection (`ESTIMATOR.md`, sections 12 to 17
//! and 21).
//!
//! The *champion* is the reported hypothesis. A pair outside the champion's gate starts a *challenger*, a second
//! hypothesis that collects the pairs that agree with it. The first pairs after a start form a challenger, too. If
//! three pairs agree on another rig, the challenger becomes the champion and keeps its sums. When pairs return to the
//! champion, the challenger is dropped. Without a challenger, a gate around a wrong estimate would refuse all good
//! pairs.
//!
//! - [`association`], [`association_result`]: the hypothesis that a pair supports. [`hypotheses`]: champion,
//!   challenger.
//! - [`hypothesis`], [`optimum`]: moments of the supporting pairs, and their optimum with the prior.
//! - [`change_detector`]: steps and drifts below the noise of a pair. [`key_frame`]: motion of the scene since the last
//!   pair that was added.
//! - [`reported`]: reported estimate. [`applied`]: its part that is applied.
//! - [`image_halves`]: biases of image regions. [`vibration`], [`marginal_sums`]: vibrating rigs.
//! - [`lens`], [`lens_reference`], [`lens_change`]: errors of the lens models, and their compensation.
//! - [`prior`]: estimate of a record. [`turn`]: turned baselines, which reveal mistakes in the rig file or the matcher.

mod applied;
mod association;
mod association_result;
mod change_detector;
mod hypotheses;
pub(crate) mod hypothesis;
mod image_halves;
mod key_frame;
mod lens;
mod lens_change;
pub(crate) mod lens_reference;
mod marginal_sums;
mod optimum;
pub(crate) mod prior;
mod reported;
mod turn;
pub(crate) mod vibration;

use crate::algebra::block_variances::BlockVariances;
use crate::batch::correspondence::RayPair;
use crate::config::{Context, LensTracking};
use crate::depth::mount::MountYaw;
use crate::depth::pose::RowsPose;
use crate::depth::yaw::RowsYaw;
use crate::error::Rejection;
use crate::outcome::pair_report::{Fused, PairReport};
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::state::State;
use association::{Association, AssociationContext};
use association_result::Support;
use hypotheses::Hypotheses;
use hypothesis::Hypothesis;
use key_frame::KeyFrame;
use lens_reference::LensReference;
use vibration::VibrationEstimator;

/// State of the estimator.
#[derive(Debug, Clone)]
pub(crate) struct Fusion<T: Scalar> {
    hypotheses: Hypotheses<T>,
    /// Scene of the last pair that was added.
    key_frame: KeyFrame,
    /// Lens correction of the rays, and knowledge of the lens from sums that were dropped.
    reference: LensReference<T>,
    vibration: VibrationEstimator<T>,
    /// Estimate of the mount yaw and of the apparent yaw of the lens from the factory calibration, from each pair and
    /// from witnesses.
    mount: MountYaw<T>,
    /// Association of the current batch.
    association: Association<T>,
}

impl<T: Scalar> Fusion<T> {
    /// Creates a state without pairs.
    ///
    /// * `is_calibrated`: whether a calibration measured the factory extrinsics.
    pub(crate) const fn new(is_calibrated: bool) -> Self {
        Self {
            hypotheses: Hypotheses::NONE,
            key_frame: KeyFrame::NONE,
            reference: LensReference::GIVEN,
            vibration: VibrationEstimator::RIGID,
            mount: MountYaw::new(is_calibrated),
            association: Association::IDLE,
        }
    }

    /// Forgets all pairs, the witness measurements, the vibration, and the lens correction. Works in place, because a
    /// new value would take stack.
    pub(crate) fn reset(&mut self) {
        self.vibration.clear();
        self.mount.reset();
        self.forget_pairs();
    }

    fn forget_pairs(&mut self) {
        self.hypotheses.clear();
        self.key_frame.clear();
        self.reference = LensReference::GIVEN;
        self.association.forget();
    }

    /// Returns the lens correction of the rays, and the knowledge of the lens.
    pub(crate) fn reference(&self) -> &LensReference<T> {
        &self.reference
    }

    /// Forgets all pairs and restarts with another lens correction, to which the next rays belong. Keeps the estimate
    /// of the mount yaw and the variances of the vibration.
    pub(crate) fn begin_again(&mut self, reference: &LensReference<T>, context: &Context<'_, T>) {
        self.forget_pairs();
        self.mount.change_lens(context);
        // The mount does not change, so the vibration estimate is kept. The optimum of the next pair is not compared
        // with earlier ones, because they belong to other rays.
        self.vibration.interrupt();
        self.reference = *reference;
    }

    /// Returns the lens reference with which to restart. `None` if no restart is due: the configuration does not
    /// compensate the lens ([`LensTracking::Compensate`]), the estimate is not locked or has too few pairs, or a
    /// restart gains nothing.
    pub(crate) fn next_reference(&self, context: &Context<'_, T>) -> Option<LensReference<T>> {
        let compensates = context.config.lens_tracking == LensTracking::Compensate;
        let hypothesis = self.hypotheses.champion()?;
        let is_due = compensates && context.has_lens_prior() && self.state() == State::Locked;
        if is_due { self.reference.next(hypothesis, context) } else { None }
    }

    /// Returns whether all lengths are within their capacities.
    pub(crate) fn is_within(&self) -> bool {
        self.key_frame.is_within()
    }

    /// Discards the current pair, whether solved or not. If it was solved, the count of pairs before the first champion
    /// restarts ([`Hypotheses::forget_begun`]).
    pub(crate) fn discard(&mut self) {
        if self.association.result().is_some() {
            self.hypotheses.forget_begun();
        }
        self.association.close();
    }

    /// Starts a batch and takes its first pass.
    ///
    /// # Errors
    /// [`Rejection::TooFew`]: too few correspondences, or too few in front of both cameras. The batch is abandoned.
    pub(crate) fn begin(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        self.discard();
        let needed = context.config.min_correspondences.into();
        let usable = u32::try_from(matches.len()).unwrap_or(u32::MAX);
        if usable < needed {
            return Err(Rejection::TooFew { usable, needed });
        }
        let Self { hypotheses, key_frame, association, .. } = self;
        let turn = hypotheses.next_turn();
        let with = AssociationContext { context, hypotheses };
        let moved = key_frame.compare(matches, context.focal);
        association.open(&with, matches, moved, turn);
        let begun = association.advance(&with, matches);
        if begun.is_err() {
            association.close();
        }
        begun
    }

    /// Takes one more pass. Returns true once the pair is solved. Unless `frozen`, a failed pair counts against the
    /// hypotheses that rejected it, and a turned baseline that fits clearly better than the challenger drops the
    /// challenger.
    ///
    /// # Errors
    /// [`Rejection`]; the batch is abandoned. [`Rejection::NotBegun`]: there is no batch.
    pub(crate) fn advance(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
        frozen: bool,
    ) -> Result<bool, Rejection> {
        let Self { hypotheses, association, .. } = self;
        if !association.is_open() {
            return Err(Rejection::NotBegun);
        }
        let with = AssociationContext { context, hypotheses };
        if let Err(error) = association.advance(&with, matches) {
            if !frozen {
                hypotheses.count(association.rejected());
                if association.is_turned() {
                    hypotheses.drop_challenger();
                }
            }
            association.close();
            return Err(error);
        }
        Ok(!association.is_open())
    }

    /// Checks that the solved pair alone has a valid optimum, and so a report.
    ///
    /// # Errors
    /// [`Rejection::NotBegun`]: there is no solved pair. [`Rejection::Unobservable`]: the pair alone has no valid
    /// optimum; the pair is abandoned.
    #[inline(never)]
    pub(crate) fn check(&mut self, context: &Context<'_, T>) -> Result<(), Rejection> {
        let result = self.association.result().ok_or(Rejection::NotBegun)?;
        if result.optimum(context).is_some() {
            return Ok(());
        }
        self.association.close();
        Err(Rejection::Unobservable)
    }

    /// Returns the report of the solved pair; `None` without one, or without a valid optimum.
    pub(crate) fn report(&self, context: &Context<'_, T>) -> Option<PairReport<T>> {
        self.association.result()?.report(context)
    }

    /// Fuses the solved pair, whose batch is `matches`. Its report stays until [`Self::close`].
    ///
    /// # Errors
    /// [`Rejection`]; the sums of the champion are unchanged, and the pair counts against the hypotheses that rejected
    /// it. [`Rejection::NotBegun`]: there is no solved pair.
    #[inline(never)]
    pub(crate) fn fuse(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<Fused, Rejection> {
        let Self { hypotheses, association, reference, vibration, .. } = self;
        let result = association.result().ok_or(Rejection::NotBegun)?;
        let context = &context.counting(result.counting());
        let fused = hypotheses.fuse(&result, reference, context);
        let is_heard = result.support != Support::None || result.evaluated.has_clear_peak();
        // Pairs that start or support a challenger beside a champion ([`Fused::KeptApart`]) do not update the vibration
        // estimate, because the wrong poses of weak pairs would look like a vibration that hides knocks. A pair that is
        // not fused updates it only if it has a clear peak and disagrees with the hypotheses, because the rig may
        // vibrate.
        let is_admissible = match fused {
            Ok(fused) => fused != Fused::KeptApart,
            Err(error) => error == Rejection::Disagrees,
        };
        if is_heard && is_admissible && !result.moved.is_repeated() {
            let measurement = &result.evaluated.measurement;
            match fused {
                Ok(_) => vibration.add(measurement, context),
                Err(_) => add_refused(vibration, measurement, context),
            }
        }
        let is_added = !result.moved.is_repeated() || result.support == Support::New;
        if fused.is_ok() && is_added {
            self.key_frame.remember(matches, context.focal);
        }
        // Knowledge ages as the sums fade, so a standing vehicle forgets nothing.
        if fused.is_ok_and(|fused| !matches!(fused, Fused::Repeated | Fused::KeptApart)) {
            let yaw = result.yaw(context);
            self.update_yaw(yaw, fused == Ok(Fused::TookOver), context);
        }
        fused
    }

    /// Ages the knowledge of the lens, and adds a yaw to that of the mount. Forgets the lens if the sums contradict what
    /// is known of it. They are compared at a takeover, and whenever their number of pairs has doubled.
    ///
    /// * `pair`: yaw of the pair alone.
    #[inline(never)]
    fn update_yaw(&mut self, pair: Option<RowsYaw<T>>, took_over: bool, context: &Context<'_, T>) {
        let Self { hypotheses, reference, mount, .. } = self;
        reference.fade(context.fading(u32::MAX));
        let Some(champion) = hypotheses.champion() else { return };
        let is_due = took_over || champion.pairs().is_power_of_two();
        if is_due && reference.is_contradicted_by(champion, context) {
            reference.forget_known();
            mount.change_lens(context);
        }
        let Some(begins) = mount.begins(context) else { return };
        let yaw = if begins { champion.rows_yaw(context) } else { pair };
        if let Some(yaw) = yaw.filter(|_| !reference.awaits_correction(champion.pairs(), context)) {
            mount.add(&yaw, context);
        }
    }

    /// Ends the solved pair.
    pub(crate) fn close(&mut self) {
        self.association.close();
    }

    /// Returns the pose of the reported estimate, and its yaw with the variance. `None` without an estimate or without a
    /// valid covariance.
    pub(crate) fn rows(&self, context: &Context<'_, T>) -> Option<(RowsPose<T>, RowsYaw<T>)> {
        let hypothesis = self.hypotheses.reported()?;
        Some((hypothesis.rows_pose(), hypothesis.rows_yaw(context)?))
    }

    /// Returns the knowledge of the mount yaw, for updates by other measurements.
    pub(crate) fn mount_mut(&mut self) -> &mut MountYaw<T> {
        &mut self.mount
    }

    pub(crate) fn state(&self) -> State {
        self.hypotheses.state()
    }

    /// Returns whether pairs have supported the estimate, also since it was restored.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.hypotheses.is_confirmed()
    }

    /// Returns whether the estimate rejects the present pair.
    pub(crate) fn is_rejected(&self) -> bool {
        self.association.rejected().by_champion
    }

    /// Returns the variances of the vibration of single pairs about the estimate, rad^2.
    pub(crate) fn vibration(&self) -> BlockVariances<T> {
        self.vibration.variances()
    }

    /// Returns whether there is an estimate.
    pub(crate) fn has_pairs(&self) -> bool {
        self.hypotheses.reported().is_some()
    }

    /// Returns whether the last batch with enough correspondences repeated the scene of the last pair that was added.
    pub(crate) fn is_repeated(&self) -> bool {
        self.association.is_repeated()
    }

    /// Returns the noise of a coordinate, px; 0 before the first pair.
    pub(crate) fn noise(&self) -> T {
        self.hypotheses.reported().map_or(T::ZERO, Hypothesis::noise)
    }
}

/// Adds a refused pair, unless it reduces a variance. A refused pair may only show more vibration, not less.
// Out of line, to keep the copy off the caller's stack.
#[inline(never)]
fn add_refused<T: Scalar>(
    vibration: &mut VibrationEstimator<T>,
    measurement: &PairMeasurement<T>,
    context: &Context<'_, T>,
) {
    let mut with = vibration.clone();
    with.add(measurement, context);
    let variances = with.variances();
    if variances == variances.at_least(&vibration.variances()) {
        *vibration = with;
    }
}

#[cfg(test)]
mod tests {
    use super::hypothesis::tests::{context, evaluated_at, truth};
    use super::*;
    use nalgebra::Vector5;

    type Add = fn(&mut VibrationEstimator<f64>, &PairMeasurement<f64>, &Context<'_, f64>);

    /// Returns the estimator after 20 pairs of a rig whose cameras rotate from pair to pair.
    fn shaken(add: Add) -> VibrationEstimator<f64> {
        let mut estimator = VibrationEstimator::RIGID;
        for seed in 0..20_u8 {
            let turn = 5e-3 * f64::from(2 * seed % 5) - 1e-2;
            let pose = truth().stepped_by(&Vector5::new(turn, -turn, turn, 0.0, 0.0)).unwrap();
            add(&mut estimator, &evaluated_at(&pose, seed.into()).measurement, &context());
        }
        estimator
    }

    #[test]
    fn a_refused_pair_never_reduces_the_vibration() {
        assert!(shaken(add_refused).variances().rotation > 0.0);
        // Returns the number of pairs of a rig at rest after which a variance has fallen.
        let falls = |add: Add| {
            let mut estimator = shaken(VibrationEstimator::add);
            let falls = (20..50).filter(|seed| {
                let before = estimator.variances();
                add(&mut estimator, &evaluated_at(&truth(), *seed).measurement, &context());
                estimator.variances() != estimator.variances().at_least(&before)
            });
            falls.count()
        };
        assert_eq!(falls(add_refused), 0);
        assert!(falls(VibrationEstimator::add) > 0);
    }
}
