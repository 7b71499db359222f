//! Vibration: random motion of a rig from pair to pair about a constant mean (`ESTIMATOR.md`, section 14).
//!
//! The optima of successive pairs are compared with each other, not with the estimate. Each distance gives one estimate
//! of each variance. The median of the latest estimates decides, so that a knock is only one outlier among many.

use nalgebra::Vector5;

use crate::algebra::block_variances::BlockVariances;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::{AVERAGED_PAIRS, VIBRATION_RAD};
use samples::{RING, SAMPLES, Sample, Samples, most};
use scatter::Scatter;

mod samples;
mod scatter;

/// Factor of the variance in the square of a distance, with two constants derived from it. They are computed at compile
/// time, because a controller divides `f64` in software.
struct Times<T> {
    /// Factor of the variance, dimensionless.
    factor: T,
    /// Standard deviation of one estimate times `sqrt(tr S^-2)`, where `S` is the covariance of the distance.
    spread: T,
    /// Variance that the motion of a rigid rig adds to a distance, rad^2.
    rigid: T,
}

impl<T: Scalar> Times<T> {
    /// Returns the constants of a kind of distance. Kind 0 is the distance between two pairs; any other kind is the
    /// distance of a pair from the mean of its neighbours.
    fn of(kind: usize) -> Self {
        if kind == 0 { Self::constant(2.0) } else { Self::constant(1.5) }
    }

    #[inline(always)]
    fn constant(times: f64) -> Self {
        Self {
            factor: T::lit(times),
            spread: T::lit(core::f64::consts::SQRT_2 / times),
            rigid: T::lit(times * VIBRATION_RAD * VIBRATION_RAD),
        }
    }
}

/// Variance of an unknown that is left out, rad^2. Such an unknown carries almost no information, but the matrix stays
/// invertible.
const LEFT_OUT: f64 = 1e6;

/// Unknowns with a common variance.
#[derive(Debug, Clone, Copy)]
enum Block {
    Rotation,
    Baseline,
}

impl Block {
    /// Returns a distance and its covariance, restricted to the unknowns of the block.
    fn of<T: Scalar>(self, d: &Vector5<T>, covariance: &Symmetric5<T>) -> Distance<T> {
        let [h0, h1, h2, h3, h4, h5, .., h9, _, _, _, h13, h14] = covariance.0;
        let ([[a, b, c, y, z]], zero, out) = (d.data.0, T::ZERO, T::lit(LEFT_OUT));
        let [o3, o4] = [[zero; 3], [zero; 3]];
        let ([p, q, r], [s, t, u]) = (o3, o4);
        match self {
            Self::Rotation => Distance {
                d: Vector5::new(a, b, c, zero, zero),
                covariance: Symmetric5([h0, h1, h2, h3, h4, h5, p, q, r, out, s, t, u, zero, out]),
            },
            Self::Baseline => Distance {
                d: Vector5::new(zero, zero, zero, y, z),
                covariance: Symmetric5([
                    out, zero, out, zero, zero, out, p, q, r, h9, s, t, u, h13, h14,
                ]),
            },
        }
    }
}

/// Distance between two optima, or of one optimum from the mean of two others.
struct Distance<T: Scalar> {
    /// Distance, rad.
    d: Vector5<T>,
    /// Covariance for a rigid rig, rad^2.
    covariance: Symmetric5<T>,
}

impl<T: Scalar> Distance<T> {
    /// Returns an estimate of the variance from this distance.
    ///
    /// * `known`: current estimate of the variance, rad^2; `times`: factor of the variance in the squared distance.
    fn variance(&self, known: T, times: &Times<T>) -> Option<Sample<T>> {
        let trace = |m: &Symmetric5<T>| m.diagonal().into_iter().fold(T::ZERO, |sum, d| sum + d);
        let mut expected = self.covariance;
        expected.add_diagonal(known * times.factor);
        let factor = expected.factor(T::ZERO)?;
        let (pull, inverse) = (factor.solve(&self.d), factor.inverse());
        let (sum, squares) = (trace(&inverse), inverse.dot(&inverse));
        // Cube root of the ratio of the median of a chi-square variable to its mean (Wilson and Hilferty).
        let root = T::ONE - T::lit(2.0 / 9.0) * squares / (sum * sum);
        let estimate = |form: T| known + (form - sum) / (squares * times.factor);
        let form = pull.norm_squared();
        let (mean, median) = (estimate(form), estimate(form / (root * root * root)));
        let spread = times.spread / squares.sqrt();
        let mut rigid = self.covariance;
        rigid.add_diagonal(times.rigid);
        let rigid = rigid.inverse()?;
        let deviation = times.spread / rigid.dot(&rigid).sqrt();
        let most = T::lit(2.0) * most::<T>();
        (median.is_finite() && deviation.is_finite()).then(|| Sample {
            median: median.clamp(-most, most),
            mean: mean.clamp(-most, most),
            spread,
            deviation: deviation.min(T::ONE),
        })
    }
}

/// Optimum of a pair alone.
#[derive(Debug, Clone, Copy)]
struct PairOptimum<T: Scalar> {
    /// Unknowns relative to the factory extrinsics, rad. Differences of these unknowns approximate the distances of
    /// nearby poses.
    at: Vector5<T>,
    covariance: Symmetric5<T>,
}

/// Variances of a vibration, without the samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnownVibration<T> {
    /// Variances, rad^2.
    pub(crate) variances: BlockVariances<T>,
    /// Standard deviations of a sample for a rigid rig: for rotation and for baseline, rad^2.
    pub(crate) deviations: [T; 2],
}

impl<T: Scalar> KnownVibration<T> {
    pub(crate) const NONE: Self =
        Self { variances: BlockVariances::ZERO, deviations: [T::ZERO; 2] };
}

/// Estimator of the variances of a vibration.
#[derive(Debug, Clone)]
pub(super) struct VibrationEstimator<T: Scalar> {
    last: Option<PairOptimum<T>>,
    /// Optimum of the pair before `last`.
    before: Option<PairOptimum<T>>,
    /// Samples from first and from second differences, each for rotation and for baseline.
    samples: [[Samples<T>; 2]; 2],
    /// Numbers of samples from first and from second differences, at most [`AVERAGED_PAIRS`].
    counts: [u32; 2],
    variances: BlockVariances<T>,
    scatter: Scatter<T>,
}

impl<T: Scalar> VibrationEstimator<T> {
    pub(super) const RIGID: Self = Self {
        last: None,
        before: None,
        samples: [[Samples::NONE; 2]; 2],
        counts: [0; 2],
        variances: BlockVariances::ZERO,
        scatter: Scatter::NONE,
    };

    /// Forgets all pairs. Works in place.
    pub(super) fn clear(&mut self) {
        self.interrupt();
        self.samples.iter_mut().flatten().for_each(|samples| *samples = Samples::NONE);
        self.counts = [0; 2];
        self.variances = BlockVariances::ZERO;
        self.scatter = Scatter::NONE;
    }

    /// Forgets the last optima, so that the next pair is not compared with earlier pairs.
    pub(super) fn interrupt(&mut self) {
        (self.last, self.before) = (None, None);
    }

    /// Returns the variances of the vibration, rad^2; zero if there is no sign of vibration.
    pub(super) fn variances(&self) -> BlockVariances<T> {
        self.variances
    }

    /// Returns the variances, and the standard deviation of a sample of each for a rigid rig.
    pub(super) fn known(&self) -> KnownVibration<T> {
        let [[r1, b1], [r2, b2]] = &self.samples;
        let deviation = |a: &Samples<T>, b: &Samples<T>| a.deviation.max(b.deviation);
        KnownVibration {
            variances: self.variances,
            deviations: [deviation(r1, r2), deviation(b1, b2)],
        }
    }

    /// Restarts with a known vibration: fills all samples with its variances.
    pub(super) fn resume(&mut self, known: &KnownVibration<T>) {
        self.clear();
        if known.variances.is_zero() {
            return;
        }
        let BlockVariances { rotation, baseline } = known.variances;
        for kind in &mut self.samples {
            let each = kind.iter_mut().zip([rotation, baseline]).zip(known.deviations);
            for ((samples, variance), deviation) in each {
                *samples = Samples { values: [variance; SAMPLES], deviation, mean: variance };
            }
        }
        (self.counts, self.variances) = ([RING; 2], known.variances);
    }

    /// Adds a pair of a new scene.
    #[inline(never)]
    pub(super) fn add(&mut self, measurement: &PairMeasurement<T>, context: &Context<'_, T>) {
        let alone = measurement.moments.biased_at_frame().debiased().with_prior(context.prior);
        let optimum = alone.optimum();
        let at = optimum.and_then(|(step, c)| Some((measurement.pose.stepped_by(&step)?, c)));
        if let Some((pose, covariance)) = at {
            self.compare(context.factory_pose.unknowns_to(&pose), covariance);
        }
    }

    /// Compares the optimum of a pair with the two previous optima.
    ///
    /// * `at`: unknowns relative to the factory extrinsics, rad; `covariance`: covariance of the optimum, rad^2.
    fn compare(&mut self, at: Vector5<T>, covariance: Symmetric5<T>) {
        let [last, before] = [self.last, self.before];
        (self.last, self.before) = (Some(PairOptimum { at, covariance }), last);
        let Some(last) = last else { return };
        let (step, sum) = (at - last.at, last.covariance.plus(&covariance));
        self.scatter.add(&step, &sum);
        self.sample(0, &step, &sum);
        if let Some(before) = before {
            let quarter = T::HALF * T::HALF;
            let both = before.covariance.plus(&covariance).scaled(quarter);
            let apart = last.at - (before.at + at) * T::HALF;
            self.sample(1, &apart, &both.plus(&last.covariance));
        }
        self.update();
    }

    /// Adds the samples for rotation and baseline from one distance.
    ///
    /// * `kind`: 0 for first differences, 1 for second differences; `d`: distance, rad; `covariance`: covariance of the
    ///   distance for a rigid rig, rad^2.
    fn sample(&mut self, kind: usize, d: &Vector5<T>, covariance: &Symmetric5<T>) {
        let known = self.variances.at_least_rigid();
        let times = Times::of(kind);
        let rotation = Block::Rotation.of(d, covariance).variance(known.rotation, &times);
        let baseline = Block::Baseline.of(d, covariance).variance(known.baseline, &times);
        let both = rotation.zip(baseline);
        let kinds = self.samples.get_mut(kind).zip(self.counts.get_mut(kind));
        let Some(((rotation, baseline), (samples, count))) = both.zip(kinds) else { return };
        *count = count.saturating_add(1).min(AVERAGED_PAIRS);
        let [of_rotation, of_baseline] = samples;
        of_rotation.add(rotation, *count);
        of_baseline.add(baseline, *count);
    }

    /// Sets each variance to the smaller of the values from first and from second differences. A drift raises only
    /// first differences, and each knock enters two second differences but only one first difference.
    ///
    /// Rotations of the cameras also move the baseline. So if the rotation vibrates, the baseline may vibrate too, and
    /// its limit is not raised by the scatter.
    fn update(&mut self) {
        let scatter = self.scatter.ratio();
        let [first, second] = &self.samples;
        let ([of_first, of_second], before) = (self.counts, self.variances);
        let least = |a: &Samples<T>, b: &Samples<T>, before: T, scatter: T| {
            a.variance(of_first, before, scatter).min(b.variance(of_second, before, scatter))
        };
        let ([r1, b1], [r2, b2]) = (first, second);
        let rotation = least(r1, r2, before.rotation, scatter);
        let scatter = if rotation > T::ZERO { T::ONE } else { scatter };
        let baseline = least(b1, b2, before.baseline, scatter);
        self.variances = BlockVariances { rotation, baseline };
    }
}

#[cfg(test)]
mod tests;
