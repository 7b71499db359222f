//! Errors of an estimate against a reference, in radians (eqs 23-26).
//!
//! The paper uses `arccos`, whose error in `f32` is up to 5e-4 rad near zero; `atan2` is exact to rounding (erratum 6
//! in the list of `paper`).

use nalgebra::{Rotation3, Unit, Vector3};

use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::so3;
use crate::scalar::Scalar;

/// Returns the angle between two baseline directions, `e_t` of eq 23, rad, in `0..=pi`.
///
/// * `a`, `b`: unit vectors in one frame, dimensionless.
///
/// Absolute error below 3e-7 rad in `f32` at any angle. Cost: 1 square root, 1 `atan2`.
#[must_use]
pub fn baseline_angle<T: Scalar>(a: &Unit<Vector3<T>>, b: &Unit<Vector3<T>>) -> T {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Returns `e_theta = |theta* - theta|` of eq 24: the distance between the two rotation vectors, rad.
///
/// It is discontinuous where the angle of a rotation is pi (erratum 6); [`rotation_angle`] is continuous.
#[must_use]
pub fn rotation_distance<T: Scalar>(a: &Rotation3<T>, b: &Rotation3<T>) -> T {
    (so3::log(a) - so3::log(b)).norm()
}

/// Returns the angle of the rotation from one rotation to the other, rad, in `0..=pi`.
///
/// Equal to `e_theta` to first order for small rotations, and continuous everywhere.
#[must_use]
pub fn rotation_angle<T: Scalar>(a: &Rotation3<T>, b: &Rotation3<T>) -> T {
    so3::log(&(a.inverse() * b)).norm()
}

/// `e_t` and `e_theta` of one estimate, or their RMS over many estimates (`sigma_t`, `sigma_theta`), rad.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation<T> {
    /// Error of the baseline direction, `e_t`, rad.
    pub translation: T,
    /// Error of the rotation vector, `e_theta`, rad.
    pub rotation: T,
}

impl<T: Scalar> Deviation<T> {
    /// Returns the deviation of `estimate` from `reference` (eqs 23, 24).
    #[must_use]
    pub fn between(estimate: &Extrinsics<T>, reference: &Extrinsics<T>) -> Self {
        Self {
            translation: baseline_angle(estimate.translation(), reference.translation()),
            rotation: rotation_distance(estimate.rotation(), reference.rotation()),
        }
    }

    /// Returns the root mean square over single-pair deviations: `sigma_t`, `sigma_theta` (eqs 25, 26).
    ///
    /// `None` without deviations. Cost: two products per deviation, and two square roots.
    #[must_use]
    pub fn root_mean_square(deviations: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut count = 0_u32;
        let mut sum = Self::default();
        for d in deviations {
            count = count.saturating_add(1);
            sum.translation += d.translation * d.translation;
            sum.rotation += d.rotation * d.rotation;
        }
        let mean_root = |sum: T| (sum / T::count(count)).sqrt();
        (count > 0).then(|| Self {
            translation: mean_root(sum.translation),
            rotation: mean_root(sum.rotation),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(angle: f32) -> Unit<Vector3<f32>> {
        Unit::new_normalize(Vector3::new(-1.0, angle.tan(), 0.0))
    }

    #[test]
    fn baseline_angle_is_accurate_in_f32_where_arccos_reads_zero() {
        for angle in [1e-7_f32, 1e-5, 3e-4, 0.1, 1.5] {
            let got = baseline_angle(&tilted(angle), &tilted(0.0));
            assert!((got - angle).abs() < 3e-7, "{angle} {got}");
        }
        let opposite = Unit::new_normalize(-tilted(0.0).into_inner());
        assert!((baseline_angle(&tilted(0.0), &opposite) - core::f32::consts::PI).abs() < 3e-7);
        let printed = tilted(1e-4).dot(&tilted(0.0)).min(1.0).acos();
        assert!((printed - 1e-4).abs() > 5e-5, "arccos shows no error: {printed}");
    }

    #[test]
    fn rotation_distance_compares_rotation_vectors_and_rotation_angle_is_continuous_at_pi() {
        let r = |w: [f32; 3]| so3::exp(&Vector3::from(w)).unwrap();
        let got = rotation_distance(&r([0.01, 0.02, 0.0]), &r([0.01, 0.02, 1e-5]));
        assert!((got - 1e-5).abs() < 1e-8, "{got}");
        let almost = core::f32::consts::PI - 1e-3;
        let [a, b] = [r([almost, 0.0, 0.0]), r([-almost, 0.0, 0.0])];
        assert!(rotation_distance(&a, &b) > 6.0);
        assert!((rotation_angle(&a, &b) - 2e-3).abs() < 1e-6);
    }

    #[test]
    fn root_mean_square_needs_a_deviation() {
        assert_eq!(Deviation::<f32>::root_mean_square([]), None);
        let d = |translation, rotation| Deviation { translation, rotation };
        let rms = Deviation::root_mean_square([d(3.0, 0.0), d(4.0, 2.0_f64)]).unwrap();
        assert_eq!(rms, d(12.5_f64.sqrt(), 2.0_f64.sqrt()));
    }
}
