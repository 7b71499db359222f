//! Mode of a hypothesis: a rigid rig, a vibrating rig, or a vibrating rig whose cameras turn (`ESTIMATOR.md`, section
//! 14).

use core::mem::{self, Discriminant};

use nalgebra::Vector5;

use super::{Hypothesis, Update};
use crate::algebra::block_variances::BlockVariances;
use crate::algebra::moments::Moments;
use crate::config::Context;
use crate::fusion::image_halves::ImageHalves;
use crate::fusion::marginal_sums::MarginalSums;
use crate::geometry::rectification::RectifyingRotations;
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::MAX_INCONSISTENCY;

/// Mode in which the pairs of a hypothesis are added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::fusion) enum Mode<T> {
    /// The rig is rigid.
    Rigid,
    /// The extrinsics vibrate. Each pair is weighted by its information on the mean rig.
    Vibrating(MarginalSums<T>),
    /// As [`Mode::Vibrating`], and rotations of the cameras explain the vibration. The moments of each pair are added as
    /// if the rig rested at the frame of the sums ([`Hypothesis::settle`]).
    Turning(MarginalSums<T>),
}

impl<T: Scalar> Mode<T> {
    /// Returns the mode of a vibrating rig.
    pub(super) fn of(marginal: MarginalSums<T>) -> Self {
        if marginal.variances.of_turns() > T::ZERO {
            Self::Turning(marginal)
        } else {
            Self::Vibrating(marginal)
        }
    }

    /// Returns the sums of a vibrating rig; `None` for a rigid rig.
    pub(super) fn marginal(&self) -> Option<&MarginalSums<T>> {
        match self {
            Self::Rigid => None,
            Self::Vibrating(marginal) | Self::Turning(marginal) => Some(marginal),
        }
    }

    /// Returns whether the moments of each pair are added as if the rig rested.
    pub(super) fn is_turning(&self) -> bool {
        matches!(self, Self::Turning(_))
    }
}

impl<T: Scalar> Hypothesis<T> {
    /// Returns whether the pairs are weighted as for a rigid rig.
    pub(in crate::fusion) fn is_rigid(&self) -> bool {
        matches!(self.mode, Mode::Rigid)
    }

    /// Returns the mode, to tell whether an update has changed it.
    pub(in crate::fusion) fn mode(&self) -> Discriminant<Mode<T>> {
        mem::discriminant(&self.mode)
    }

    /// Returns the variances of the vibration that the hypothesis assumes, rad^2; zero for a rigid rig. Once the pairs
    /// are weighted for a vibration, the variances do not return to zero until the sums are replaced, because sums with
    /// and without vibration cannot be mixed.
    pub(in crate::fusion) fn vibration(&self, context: &Context<'_, T>) -> BlockVariances<T> {
        if self.is_rigid() && context.vibration.is_zero() {
            BlockVariances::ZERO
        } else {
            context.vibration.at_least_rigid()
        }
    }

    /// Starts or ends the mode in which each pair is added as if the rig rested at the frame of the sums. Before the
    /// switch the frame moves to the estimate, so that both kinds of sums have their optimum at the same pose.
    ///
    /// * `next`: moments of the next pair in the frame of the sums, which are transformed too.
    pub(super) fn begin_or_end_settling_at_rest(&mut self, next: &mut Moments<T>) {
        next.change_frame(&self.frame, &self.pose);
        self.reframe();
    }

    /// Adds the moments of a pair in the frame of the sums. If the cameras rotate from pair to pair, the pair is added
    /// as if the rig rested at the frame of the sums. For this, its moments are transformed to the rectified frame of
    /// its own displaced extrinsics. In that frame the rotations do not affect the residuals.
    ///
    /// * `mode`: mode after the pair.
    #[inline(never)]
    pub(super) fn settle(&mut self, pair: &Moments<T>, mode: &Mode<T>) {
        let own = match mode {
            Mode::Rigid | Mode::Vibrating(_) => None,
            Mode::Turning(MarginalSums { variances, .. }) => {
                let turns = BlockVariances { rotation: variances.of_turns(), baseline: T::ZERO };
                self.displaced_optimum(pair, &turns)
            }
        };
        let mut at_rest = *pair;
        if let Some(own) = own {
            at_rest.change_frame(&self.frame, &own);
        }
        self.sums.add(&at_rest);
    }

    /// Maps a pose to the corresponding pose of the rig at rest that the sums describe; `None` if no such pose exists.
    pub(super) fn pose_at_rest(
        &self,
        pose: &RectifyingRotations<T>,
    ) -> Option<RectifyingRotations<T>> {
        self.poses_at_rest([pose]).map(|[pose]| pose)
    }

    /// Maps poses as [`Self::pose_at_rest`] does.
    pub(super) fn poses_at_rest<const N: usize>(
        &self,
        poses: [&RectifyingRotations<T>; N],
    ) -> Option<[RectifyingRotations<T>; N]> {
        let mut mapped = poses.map(|pose| *pose);
        if let Mode::Turning(MarginalSums { variances, .. }) = &self.mode {
            let displaced = self.displaced_optimum(&self.sums, variances)?;
            for pose in &mut mapped {
                *pose = displaced.stepped_by(&self.pose.unknowns_to(pose))?;
            }
        }
        Some(mapped)
    }

    /// Returns the most probable pose of the rig that the sums describe, if a random effect displaces this rig from the
    /// estimate: the optimum of the sums with a prior about the estimate. `None` if there is no such pose.
    ///
    /// * `variances`: variances of the random effect, and so of the prior, rad^2.
    fn displaced_optimum(
        &self,
        sums: &Moments<T>,
        variances: &BlockVariances<T>,
    ) -> Option<RectifyingRotations<T>> {
        let normal = sums.in_frame_of(&self.frame).debiased_at(&self.pose);
        let factor = variances.with_precision(&normal.information).factor(T::ZERO)?;
        self.pose.stepped_by(&-factor.solve(&normal.gradient))
    }

    /// Computes the update from one more pair with the marginal sums. `None` if there is no admissible step.
    #[inline(never)]
    pub(super) fn next_marginal(
        &self,
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
        update: &mut Update<T>,
    ) -> Option<()> {
        let now = self.vibration(context);
        let Update { mode, optimum, .. } = update;
        let mut marginal = match self.mode {
            Mode::Rigid => {
                let sum = self.framed_sums().debiased_at(&self.pose);
                MarginalSums::start(&sum, self.pairs, &now)?
            }
            Mode::Vibrating(mut marginal) | Mode::Turning(mut marginal) => {
                marginal.follow(self.pairs, &now)?;
                marginal
            }
        };
        let pair = measurement.debiased_at(&self.pose, context.share);
        marginal.add(&pair, &now, context.fading(self.pairs))?;
        *mode = Mode::of(marginal);
        optimum.information = marginal.sum.information;
        let mut joint = marginal.sum.with_prior(context.prior);
        joint.gradient -= self.pose.unknowns_to(&context.factory_pose) * context.prior;
        let step = joint.step()?;
        optimum.pose = self.pose.stepped_by(&step)?;
        // The marginal sums are shifted linearly. If the pose departs far from the linear step, their optimum would be
        // wrong.
        let off = step - self.pose.unknowns_to(&optimum.pose);
        let squared = off.dot(&optimum.information.times(&off));
        (squared <= T::HALF * T::lit(MAX_INCONSISTENCY)).then_some(())
    }

    /// Applies the parts of an update that only a vibrating rig needs.
    ///
    /// * `mode`: mode after the pair; `moved`: step of the pose, rad.
    pub(super) fn apply_marginal(
        &mut self,
        measurement: &PairMeasurement<T>,
        mode: &Mode<T>,
        moved: &Vector5<T>,
        context: &Context<'_, T>,
    ) {
        if self.is_rigid() {
            // The earlier scatter was vibration, so the reduced chi-square restarts at 1. If only the baseline
            // vibrates, the scatter may be a bias of the matches. Then the reduced chi-square is kept, because it
            // covers a bias in all directions.
            if context.vibration.rotation > T::ZERO {
                self.reduced_chi_square = T::ONE;
            }
            // A disagreement of the halves before the vibration has another cause and is kept.
            if self.halves.agree() {
                self.halves = ImageHalves::NONE;
            }
        }
        self.mode = *mode;
        if let Mode::Vibrating(marginal) | Mode::Turning(marginal) = &mut self.mode {
            marginal.shift(moved);
        }
        self.halves.fade(context);
        let pair = measurement.moments.biased_at_frame().scaled(context.share);
        let alone = pair.debiased().with_prior(context.prior);
        if let Some(own) = alone.step() {
            self.halves.add(measurement, &own, context);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::evaluated_at;
    use super::*;
    use crate::config::Config;
    use crate::geometry::extrinsics::Extrinsics;
    use crate::geometry::rectification::tests::pose;

    #[test]
    fn a_step_too_long_for_the_sums_is_refused() {
        let config = Config::robust().with_prior_sd_rad(0.4).unwrap();
        let config = config.with_max_correction_rad(1.2).unwrap();
        let variances = BlockVariances { rotation: 1e-5, baseline: 1e-5 };
        let context = Context::new(&config, &Extrinsics::SIDE_BY_SIDE, 1400.0_f64);
        let context = context.vibrating(variances);
        let mut update = Update::NONE;
        for seed in 0..60_u32 {
            // `off` is half of the angle between the baselines, rad.
            let (sin, cos) = f64::from(seed).sin_cos();
            let off = 0.4 + 0.4 * f64::from(seed) / 60.0;
            let [one, other] = [off, -off].map(|off| {
                let rig = pose([0.02, -0.01, 0.03], [off * cos, off * sin]);
                evaluated_at(&rig, seed.into()).measurement
            });
            Hypothesis::first_update(&one, &context, &mut update).unwrap();
            let mut hypothesis = Hypothesis::EMPTY;
            hypothesis.begin(&one, &update, &context);
            let is_refused = hypothesis.next_update(&other, &context, &mut update).is_err();
            // Between these limits the result depends on the direction.
            if !(0.5..0.65).contains(&off) {
                assert_eq!(is_refused, off > 0.6, "{off}");
            }
        }
    }
}
