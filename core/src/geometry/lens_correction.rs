//! Correction of the given lens models, and calibrations that belong to corrected cameras.

use nalgebra::Vector2;

use super::extrinsics::Extrinsics;
use crate::scalar::Scalar;
use crate::thresholds::MAX_LENS_CORRECTION;

/// Correction of the lens model of the right camera: the two parameters that pairs can separate from the extrinsics.
/// Rows show only the difference between the cameras, and not which camera has changed. The left camera stays as given.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LensCorrection<T> {
    /// Relative change of the focal lengths of the right camera: 0.001 makes them longer by 0.1 %.
    pub focal: T,
    /// Change of the radial coefficient `k1` of the right camera.
    pub k1: T,
}

impl<T: Scalar> LensCorrection<T> {
    /// The lens models as given.
    pub const NONE: Self = Self { focal: T::ZERO, k1: T::ZERO };

    /// Returns whether the lens models are as given.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Returns whether each part is finite and within the range of a correction.
    pub(crate) fn is_valid(&self) -> bool {
        let most = T::lit(MAX_LENS_CORRECTION);
        self.focal.abs() <= most && self.k1.abs() <= most
    }

    /// Returns the sum of this correction and a further one.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { focal: self.focal + other.focal, k1: self.k1 + other.k1 }
    }

    /// Returns the change of the right rays when this correction is replaced by another.
    pub(crate) fn change_to(&self, other: &Self) -> RayChange<T> {
        let scale = (T::ONE + self.focal) / (T::ONE + other.focal);
        RayChange { scale, k1: other.k1 - self.k1 }
    }
}

/// Change of the right rays when the lens model changes. For a pinhole camera it is exact in the focal length, and of
/// first order in `k1`. For other lenses it is approximate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayChange<T> {
    scale: T,
    k1: T,
}

impl<T: Scalar> RayChange<T> {
    /// Returns the ray with the new lens model, at unit depth, for a `ray` with the old model.
    pub(crate) fn of(&self, ray: Vector2<T>) -> Vector2<T> {
        ray * (self.scale * (T::ONE - self.k1 * ray.norm_squared()))
    }
}

/// Extrinsics with the correction of the cameras that they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CorrectedExtrinsics<T: Scalar> {
    pub(crate) extrinsics: Extrinsics<T>,
    pub(crate) correction: LensCorrection<T>,
}

impl<T: Scalar> CorrectedExtrinsics<T> {
    /// Extrinsics of the cameras as given.
    pub(crate) const fn as_given(extrinsics: Extrinsics<T>) -> Self {
        Self { extrinsics, correction: LensCorrection::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::{Camera, Intrinsics};
    use super::super::lens::{Fisheye, Lens, RadialTangential};
    use super::super::rational::Rational;
    use super::*;

    fn camera(lens: Lens<f64>) -> Camera<f64> {
        let intrinsics =
            Intrinsics { focal: [534.0, 531.0], principal: [342.0, 234.5], size: [640, 480] };
        Camera::try_new(intrinsics, lens).unwrap()
    }

    fn radial() -> Lens<f64> {
        let brown = [-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115];
        Lens::RadialTangential(RadialTangential::try_new(brown).unwrap())
    }

    /// Returns the distance between a changed ray and the ray of the corrected camera, px.
    fn error(lens: Lens<f64>, from: LensCorrection<f64>, to: LensCorrection<f64>) -> f64 {
        let pixel = [540.0, 90.0];
        let [old, new] =
            [from, to].map(|by| camera(lens).corrected(&by).unwrap().ray(pixel).unwrap());
        assert!(from == to || (new - old).norm() > 1e-7);
        (from.change_to(&to).of(old) - new).norm() * 534.0
    }

    #[test]
    fn changed_rays_are_those_of_the_corrected_camera() {
        let none = LensCorrection::NONE;
        let [focal, back] = [0.01, -0.004].map(|focal| LensCorrection { focal, k1: 0.0 });
        // Exact if the lens has no distortion.
        assert!(error(Lens::Pinhole, none, focal) < 1e-9);
        assert!(error(Lens::Pinhole, focal, back) < 1e-9);
        // The change is exact to first order in `k1`: the error falls with its square.
        let by = |k1| LensCorrection { focal: 0.001, k1 };
        let [large, small] = [4e-3, 2e-3].map(|k1| error(Lens::Pinhole, by(0.0), by(k1)));
        assert!(small < 0.01 && (large / small - 4.0).abs() < 0.1, "{large} {small}");
        // Between two corrections that differ little, the error is below 0.02 px for each lens.
        let fisheye = Fisheye::try_new([-0.013, 0.027, -0.031, 0.011]).unwrap();
        let [a, b] =
            [(0.002, 0.003), (0.0021, 0.0032)].map(|(focal, k1)| LensCorrection { focal, k1 });
        let rational = [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2];
        let rational = Lens::Rational(Rational::try_new(rational).unwrap());
        for lens in [Lens::Pinhole, radial(), Lens::Fisheye(fisheye), rational] {
            assert!(error(lens, a, b) < 0.02, "{lens:?}");
        }
    }

    #[test]
    fn no_correction_leaves_a_camera_as_it_is() {
        for lens in [Lens::Pinhole, radial()] {
            assert_eq!(camera(lens).corrected(&LensCorrection::NONE), Ok(camera(lens)));
        }
    }

    #[test]
    fn corrections_beyond_any_lens_are_invalid() {
        let valid = |focal: f32, k1| LensCorrection { focal, k1 }.is_valid();
        assert!(valid(0.1, -0.1) && valid(0.0, 0.0));
        assert!(!valid(0.2, 0.0) && !valid(0.0, -0.2));
        assert!(!valid(f32::NAN, 0.0) && !valid(0.0, f32::INFINITY));
    }
}
