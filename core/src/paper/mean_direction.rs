//! The paper's fusion (eqs 20 to 22): mean directions of `t^k` and of the rotation axes, and a central angle.
//!
//! All sums are compensated, and all except the sum of the axes add differences from the first pair. A million pairs
//! therefore lose no digit in `f32`. All pairs have the same weight. Near `R = I` the axis of a pair is noise and the
//! result is biased; then `axis_is_meaningful` is false.

use nalgebra::{Unit, Vector3};

use super::Central;
use super::compensated::Sum;
use super::median::Median;
use crate::algebra::information::StandardDeviations;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::so3;
use crate::outcome::pair_report::PairReport;
use crate::scalar::Scalar;
use crate::thresholds::paper::{
    MAX_ANGLE_RAD, MIN_ANGLE_RAD, MIN_CONCENTRATION, MIN_MEAN_BASELINE,
};

/// Sums over the pairs fused so far. RAM: about 300 bytes in `f32`.
#[derive(Debug, Clone)]
pub struct MeanDirection<T> {
    central: Central,
    /// Number of pairs added.
    pairs: u32,
    /// `t` and rotation vector of the first pair: the origin of the sums of differences.
    first: [Vector3<T>; 2],
    /// Standard deviations of the first pair, rad.
    first_sd: StandardDeviations<T>,
    /// Sum of the differences of `t` from the first pair.
    baseline: [Sum<T>; 3],
    /// Sum of the unit rotation axes.
    axis: [Sum<T>; 3],
    /// Sum of the differences of the rotation vectors from the first pair, rad.
    rotation: [Sum<T>; 3],
    /// Sums of the squared lengths of the differences of `t` and of the rotation vectors.
    squares: [Sum<T>; 2],
    /// Sum of the differences of the rotation angles from the first pair, rad.
    angle: Sum<T>,
    median: Median<T>,
}

/// Estimate over all fused pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FusedEstimate<T: Scalar> {
    /// `R*`, `t*`.
    pub extrinsics: Extrinsics<T>,
    /// Number of fused pairs.
    pub pairs: u32,
    /// Standard errors of the means, rad. The value for `R` includes the distance of `s* v*` from the mean rotation
    /// vector. With one pair they are the standard deviations of that pair.
    pub sd: StandardDeviations<T>,
    /// Length of the mean of the unit rotation axes: 1 where all pairs agree, 0 for pure noise.
    pub axis_concentration: T,
    /// Whether the rotation has a meaningful axis: its angle is far enough from 0 and from a half turn, and
    /// [`Self::axis_concentration`] is at least 0.9.
    pub axis_is_meaningful: bool,
}

impl<T: Scalar> MeanDirection<T> {
    /// Returns the sums before the first pair.
    #[must_use]
    pub const fn new(central: Central) -> Self {
        let origin = Vector3::new(T::ZERO, T::ZERO, T::ZERO);
        Self {
            central,
            pairs: 0,
            first: [origin, origin],
            first_sd: StandardDeviations { rotation: T::ZERO, translation: T::ZERO },
            baseline: [Sum::ZERO; 3],
            axis: [Sum::ZERO; 3],
            rotation: [Sum::ZERO; 3],
            squares: [Sum::ZERO; 2],
            angle: Sum::ZERO,
            median: Median::EMPTY,
        }
    }

    /// Adds one pair in constant time. The gate must have admitted the pair: this function does not check it.
    pub fn add(&mut self, report: &PairReport<T>) {
        if self.pairs == u32::MAX {
            return;
        }
        let t = report.extrinsics.translation().into_inner();
        let rotation = so3::log(report.extrinsics.rotation());
        if self.pairs == 0 {
            self.first = [t, rotation];
            let unknown = T::lit(f64::INFINITY);
            self.first_sd = report
                .information
                .standard_deviations()
                .unwrap_or(StandardDeviations { rotation: unknown, translation: unknown });
        }
        self.pairs = self.pairs.saturating_add(1);
        let [first_t, first_rotation] = self.first;
        let angle = rotation.norm();
        let (dt, dr) = (t - first_t, rotation - first_rotation);
        add(&mut self.baseline, &dt);
        add(&mut self.axis, &unit_or_zero(&rotation, angle));
        add(&mut self.rotation, &dr);
        let [squares_t, squares_r] = &mut self.squares;
        squares_t.add(dt.norm_squared());
        squares_r.add(dr.norm_squared());
        self.angle.add(angle - first_rotation.norm());
        self.median.add(angle);
    }

    /// Returns the number of pairs added.
    pub fn pairs(&self) -> u32 {
        self.pairs
    }

    /// Returns `R*`, `t*` of eqs 21, 22. `None` before the first pair, if the directions cancel, or if the result
    /// cannot be rectified.
    pub fn estimate(&self) -> Option<FusedEstimate<T>> {
        if self.pairs == 0 {
            return None;
        }
        let n = T::count(self.pairs);
        let [first_t, first_rotation] = self.first;
        let mean_t = first_t + mean(&self.baseline, n);
        let mean_axis = mean(&self.axis, n);
        let concentration = mean_axis.norm();
        let angle = match self.central {
            Central::Mean => first_rotation.norm() + self.angle.value() / n,
            Central::Median => self.median.value()?,
        };
        let vector = unit_or_zero(&mean_axis, concentration) * angle;
        let rotation = so3::exp(&vector)?;
        let bias = (vector - first_rotation - mean(&self.rotation, n)).norm();
        let translation = Unit::try_new(mean_t, T::lit(MIN_MEAN_BASELINE))?;
        Some(FusedEstimate {
            extrinsics: Extrinsics::try_new(rotation.matrix(), &translation).ok()?,
            pairs: self.pairs,
            sd: self.standard_deviations(n, bias),
            axis_concentration: concentration,
            axis_is_meaningful: angle >= T::lit(MIN_ANGLE_RAD)
                && angle <= T::lit(MAX_ANGLE_RAD)
                && concentration >= T::lit(MIN_CONCENTRATION),
        })
    }

    /// Returns the standard errors of the means: root of the sample variance over the number of pairs. The value for
    /// `R` includes the bias.
    ///
    /// * `n`: number of pairs.
    /// * `bias`: distance of central angle times mean axis from the mean rotation vector, rad.
    fn standard_deviations(&self, n: T, bias: T) -> StandardDeviations<T> {
        if self.pairs < 2 {
            return self.first_sd;
        }
        let [squares_t, squares_r] = &self.squares;
        let error = |squares: &Sum<T>, mean: Vector3<T>| {
            let scatter = squares.value() / n - mean.norm_squared();
            (scatter.max(T::ZERO) / (n - T::ONE)).sqrt()
        };
        let scatter = error(squares_r, mean(&self.rotation, n));
        StandardDeviations {
            rotation: (scatter * scatter + bias * bias).sqrt(),
            translation: error(squares_t, mean(&self.baseline, n)),
        }
    }
}

fn add<T: Scalar>(sums: &mut [Sum<T>; 3], x: &Vector3<T>) {
    sums.iter_mut().zip(x.iter()).for_each(|(sum, x)| sum.add(*x));
}

fn mean<T: Scalar>(sums: &[Sum<T>; 3], n: T) -> Vector3<T> {
    Vector3::from(sums.map(|sum| sum.value() / n))
}

/// Returns the direction of a vector of known length; zero for length 0.
fn unit_or_zero<T: Scalar>(v: &Vector3<T>, length: T) -> Vector3<T> {
    if length > T::ZERO { v / length } else { Vector3::zeros() }
}
