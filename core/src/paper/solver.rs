//! One pair: Levenberg-Marquardt on the rectifying rotations (eqs 16 to 19), one pass at a time.
//!
//! A pass reads each correspondence once, and computes residuals, derivatives, normal equations and cost of one trial
//! pose. A rejected trial also costs a pass, so the number of passes bounds the time. Optimum and steps follow eq 17,
//! with the damping scaled by the diagonal (Marquardt).

use nalgebra::Vector5;

use super::Settings;
use super::disparity_noise::less_disparity_noise;
use super::evaluation::Evaluation;
use super::loss::Huber;
use super::residual::linearised;
use crate::algebra::information::Information;
use crate::algebra::normal_equations::add_pull;
use crate::batch::correspondence::RayPair;
use crate::batch::sides::is_behind;
use crate::error::Rejection;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::pair_report::PairReport;
use crate::scalar::Scalar;
use crate::state::Stop;
use crate::thresholds::MIN_DISPARITY_PX;
use crate::thresholds::paper::{
    COST_ULPS, DAMPING_FACTOR, DAMPING_GROWTH, FIRST_DAMPING, LOOSE_DAMPING, MAX_DAMPING,
    MIN_DAMPING, TOLERANCE_ULPS,
};

/// Number of correspondences in a partial sum. Partial sums preserve the last digits, which the comparison of the costs
/// of two poses needs.
const BLOCK: usize = 16;

/// Sums of one pass over the batch at one pose.
#[derive(Debug, Clone)]
struct Pass<T> {
    information: Information<T>,
    gradient: Vector5<T>,
    /// Sum of the losses.
    cost: T,
    /// Sum of the squared weighted residuals.
    squares: T,
    /// Numbers of correspondences in front of both cameras, and behind a camera.
    usable: u32,
    skipped: u32,
}

/// State of the solver of one pair between two passes. Row offsets are at unit depth, dimensionless.
#[derive(Debug, Clone)]
pub struct HuberSolver<T: Scalar> {
    /// Mean focal length, px.
    focal: T,
    loss: Huber<T>,
    /// Largest component of a step, rad, up to which the solver ends: it has converged after an accepted step with low
    /// damping, and finds no descent after a rejected step.
    tolerance: T,
    /// Smallest standard deviation of a row offset.
    noise_floor: T,
    max_passes: u16,
    min_usable: u32,
    start: RectifyingRotations<T>,
    cost_before: T,
    pose: RectifyingRotations<T>,
    /// Sums at the pose.
    at_pose: Pass<T>,
    /// `lambda`, relative to the diagonal.
    damping: T,
    /// Factor of the damping at the next rejected step.
    growth: T,
    passes: u16,
    stop: Option<Stop>,
}

impl<T: Scalar> HuberSolver<T> {
    /// Begins a pair, and takes the first pass at the start pose.
    ///
    /// * `focal`: mean focal length of the cameras, px.
    ///
    /// # Errors
    /// [`Rejection::TooFew`], [`Rejection::Unobservable`].
    pub fn begin(
        settings: &Settings,
        focal: T,
        start: &Extrinsics<T>,
        pairs: &[RayPair<T>],
    ) -> Result<Self, Rejection> {
        let pose = RectifyingRotations::from(start);
        let loss = Huber { threshold: T::single(settings.huber_threshold_px) / focal };
        let at_pose = Pass::over(pairs, &pose, loss);
        let needed = settings.min_correspondences.into();
        if at_pose.usable < needed {
            return Err(Rejection::TooFew { usable: at_pose.usable, needed });
        }
        if !at_pose.information.is_observable() {
            return Err(Rejection::Unobservable);
        }
        Ok(Self {
            focal,
            loss,
            tolerance: T::single(settings.step_tolerance_rad)
                .max(T::lit(TOLERANCE_ULPS) * T::EPSILON),
            noise_floor: T::single(settings.noise_floor_px) / focal,
            max_passes: settings.max_passes,
            min_usable: needed,
            start: pose,
            cost_before: at_pose.cost,
            pose,
            at_pose,
            damping: T::lit(FIRST_DAMPING),
            growth: T::lit(DAMPING_GROWTH),
            passes: 1,
            stop: None,
        })
    }

    /// Takes one more pass: one trial step, which is kept only if the cost falls. Returns the reason once the solver
    /// has stopped; further calls do nothing else.
    pub fn advance(&mut self, pairs: &[RayPair<T>]) -> Option<Stop> {
        if self.stop.is_none() {
            self.stop = self.attempt(pairs);
        }
        if self.stop.is_none() && self.passes >= self.max_passes {
            self.stop = Some(Stop::PassesSpent);
        }
        self.stop
    }

    /// Returns whether only [`HuberSolver::report`] is left.
    pub fn is_done(&self) -> bool {
        self.stop.is_some()
    }

    /// Takes one trial step; returns the reason of the stop if this is the last step.
    fn attempt(&mut self, pairs: &[RayPair<T>]) -> Option<Stop> {
        self.passes = self.passes.saturating_add(1);
        let trial = self.at_pose.step(self.damping).and_then(|d| {
            let pose = self.pose.stepped_by(&d)?;
            Some((d, pose, Pass::over(pairs, &pose, self.loss)))
        });
        let Some((d, pose, at_trial)) = trial else {
            return self.reject();
        };
        let (slope_here, slope_there) = (self.at_pose.gradient.dot(&d), at_trial.gradient.dot(&d));
        let penalty = self.loss.cost(T::ONE);
        let change = at_trial.penalised(penalty) - self.at_pose.penalised(penalty);
        let rounding = self.at_pose.cost_rounding();
        // Below the rounding of the cost, the slopes at both ends give the change of the cost more exactly (approximate
        // Wolfe condition of Hager and Zhang).
        let falls = change < -rounding
            || (change <= rounding
                && at_trial.usable == self.at_pose.usable
                && slope_here + slope_there < T::ZERO);
        if !falls {
            let small = d.amax() <= self.tolerance;
            return self.reject().or(small.then_some(Stop::NoDescent));
        }
        // The slope along the step is about twice the predicted change of the cost. It is compared with the squared
        // residuals, so the limit does not depend on noise and scene.
        let negligible = -slope_here <= T::EPSILON * at_trial.squares;
        let undamped = self.damping <= T::lit(LOOSE_DAMPING);
        self.accept(pose, at_trial, change / (slope_here * T::HALF));
        let converged = undamped && (negligible || d.amax() <= self.tolerance);
        converged.then_some(Stop::Converged)
    }

    /// Keeps a trial. The damping follows Nielsen's rule: it becomes smaller with a larger gain.
    ///
    /// * `gain`: change of the cost over the change that the model predicts.
    fn accept(&mut self, pose: RectifyingRotations<T>, at_pose: Pass<T>, gain: T) {
        self.pose = pose;
        self.at_pose = at_pose;
        let x = gain + gain - T::ONE;
        let [least, most] = DAMPING_FACTOR.map(T::lit);
        let factor = (T::ONE - x * x * x).clamp(least, most);
        self.damping = (self.damping * factor).max(T::lit(MIN_DAMPING));
        self.growth = T::lit(DAMPING_GROWTH);
    }

    /// Drops a trial and raises the damping; returns the reason of the stop if the damping exceeds [`MAX_DAMPING`].
    fn reject(&mut self) -> Option<Stop> {
        self.damping *= self.growth;
        self.growth *= T::lit(DAMPING_GROWTH);
        (self.damping > T::lit(MAX_DAMPING)).then_some(Stop::NoDescent)
    }

    /// Takes the evaluation pass at the pose reached, and returns the report.
    ///
    /// # Errors
    /// [`Rejection::NoConsensus`] if too few correspondences are within the Huber threshold; [`Rejection::Behind`] if
    /// at least 8 points, and more than half as many as in front, are behind the cameras;
    /// [`Rejection::Unobservable`] if the correspondences leave a direction free, if their disparities may be mostly
    /// noise, or if the baseline has turned towards an optical axis.
    pub fn report(&self, pairs: &[RayPair<T>]) -> Result<PairReport<T>, Rejection> {
        let extrinsics = self.pose.extrinsics().map_err(|_| Rejection::Unobservable)?;
        let least = T::lit(MIN_DISPARITY_PX) / self.focal;
        let evaluated =
            Evaluation::over(pairs, &self.start, &self.pose, self.loss.threshold, least);
        if evaluated.inliers < self.min_usable {
            return Err(Rejection::NoConsensus);
        }
        if is_behind(evaluated.sides.map(T::count)) {
            return Err(Rejection::Behind);
        }
        let usable = T::count(self.at_pose.usable);
        let variance = (evaluated.clipped_squares / (usable - T::lit(5.0)))
            .max(self.noise_floor * self.noise_floor);
        // Row offsets and disparities have the same variance, because both are differences of two coordinates.
        let inliers = T::count(evaluated.inliers);
        let information = less_disparity_noise(&evaluated.information, inliers, variance)
            .filter(Information::is_observable)
            .ok_or(Rejection::Unobservable)?
            .scaled(inliers / (usable * variance));
        let screened = T::count(evaluated.screened.max(1));
        let rms = |squares: T| (squares / screened).sqrt() * self.focal;
        Ok(PairReport {
            extrinsics,
            information,
            stop: self.stop.unwrap_or(Stop::PassesSpent),
            passes: self.passes,
            usable: self.at_pose.usable,
            skipped: self.at_pose.skipped,
            screened: evaluated.screened,
            cost_before: self.cost_before * self.focal * self.focal,
            cost_after: self.at_pose.cost * self.focal * self.focal,
            rms_px_before: rms(evaluated.squares_before),
            rms_px_after: rms(evaluated.squares_after),
            noise_px: variance.sqrt() * self.focal,
        })
    }
}

impl<T: Scalar> Pass<T> {
    const EMPTY: Self = Self {
        information: Information::ZERO,
        gradient: Vector5::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO),
        cost: T::ZERO,
        squares: T::ZERO,
        usable: 0,
        skipped: 0,
    };

    /// Returns the sums over a batch, computed in blocks.
    fn over(pairs: &[RayPair<T>], pose: &RectifyingRotations<T>, loss: Huber<T>) -> Self {
        let gauge_slope = pose.gauge_slope();
        let mut total = Self::EMPTY;
        for block in pairs.chunks(BLOCK) {
            let mut sums = Self::EMPTY;
            for pair in block {
                let Some(row) = linearised(pose, gauge_slope, pair) else {
                    sums.skipped = sums.skipped.saturating_add(1);
                    continue;
                };
                let w = loss.weight(row.offset);
                sums.information.add_outer(w, &row.jacobian);
                let weighted = w * row.offset;
                add_pull(&mut sums.gradient, weighted, &row.jacobian);
                sums.squares += weighted * weighted;
                sums.cost += loss.cost(row.offset);
                sums.usable = sums.usable.saturating_add(1);
            }
            total.information.add(&sums.information);
            total.gradient += sums.gradient;
            total.cost += sums.cost;
            total.squares += sums.squares;
            total.usable = total.usable.saturating_add(sums.usable);
            total.skipped = total.skipped.saturating_add(sums.skipped);
        }
        total
    }

    /// Returns the solution `x` of `(H + damping diag H) x = -gradient`, rad. `None` if a pivot is not positive or not
    /// finite.
    fn step(&self, damping: T) -> Option<Vector5<T>> {
        Some(-self.information.0.factor(damping)?.solve(&self.gradient))
    }

    /// Returns the rounding error of the cost. One part is the rounding of the residuals, which are differences of
    /// numbers of the size 1; the other part is the rounding of the sum.
    fn cost_rounding(&self) -> T {
        T::lit(COST_ULPS) * T::EPSILON * (self.squares.sqrt() + self.cost)
    }

    /// Returns the cost, in which a ray behind a camera counts as a row offset of 1 at unit depth. Therefore no step
    /// gains by turning rays away.
    fn penalised(&self, penalty: T) -> T {
        self.cost + T::count(self.skipped) * penalty
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn turning_the_cameras_away_from_outliers_raises_the_cost() {
        let outlier = |i: u8| {
            let x = f64::from(i) / 100.0 + 0.6;
            RayPair::try_new([x, 0.4], [x - 0.1, -0.4]).unwrap()
        };
        let pairs: heapless::Vec<RayPair<f64>, 100> = (0..100).map(outlier).collect();
        let loss = Huber { threshold: 1e-3 };
        let pass = |yaw: f64| {
            let right = crate::geometry::so3::exp(&Vector3::new(0.0, yaw, 0.0)).unwrap();
            let t = right * -Vector3::x();
            let rig = Extrinsics::try_new(right.matrix(), &t).unwrap();
            Pass::over(&pairs, &RectifyingRotations::from(&rig), loss)
        };
        let [ahead, away] = [0.0, -1.2].map(pass);
        assert_eq!([ahead.skipped, away.usable], [0, 0]);
        let penalty = loss.cost(1.0);
        assert!(away.penalised(penalty) > ahead.penalised(penalty));
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_cost() {
        let pairs: heapless::Vec<RayPair<f64>, 60> = (0..60_u8)
            .map(|i| {
                let k = f64::from(i);
                let [x, y] = [(0.7 * k).sin() * 0.6, (1.1 * k).cos() * 0.4];
                RayPair::try_new([x, y], [x - 0.05, y + 0.003 * (0.3 * k).sin()]).unwrap()
            })
            .collect();
        let loss = Huber { threshold: 1e-3 };
        let pose =
            crate::geometry::rectification::tests::pose([0.001, -0.002, 0.001], [0.002, 0.003]);
        let at = Pass::over(&pairs, &pose, loss);
        for i in 0..5 {
            let cost = |h: f64| {
                let moved = pose.stepped_by(&Vector5::ith(i, h)).unwrap();
                Pass::over(&pairs, &moved, loss).cost
            };
            let numeric = (cost(1e-7) - cost(-1e-7)) / 2e-7;
            let scale = at.gradient.amax();
            assert!((at.gradient[i] - numeric).abs() < 1e-5 * scale, "{i}: {numeric}");
        }
    }
}
