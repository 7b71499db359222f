//! Correspondences of a matcher in pixels, and their rays at unit depth.

use nalgebra::Vector2;

use super::grid::Cell;
use crate::error::{CameraError, PushError, Side};
use crate::geometry::camera::Camera;
use crate::geometry::lens_correction::{LensCorrection, RayChange};
use crate::scalar::Scalar;
use crate::thresholds::MAX_TANGENT;

/// Score 1 in the low bits of [`RayPair`]'s tag; the bits above hold the cell.
const FULL_SCORE: u16 = (1 << SCORE_BITS) - 1;
const SCORE_BITS: u16 = 10;

/// Resolution of [`RayPair::grid_step`], steps a pixel, and its largest value, px.
const STEPS_PER_PX: f64 = 256.0;
const MAX_GRID_STEP_PX: f64 = 65_535.0 / STEPS_PER_PX;

/// One left/right correspondence in px of the captured images, before undistortion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Correspondence<T> {
    /// `[u, v]` in the left image, px.
    pub left: [T; 2],
    /// `[u, v]` in the right image, px.
    pub right: [T; 2],
    /// Confidence of the matcher, 0 (none) to 1 (certain), dimensionless.
    pub score: T,
    /// Step of the grid that the coordinates are rounded to, px, 0 to 255.99: 1 for whole pixels,
    /// 1/2^f for f fraction bits, 1.2^level on a pyramid, 0 for continuous coordinates.
    pub grid_step: T,
}

impl<T: Scalar> Correspondence<T> {
    /// The score in steps of 1/1023.
    pub(crate) fn score_steps(&self) -> u16 {
        nearest(self.score * T::count(FULL_SCORE.into()))
    }
}

/// Nearest integer, saturated to the range of `u16`.
fn nearest<T: Scalar>(x: T) -> u16 {
    (x + T::HALF).to_u16()
}

/// Whether a number is from 0 to `most`, by one comparison: the bits of a negative number or of NaN compare above.
/// False for -0.
#[inline(always)]
fn is_within<T: Scalar>(x: T, most: T) -> bool {
    x.bits() <= most.bits()
}

/// The rays of one correspondence at unit depth, each in its camera frame, dimensionless.
///
/// RAM: 20 bytes in `f32`, with the score in steps of 1/1023 and the grid step in 1/256 px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPair<T> {
    pub(crate) left: Vector2<T>,
    pub(crate) right: Vector2<T>,
    /// Score, and cell of the left pixel.
    tag: u16,
    grid_step: u16,
}

impl<T: Scalar> RayPair<T> {
    /// Along both optical axes.
    pub(crate) const ZERO: Self = {
        let axis = Vector2::new(T::ZERO, T::ZERO);
        Self { left: axis, right: axis, tag: 0, grid_step: 0 }
    };

    /// From undistorted rays `[x, y]` at unit depth, with score 1 and continuous coordinates.
    ///
    /// `None` if a coordinate is not finite or above 11.43 in size (85 degrees).
    pub fn try_new(left: [T; 2], right: [T; 2]) -> Option<Self> {
        let limit = T::lit(MAX_TANGENT);
        let sane = |x: &T| x.abs() <= limit;
        (left.iter().all(sane) && right.iter().all(sane)).then(|| Self {
            left: left.into(),
            right: right.into(),
            tag: FULL_SCORE,
            grid_step: 0,
        })
    }

    /// Left ray `[x, y]` at unit depth, left camera frame.
    pub fn left(&self) -> [T; 2] {
        self.left.into()
    }

    /// Right ray `[x, y]` at unit depth, right camera frame.
    pub fn right(&self) -> [T; 2] {
        self.right.into()
    }

    /// `x_l`, `y_l`, `x_r`, `y_r` at unit depth.
    #[inline(always)]
    pub(crate) fn rays(&self) -> [T; 4] {
        [self.left.x, self.left.y, self.right.x, self.right.y]
    }

    /// The rays with another lens model of the right camera.
    pub(crate) fn changed(&self, change: &RayChange<T>) -> Self {
        Self { right: change.of(self.right), ..*self }
    }

    /// Confidence of the matcher, 0 to 1, to the nearest 1/1023.
    pub fn score(&self) -> T {
        T::count(self.score_steps().into()) / T::count(FULL_SCORE.into())
    }

    /// The score in steps of 1/1023.
    pub(crate) fn score_steps(&self) -> u16 {
        self.tag & FULL_SCORE
    }

    /// Cell of the left pixel; the first cell for rays without a pixel.
    pub(crate) fn cell(&self) -> Cell {
        Cell::from_bits(self.tag >> SCORE_BITS)
    }

    /// Step of the matcher's grid, px, to the nearest 1/256; 0 for continuous coordinates.
    pub fn grid_step(&self) -> T {
        T::count(self.grid_step.into()) * T::lit(1.0 / STEPS_PER_PX)
    }
}

/// The two cameras of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
pub struct Cameras<T> {
    /// Left camera.
    pub left: Camera<T>,
    /// Right camera.
    pub right: Camera<T>,
}

impl<T: Scalar> Cameras<T> {
    /// Mean focal length of both cameras, px: pixels of a row offset of 1 at unit depth.
    pub fn mean_focal(&self) -> T {
        (self.left.mean_focal() + self.right.mean_focal()) * T::HALF
    }

    /// The cameras with the right lens model corrected. A pinhole with a `k1` becomes radial-tangential.
    ///
    /// # Errors
    /// [`CameraError`] names the quantity that the correction brings out of range.
    pub fn corrected(&self, correction: &LensCorrection<T>) -> Result<Self, CameraError> {
        Ok(Self { right: self.right.corrected(correction)?, ..*self })
    }

    /// Undistorts one correspondence. Cost: two undistortions, each of bounded iterations.
    ///
    /// # Errors
    /// [`PushError`]: score or grid step out of range, or a pixel without a ray.
    pub fn rays(&self, c: &Correspondence<T>) -> Result<RayPair<T>, PushError> {
        self.check(c)?;
        self.undistort(c, self.cell(c))
    }

    /// Checks the ranges of a correspondence before undistortion.
    #[inline(always)]
    pub(crate) fn check(&self, c: &Correspondence<T>) -> Result<(), PushError> {
        let inside = |camera: &Camera<T>, [u, v]: [T; 2]| {
            let [width, height] = camera.intrinsics().size;
            is_within(u, T::count(width.into())) && is_within(v, T::count(height.into()))
        };
        let is_usual = is_within(c.score, T::ONE)
            && is_within(c.grid_step, T::lit(MAX_GRID_STEP_PX))
            && inside(&self.left, c.left)
            && inside(&self.right, c.right);
        if is_usual { Ok(()) } else { self.check_each(c) }
    }

    /// [`Self::check`] with the reason of a refusal. Also accepts pixels up to one pixel left of or above the centre of
    /// the first.
    #[cold]
    #[inline(never)]
    fn check_each(&self, c: &Correspondence<T>) -> Result<(), PushError> {
        if !(c.score >= T::ZERO && c.score <= T::ONE) {
            return Err(PushError::Score);
        }
        if !(c.grid_step >= T::ZERO && c.grid_step <= T::lit(MAX_GRID_STEP_PX)) {
            return Err(PushError::GridStep);
        }
        self.left.check(c.left).map_err(|e| PushError::Pixel(Side::Left, e))?;
        self.right.check(c.right).map_err(|e| PushError::Pixel(Side::Right, e))
    }

    /// Cell of a correspondence's left pixel.
    pub(crate) fn cell(&self, c: &Correspondence<T>) -> Cell {
        Cell::of(c.left, self.left.intrinsics().size)
    }

    /// The rays of a checked correspondence in `cell`.
    #[inline(always)]
    pub(crate) fn undistort(
        &self,
        c: &Correspondence<T>,
        cell: Cell,
    ) -> Result<RayPair<T>, PushError> {
        Ok(RayPair {
            left: self.left.ray_of_checked(c.left).map_err(|e| PushError::Pixel(Side::Left, e))?,
            right: self
                .right
                .ray_of_checked(c.right)
                .map_err(|e| PushError::Pixel(Side::Right, e))?,
            tag: c.score_steps() | (cell.bits() << SCORE_BITS),
            grid_step: nearest(c.grid_step * T::lit(STEPS_PER_PX)),
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::camera::Intrinsics;
    use crate::geometry::lens::Lens;
    use proptest::prelude::*;

    /// Two equal pinhole cameras of 640 x 480 px.
    pub(in crate::batch) fn cameras() -> Cameras<f32> {
        let intrinsics =
            Intrinsics { focal: [500.0; 2], principal: [320.0, 240.0], size: [640, 480] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        Cameras { left: camera, right: camera }
    }

    fn rays(score: f32, grid_step: f32) -> Result<RayPair<f32>, PushError> {
        let c = Correspondence { left: [300.0; 2], right: [290.0, 300.0], score, grid_step };
        cameras().rays(&c)
    }

    #[test]
    fn a_ray_pair_takes_20_bytes() {
        assert_eq!(size_of::<RayPair<f32>>(), 20);
    }

    proptest! {
        #[test]
        fn score_and_grid_step_are_rounded_to_nearest(
            score in 0.0..=1.0_f32,
            step in 0.0..=255.99_f32,
        ) {
            let kept = rays(score, step).unwrap();
            prop_assert!((kept.score() - score).abs() <= 0.501 / 1023.0);
            prop_assert!((kept.grid_step() - step).abs() <= 0.501 / 256.0);
        }
    }

    #[test]
    fn the_ends_of_both_ranges_are_exact_and_values_beyond_are_refused() {
        let ends = |score, step| rays(score, step).map(|pair| (pair.score(), pair.grid_step()));
        let largest = 65_535.0 / 256.0;
        assert_eq!(ends(0.0, 0.0), Ok((0.0, 0.0)));
        assert_eq!(ends(1.0, largest), Ok((1.0, largest)));
        assert_eq!(ends(1.0_f32.next_up(), 0.0), Err(PushError::Score));
        assert_eq!(ends(1.0, largest.next_up()), Err(PushError::GridStep));
        assert_eq!(ends(1.0, -f32::MIN_POSITIVE), Err(PushError::GridStep));
    }
}
