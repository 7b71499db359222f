//! Witness of a known distance: the disparity of a match determines the yaw of the mount (`docs/witnesses.md`).

use nalgebra::Vector2;

use crate::batch::correspondence::RayPair;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{BASELINE_LENGTH_SD, MAX_RANGE_M, MIN_RANGE_M};

/// A distance from the left camera, m.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Range<T> {
    /// Along the optical axis: depth, for instance of a wall ahead or of flat ground below.
    AlongAxis(T),
    /// Along the ray of the pixel, as a laser rangefinder measures it.
    AlongRay(T),
}

/// A point of the left image at a known distance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RangeReading<T> {
    /// `[u, v]` in the left image, px, before undistortion.
    pub pixel: [T; 2],
    /// The same point in the right image, px, before undistortion, if the matcher has looked for it. With `None`, the
    /// match of the last pair that is nearest to `pixel` in the left image is used, if it is within 3 px; few pairs
    /// have such a match.
    pub right: Option<[T; 2]>,
    /// Distance of the point, m.
    pub range: Range<T>,
    /// Standard deviation of the distance, m.
    pub sd_m: T,
}

/// A reading in the units of the estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InverseDepth<T> {
    /// Baseline over depth along the left optical axis, dimensionless.
    value: T,
    /// Variance of the value, with the uncertainty of the baseline length.
    variance: T,
}

impl<T: Scalar> RangeReading<T> {
    /// Returns whether the distance is within the range of a sensor, and the standard deviation above 0 and at most the
    /// distance.
    pub(crate) fn is_valid(&self) -> bool {
        let (Range::AlongAxis(range) | Range::AlongRay(range)) = self.range;
        let within = |x: T| x >= T::lit(MIN_RANGE_M) && x <= T::lit(MAX_RANGE_M);
        within(range) && self.sd_m > T::ZERO && self.sd_m <= range
    }

    /// Returns baseline over depth of the reading, with its variance.
    ///
    /// * `ray`: ray of the pixel, at unit depth.
    /// * `baseline_m`: length of the baseline, m.
    pub(crate) fn inverse_depth(&self, ray: &Vector2<T>, baseline_m: T) -> InverseDepth<T> {
        let (range, per_depth) = match self.range {
            Range::AlongAxis(depth) => (depth, T::ONE),
            Range::AlongRay(range) => (range, (T::ONE + ray.norm_squared()).sqrt()),
        };
        let value = baseline_m * per_depth / range;
        let [relative, length] = [self.sd_m / range, T::lit(BASELINE_LENGTH_SD)];
        InverseDepth { value, variance: value * value * (relative * relative + length * length) }
    }
}

impl<T: Scalar> InverseDepth<T> {
    /// Returns the turn about y, rad, from a pose to the pose at which a match has this depth, and the variance of the
    /// turn, rad^2. `None` if a rectified ray does not point forwards, or if the rays are 90 degrees or more apart
    /// along the columns.
    ///
    /// With rectified rays `a`, `b` and `rho` = baseline over depth, the right ray should be along `a - rho i_1`. It is
    /// off along the columns by `h = a_x b_z - a_z b_x - rho b_z`. A turn changes `h` by `a_z b_z + a_x b_x` per rad.
    ///
    /// * `noise`: variance of a coordinate at unit depth.
    pub(crate) fn turn(
        &self,
        pose: &RectifyingRotations<T>,
        pair: &RayPair<T>,
        noise: T,
    ) -> Option<[T; 2]> {
        let a = pose.left() * pair.left.push(T::ONE);
        let b = pose.right() * pair.right.push(T::ONE);
        let slope = a.z * b.z + a.x * b.x;
        if !(a.z > T::ZERO && b.z > T::ZERO && slope > T::ZERO) {
            return None;
        }
        let off = a.x * b.z - a.z * b.x - self.value * b.z;
        let variance = (self.variance * b.z * b.z + noise + noise) / (slope * slope);
        Some([-off / slope, variance])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extrinsics::Extrinsics;
    use crate::geometry::so3;
    use nalgebra::{Vector3, Vector5};

    fn truth() -> RectifyingRotations<f64> {
        let rotation = so3::exp(&Vector3::new(0.02, -0.01, 0.03)).unwrap();
        let t = Vector3::new(-1.0, 0.02, -0.03);
        RectifyingRotations::from(&Extrinsics::try_new(rotation.matrix(), &t).unwrap())
    }

    /// Returns the rays to a point, which is given in the left camera frame in baseline lengths.
    fn seen(point: Vector3<f64>) -> RayPair<f64> {
        let extrinsics = truth().extrinsics().unwrap();
        let right = extrinsics.rotation() * point + extrinsics.translation().into_inner();
        RayPair::try_new(
            [point.x / point.z, point.y / point.z],
            [right.x / right.z, right.y / right.z],
        )
        .unwrap()
    }

    #[test]
    fn the_turn_to_a_known_depth_is_the_error_of_yaw() {
        for (x, y, z) in [(1.0, 0.5, 8.0), (-9.0, 3.0, 40.0), (0.0, 0.0, 3.0)] {
            let pair = seen(Vector3::new(x, y, z));
            let baseline_m = 0.2;
            let depth = z * baseline_m;
            let distance = Vector3::new(x, y, z).norm() * baseline_m;
            for (range, sd_m) in [(Range::AlongAxis(depth), 0.01), (Range::AlongRay(distance), 0.1)]
            {
                let reading = RangeReading { pixel: [0.0; 2], right: None, range, sd_m };
                let expected = reading.inverse_depth(&pair.left, baseline_m);
                for yaw in [0.0, 3e-3, -3e-3] {
                    let off = truth().stepped_by(&Vector5::new(0.0, yaw, 0.0, 0.0, 0.0)).unwrap();
                    let [turn, variance] = expected.turn(&off, &pair, 1e-8).unwrap();
                    assert!((turn + yaw).abs() < 1e-5, "{x} {y} {z}: {turn} {yaw}");
                    assert!(variance > 1e-8 && variance < 1e-2, "{variance}");
                }
            }
        }
    }

    #[test]
    fn a_reading_beyond_a_sensor_is_refused() {
        let reading = |range, sd_m| {
            let range = Range::AlongAxis(range);
            RangeReading { pixel: [0.0; 2], right: None, range, sd_m }
        };
        assert!(reading(10.0, 0.1).is_valid());
        for (range, sd) in [(0.0, 0.1), (-1.0, 0.1), (1e9, 0.1), (f64::NAN, 0.1), (10.0, 0.0)] {
            assert!(!reading(range, sd).is_valid(), "{range} {sd}");
        }
        assert!(!reading(10.0, f64::NAN).is_valid() && !reading(10.0, 20.0).is_valid());
    }
}
