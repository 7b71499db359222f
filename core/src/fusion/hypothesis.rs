//! A hypothesis about the extrinsics: moments of the supporting pairs, and their optimum (`ESTIMATOR.md`, section 12).
//!
//! An update is first computed and then applied, so a refused pair leaves the hypothesis unchanged.

mod conditional;
mod covariance;
mod gate;
mod mode;
mod prior;

use nalgebra::Vector5;

use super::image_halves::ImageHalves;
use super::optimum::Optimum;
use crate::algebra::framed_moments::FramedMoments;
use crate::algebra::information::Information;
use crate::algebra::moments::Moments;
use crate::algebra::normal_equations::NormalEquations;
use crate::config::Context;
use crate::depth::pose::RowsPose;
use crate::depth::yaw::RowsYaw;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::pair::evaluate::PairMeasurement;
use crate::pair::leverage::form_peak;
use crate::pair::solver::TrackStart;
use crate::scalar::Scalar;
use crate::thresholds::{
    AVERAGED_PAIRS, CHI_SQUARE_PAIRS, CROWD_SHARE, FREEDOM_RAD, IMPROVEMENT, MAX_LOCKED_SD_RAD,
    MAX_REDUCED_CHI_SQUARE, WINDOW_DECAY, WINDOW_PAIRS,
};
use mode::Mode;

/// Sums over the supporting pairs, and their optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hypothesis<T: Scalar> {
    /// Optimum of all sums and the prior.
    pose: RectifyingRotations<T>,
    /// Pose whose rectified frame is the frame of the sums: the pose at which the first pair was evaluated, or the
    /// estimate at the last change of frame.
    frame: RectifyingRotations<T>,
    /// Moments of all pairs.
    sums: Moments<T>,
    /// Normal equations of the last pair about the pose; zero in a restored hypothesis before its first pair.
    last: NormalEquations<T>,
    halves: ImageHalves<T>,
    /// Mode in which pairs are added.
    mode: Mode<T>,
    /// Information of the pairs in the sums, without the prior, 1/rad^2: at the pose for a rigid rig, on the mean pose
    /// for a vibrating rig.
    information: Information<T>,
    /// Running mean of the noise of a coordinate, px.
    noise: T,
    /// Running mean of the inlier share.
    inlier_share: T,
    /// Running mean of [`PairMeasurement::crowd`].
    crowd: T,
    /// Exponentially fading sums of [`PairMeasurement::high_leverage`].
    high_leverage: [T; 2],
    /// Running mean of the chi-square between successive pairs per degree of freedom.
    reduced_chi_square: T,
    /// Decaying sum of the steps at detected changes, rad. It widens the covariance in case a drift continues.
    drift: Vector5<T>,
    /// Number of pairs in the sums.
    pairs: u32,
    /// Number of scenes in the sums: each pair counts by the share of it that is new.
    scenes: T,
}

/// Moments of one more pair, and the optimum and the mode that include it.
#[derive(Debug)]
pub(super) struct Update<T: Scalar> {
    /// Moments of the pair, in the frame of the sums.
    pub(super) pair: Moments<T>,
    /// Optimum of the sums with the pair.
    optimum: Optimum<T>,
    /// Mode including the pair; its sums are about the pose before the pair.
    mode: Mode<T>,
}

impl<T: Scalar> Update<T> {
    pub(super) const NONE: Self =
        Self { pair: Moments::ZERO, optimum: Optimum::NONE, mode: Mode::Rigid };
}

impl<T: Scalar> Hypothesis<T> {
    /// A hypothesis without pairs, all zeros. [`Hypothesis::begin`] or a prior sets the fields that must not be 0.
    pub(super) const EMPTY: Self = Self {
        pose: RectifyingRotations::UNSET,
        frame: RectifyingRotations::UNSET,
        sums: Moments::ZERO,
        last: NormalEquations::ZERO,
        halves: ImageHalves::NONE,
        mode: Mode::Rigid,
        information: Information::ZERO,
        noise: T::ZERO,
        inlier_share: T::ZERO,
        crowd: T::ZERO,
        high_leverage: [T::ZERO; 2],
        reduced_chi_square: T::ZERO,
        drift: Vector5::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO),
        pairs: 0,
        scenes: T::ZERO,
    };

    /// Computes the update of an empty hypothesis from a first pair.
    ///
    /// # Errors
    /// [`Rejection::NoRig`], [`Rejection::CorrectionLimit`].
    pub(super) fn first_update(
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
        update: &mut Update<T>,
    ) -> Result<(), Rejection> {
        update.pair = measurement.moments;
        update.optimum.pose = measurement.pose;
        update.optimum.descend(update.pair.in_frame_of(&measurement.pose), context)
    }

    /// Begins an empty hypothesis with a first pair.
    pub(super) fn begin(
        &mut self,
        measurement: &PairMeasurement<T>,
        update: &Update<T>,
        context: &Context<'_, T>,
    ) {
        let Update { pair, optimum, .. } = update;
        (self.pose, self.information) = (optimum.pose, optimum.information);
        self.frame = measurement.pose;
        self.sums = *pair;
        self.last = measurement.debiased_at(&self.pose, context.share);
        (self.noise, self.inlier_share) = (measurement.noise, measurement.inlier_share);
        self.crowd = measurement.crowd;
        self.high_leverage = measurement.high_leverage;
        self.reduced_chi_square = T::ONE;
        (self.pairs, self.scenes) = (1, T::ONE);
        let to_pose = self.frame.unknowns_to(&self.pose);
        self.halves.add(measurement, &to_pose, context);
    }

    /// Computes the update from one more pair.
    ///
    /// # Errors
    /// [`Rejection::NoRig`], [`Rejection::CorrectionLimit`].
    pub(super) fn next_update(
        &self,
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
        update: &mut Update<T>,
    ) -> Result<(), Rejection> {
        update.pair = measurement.moments;
        update.pair.scale(context.share);
        update.pair.change_frame(&measurement.pose, &self.frame);
        if !self.vibration(context).is_zero() {
            self.next_marginal(measurement, context, update).ok_or(Rejection::NoRig)?;
            return context.check(&update.optimum.pose);
        }
        let Update { pair, optimum, mode } = update;
        *mode = Mode::Rigid;
        let mut sums = self.sums;
        sums.scale(context.fading(self.pairs));
        sums.add(pair);
        optimum.pose = self.pose;
        optimum.descend(sums.in_frame_of(&self.frame), context)
    }

    /// Applies an update.
    ///
    /// * `update`: its moments are transformed if the frame of the sums changes.
    #[inline(never)]
    pub(super) fn apply(
        &mut self,
        measurement: &PairMeasurement<T>,
        update: &mut Update<T>,
        context: &Context<'_, T>,
    ) {
        let Update { pair, optimum, mode } = update;
        if mode.is_turning() != self.mode.is_turning() {
            self.begin_or_end_settling_at_rest(pair);
        }
        self.update_chi_square(measurement, context);
        self.sums.scale(context.fading(self.pairs));
        self.pairs = self.pairs.saturating_add(1);
        self.scenes += context.share;
        self.drift *= T::lit(WINDOW_DECAY);
        for (sum, new) in self.high_leverage.iter_mut().zip(measurement.high_leverage) {
            *sum = *sum * T::lit(WINDOW_DECAY) + new;
        }
        let gain = T::ONE / T::count(self.pairs.min(AVERAGED_PAIRS));
        self.noise += (measurement.noise - self.noise) * gain;
        let gain = T::ONE / T::count(self.pairs.min(WINDOW_PAIRS));
        self.inlier_share += (measurement.inlier_share - self.inlier_share) * gain;
        self.crowd += (measurement.crowd - self.crowd) * gain;
        let moved = self.pose.unknowns_to(&optimum.pose);
        (self.pose, self.information) = (optimum.pose, optimum.information);
        self.last = measurement.debiased_at(&self.pose, context.share);
        self.settle(pair, mode);
        match mode {
            Mode::Rigid => self.add_to_halves(measurement, &moved, context),
            Mode::Vibrating(_) | Mode::Turning(_) => {
                self.apply_marginal(measurement, mode, &moved, context);
            }
        }
    }

    /// Adds a pair of a rigid rig to the image halves.
    ///
    /// * `moved`: step of the pose, rad.
    fn add_to_halves(
        &mut self,
        measurement: &PairMeasurement<T>,
        moved: &Vector5<T>,
        context: &Context<'_, T>,
    ) {
        match self.deviations(context) {
            Some(sd) => self.halves.follow(moved, &sd, context),
            None => self.halves = ImageHalves::NONE,
        }
        let to_pose = measurement.pose.unknowns_to(&self.pose);
        self.halves.add(measurement, &to_pose, context);
    }

    /// Changes the frame of the sums to the pose, because sums lose digits in `f32` if the pose is far from their
    /// frame.
    pub(super) fn reframe(&mut self) {
        match self.mode {
            Mode::Rigid | Mode::Vibrating(_) => self.sums.change_frame(&self.frame, &self.pose),
            // [`Self::settle`] adds each pair in the rectified frame of its own displaced pose. That frame does not
            // depend on `self.frame`, so the sums need no transformation.
            Mode::Turning(_) => {}
        }
        self.frame = self.pose;
    }

    /// Replaces the sums, and moves the estimate to their optimum. Adds this step to the drift, and drops the image
    /// halves; the rig counts as rigid. Returns false, and changes nothing, if the new sums have no admissible optimum.
    pub(super) fn replace(
        &mut self,
        sums: &Moments<T>,
        pairs: u32,
        scenes: T,
        context: &Context<'_, T>,
    ) -> bool {
        let mut optimum = Optimum { pose: self.pose, ..Optimum::NONE };
        if optimum.descend(sums.in_frame_of(&self.frame), context).is_err() {
            return false;
        }
        let moved = self.pose.unknowns_to(&optimum.pose);
        self.drift = limited(&(self.drift + moved));
        self.last = self.last.about(&moved);
        (self.pose, self.information) = (optimum.pose, optimum.information);
        self.sums = *sums;
        (self.pairs, self.scenes) = (pairs, scenes);
        self.halves = ImageHalves::NONE;
        self.mode = Mode::Rigid;
        self.reframe();
        true
    }

    /// Returns the information of the pairs in the sums, without the prior, 1/rad^2.
    pub(super) fn information(&self) -> &Information<T> {
        &self.information
    }

    /// Returns the estimate.
    pub(crate) fn pose(&self) -> &RectifyingRotations<T> {
        &self.pose
    }

    /// Returns the estimate as the pose that it is: one that makes rows equal.
    pub(super) fn rows_pose(&self) -> RowsPose<T> {
        self.pose.into()
    }

    /// Returns the rotation about y from the factory extrinsics to the estimate, as the rows show it, rad.
    pub(super) fn yaw(&self, context: &Context<'_, T>) -> T {
        context.factory_pose.unknowns_to(&self.pose).y
    }

    /// Returns the rotation of [`Self::yaw`], and its variance if the given lens is exact, rad^2.
    #[inline(never)]
    pub(super) fn rows_yaw(&self, context: &Context<'_, T>) -> Option<RowsYaw<T>> {
        let [_, variance, ..] = self.reported_covariance(context)?.diagonal();
        Some(RowsYaw { turn: self.yaw(context), variance })
    }

    /// Returns the normal equations at the pose, from sums in the frame of the hypothesis. They include the noise of
    /// disparities.
    pub(super) fn normal_equations(&self, sums: &Moments<T>) -> NormalEquations<T> {
        sums.in_frame_of(&self.frame).at(&self.pose)
    }

    /// Returns the sums with their frame.
    fn framed_sums(&self) -> FramedMoments<'_, T> {
        self.sums.in_frame_of(&self.frame)
    }

    /// Returns the number of pairs in the sums.
    pub(crate) fn pairs(&self) -> u32 {
        self.pairs
    }

    /// Returns the number of scenes in the sums: pairs of a scene that has hardly moved count as a part of one.
    pub(super) fn scenes(&self) -> T {
        self.scenes
    }

    /// Returns the reduced chi-square of the pairs, at least 1.
    pub(super) fn reduced_chi_square(&self) -> T {
        self.reduced_chi_square.max(T::ONE)
    }

    /// Returns the noise of a coordinate, px.
    pub(super) fn noise(&self) -> T {
        self.noise
    }

    /// Replaces the noise by that of another hypothesis.
    pub(super) fn take_noise_of(&mut self, other: &Self) {
        self.noise = other.noise;
    }

    /// Returns the share of matches whose residuals lie on one side beyond the peak ([`PairMeasurement::crowd`]), over
    /// the share of the inliers.
    pub(super) fn second_crowd(&self) -> T {
        self.crowd.abs() / self.inlier_share.max(T::EPSILON)
    }

    /// Returns the disagreement of the image halves, as the root of the chi-square per degree of freedom.
    pub(crate) fn disagreement(&self) -> T {
        self.halves.disagreement()
    }

    /// Returns whether the RMS row offset of the estimate over the sums is below [`IMPROVEMENT`] times that of other
    /// extrinsics.
    pub(super) fn fits_clearly_better_than(&self, other: &RectifyingRotations<T>) -> bool {
        self.fits_clearly_better_at(&self.pose, other)
    }

    /// Returns whether the RMS row offset over the sums at one pose is below [`IMPROVEMENT`] times that at another
    /// pose. False if a pose has no corresponding pose at rest ([`Self::pose_at_rest`]).
    fn fits_clearly_better_at(
        &self,
        one: &RectifyingRotations<T>,
        other: &RectifyingRotations<T>,
    ) -> bool {
        let at_rest = self.poses_at_rest([one, other]);
        let costs = at_rest.map(|poses| poses.map(|pose| self.framed_sums().cost_at(&pose)));
        costs.is_some_and(|[one, other]| one < other * T::lit(IMPROVEMENT * IMPROVEMENT))
    }

    /// Returns the start of a track: the estimate, and the covariance of a pair about it. This covariance is the sum of
    /// the covariance of the estimate, the variances of the vibration, and [`FREEDOM_RAD`] squared for each unknown.
    /// `None` if the estimate has no covariance.
    pub(super) fn track_start(&self, context: &Context<'_, T>) -> Option<TrackStart<T>> {
        let sees_crowd = self.crowd.abs() >= T::lit(CROWD_SHARE);
        let mut covariance = self.covariance(context)?;
        covariance.add_diagonal(T::lit(FREEDOM_RAD * FREEDOM_RAD));
        context.vibration.add_to(&mut covariance);
        let trusts_leverage = form_peak(self.high_leverage);
        let Self { pose, noise, .. } = *self;
        Some(TrackStart { pose, covariance, noise, trusts_leverage, sees_crowd })
    }

    /// Updates the reduced chi-square by the distance between a pair and the previous pair. The distance does not
    /// depend on the estimate, which may be wrong.
    #[inline(never)]
    fn update_chi_square(&mut self, measurement: &PairMeasurement<T>, context: &Context<'_, T>) {
        // A restored hypothesis has no last pair.
        if self.last == NormalEquations::ZERO {
            return;
        }
        let pair = measurement.debiased_at(&self.pose, context.share).with_prior(context.prior);
        let last = self.last.with_prior(context.prior);
        let apart = self.vibration(context).scaled(T::lit(2.0)).diagonal();
        if let Some(distance) = pair.distance_apart(&last, &apart) {
            let reduced = (distance / T::lit(5.0)).min(T::lit(MAX_REDUCED_CHI_SQUARE));
            let pairs = T::count(self.pairs.min(AVERAGED_PAIRS)) + T::lit(CHI_SQUARE_PAIRS);
            self.reduced_chi_square += (reduced - self.reduced_chi_square) * (T::ONE / pairs);
        }
    }
}

/// Scales a drift down so that no element exceeds [`MAX_LOCKED_SD_RAD`]. With a wider covariance, tracks lose pairs
/// among outliers.
// A drift that exceeds the limit only by rounding is kept, so that a limited drift does not change if it is limited
// again.
fn limited<T: Scalar>(drift: &Vector5<T>) -> Vector5<T> {
    let over = drift.amax() / T::lit(MAX_LOCKED_SD_RAD);
    if over > T::lit(1.0 + 1e-5) { drift.unscale(over) } else { *drift }
}

#[cfg(test)]
pub(super) mod tests;
