//! Correspondences of a matcher in pixels, and their rays at unit depth.

use nalgebra::Vector2;

use super::grid::Cell;
use super::row_grid::step_of;
use super::short_float::ShortFloat;
use crate::error::{PushError, Side, UndistortError};
use crate::geometry::camera::{Camera, CameraRay};
use crate::geometry::cameras::Cameras;
use crate::geometry::lens_correction::RayChange;
use crate::scalar::Scalar;
use crate::thresholds::MAX_TANGENT;

/// Value of the low bits of [`RayPair`]'s tag for a score of 1. The bits above hold the cell.
const FULL_SCORE: u16 = (1 << SCORE_BITS) - 1;
const SCORE_BITS: u16 = 10;

/// Largest grid step, px.
const MAX_GRID_STEP_PX: f64 = 65_535.0 / 256.0;

/// Format of the grid steps: 10 bits from 1/256 px, rounded by 1/128 at most, and exact for 2^n px. Its code 0 is taken
/// for a step of 0.
const GRID_STEP: ShortFloat = ShortFloat::new((1.0 - 1.0 / 128.0) / 256.0, 6, 10);

/// Format of the local scales: 6 bits from 1/4 to 60, rounded by 1/16 at most. The bits of the grid step are above them.
const SCALE: ShortFloat = ShortFloat::new(0.25, 3, SCALE_BITS);
const SCALE_BITS: u32 = 6;
const SCALES: u16 = (1 << SCALE_BITS) - 1;

/// Code of the local scale of a pinhole camera, which is 1.
const UNIT_SCALE: u16 = 16;

/// One left/right correspondence in pixel coordinates of the captured images, before undistortion.
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
    /// 1/2^f for f fraction bits, 1.2^level on a pyramid, 0 for continuous coordinates. A larger step that the rows
    /// show counts in its place, so 0 is safe for a matcher whose step is not known.
    pub grid_step: T,
}

impl<T: Scalar> Correspondence<T> {
    /// Returns the score in steps of 1/1023.
    pub(crate) fn score_steps(&self) -> u16 {
        nearest(self.score * T::count(FULL_SCORE.into()))
    }
}

/// Returns the nearest integer, saturated to the range of `u16`.
fn nearest<T: Scalar>(x: T) -> u16 {
    (x + T::HALF).to_u16()
}

/// Returns whether a number is from 0 to `most`, by one comparison of bits: the bits of negative numbers and of NaN
/// compare as larger. False for -0.
#[inline(always)]
fn is_within<T: Scalar>(x: T, most: T) -> bool {
    x.bits() <= most.bits()
}

/// The rays of one correspondence at unit depth, each in its camera frame, dimensionless.
///
/// RAM: 20 bytes in `f32`, with the score in steps of 1/1023, the grid step rounded by 1/128 of itself at most, and the
/// local scale by 1/16.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPair<T> {
    pub(crate) left: Vector2<T>,
    pub(crate) right: Vector2<T>,
    /// Score, and cell of the left pixel.
    tag: u16,
    /// Local scale, and grid step.
    steps: u16,
}

impl<T: Scalar> RayPair<T> {
    /// Rays along both optical axes.
    pub(crate) const ZERO: Self = {
        let axis = Vector2::new(T::ZERO, T::ZERO);
        Self { left: axis, right: axis, tag: 0, steps: UNIT_SCALE }
    };

    /// Creates a pair from undistorted rays `[x, y]` at unit depth, with score 1, continuous coordinates and the local
    /// scale of a pinhole.
    ///
    /// `None` if a coordinate is not finite, or above 11.43 (85 degrees) in magnitude.
    pub fn try_new(left: [T; 2], right: [T; 2]) -> Option<Self> {
        let limit = T::lit(MAX_TANGENT);
        let sane = |x: &T| x.abs() <= limit;
        (left.iter().all(sane) && right.iter().all(sane)).then(|| Self {
            left: left.into(),
            right: right.into(),
            tag: FULL_SCORE,
            steps: UNIT_SCALE,
        })
    }

    /// Returns the pair of two rays.
    ///
    /// * `tag`: score and cell; `grid_step`: code of the grid step.
    #[inline(always)]
    fn of(left: &CameraRay<T>, right: &CameraRay<T>, tag: u16, grid_step: u16) -> Self {
        let density = left.density * right.density;
        // Exact for pinhole cameras, without the roots.
        let is_pinhole = density == T::ONE;
        let scale =
            if is_pinhole { UNIT_SCALE } else { SCALE.code(T::ONE / density.sqrt().sqrt()) };
        Self { left: left.ray, right: right.ray, tag, steps: scale | (grid_step << SCALE_BITS) }
    }

    /// Creates a pair from `x_l`, `y_l`, `x_r`, `y_r` at unit depth.
    #[cfg(test)]
    pub(crate) fn of_rays([x_l, y_l, x_r, y_r]: [T; 4]) -> Self {
        Self::try_new([x_l, y_l], [x_r, y_r]).expect("sane rays")
    }

    /// Returns the pair with another local scale.
    #[cfg(test)]
    pub(crate) fn with_scale(self, scale: T) -> Self {
        Self { steps: (self.steps & !SCALES) | SCALE.code(scale), ..self }
    }

    /// Returns the left ray `[x, y]` at unit depth, in the left camera frame.
    pub fn left(&self) -> [T; 2] {
        self.left.into()
    }

    /// Returns the right ray `[x, y]` at unit depth, in the right camera frame.
    pub fn right(&self) -> [T; 2] {
        self.right.into()
    }

    /// Returns `x_l`, `y_l`, `x_r`, `y_r` at unit depth, each ray in its camera frame.
    #[inline(always)]
    pub(crate) fn rays(&self) -> [T; 4] {
        [self.left.x, self.left.y, self.right.x, self.right.y]
    }

    /// Returns the rays after a change of the parameters of the right camera.
    pub(crate) fn changed(&self, change: &RayChange<T>) -> Self {
        Self { right: change.of(self.right), ..*self }
    }

    /// Returns the confidence of the matcher, 0 to 1, rounded to 1/1023.
    pub fn score(&self) -> T {
        T::count(self.score_steps().into()) / T::count(FULL_SCORE.into())
    }

    /// Returns the score in steps of 1/1023.
    pub(crate) fn score_steps(&self) -> u16 {
        self.tag & FULL_SCORE
    }

    /// Returns the cell of the left pixel; the first cell for rays without a pixel.
    pub(crate) fn cell(&self) -> Cell {
        Cell::from_bits(self.tag >> SCORE_BITS)
    }

    /// Returns the step of the grid that the rows lie on, px, rounded by 1/128 of itself at most; 0 for continuous rows.
    /// The rows may show a larger step than the matcher states.
    pub fn grid_step(&self) -> T {
        match self.steps >> SCALE_BITS {
            0 => T::ZERO,
            code => GRID_STEP.value(code),
        }
    }

    /// Raises the step of the grid to at least `step`, px.
    pub(crate) fn widen_grid(&mut self, step: T) {
        let [own, other] = [self.steps >> SCALE_BITS, GRID_STEP.code(step)];
        self.steps = (self.steps & SCALES) | (own.max(other) << SCALE_BITS);
    }

    /// Returns the local scale, dimensionless: the length of a pixel at unit depth times the mean focal length. It is
    /// 1 for pinhole cameras, and larger towards the border of a wide-angle lens. It is the geometric mean over both
    /// images and all directions in them, rounded by 1/16 of itself at most.
    pub(crate) fn scale(&self) -> T {
        SCALE.value(self.steps & SCALES)
    }
}

impl<T: Scalar> Cameras<T> {
    /// Undistorts one correspondence. Cost: two undistortions, each with a bounded number of iterations.
    ///
    /// # Errors
    /// [`PushError`]: the score, the grid step or a pixel is out of range, or a pixel has no ray.
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

    /// Checks each value, and returns the reason for a refusal. It also accepts the rare valid values that the
    /// comparison of bits in [`Self::check`] does not: -0, and pixel coordinates from -1 to 0.
    #[cold]
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

    /// Returns the cell of the left pixel of a correspondence.
    pub(crate) fn cell(&self, c: &Correspondence<T>) -> Cell {
        Cell::of(c.left, self.left.intrinsics().size)
    }

    /// Returns the rays of a checked correspondence in `cell`.
    #[inline(always)]
    pub(crate) fn undistort(
        &self,
        c: &Correspondence<T>,
        cell: Cell,
    ) -> Result<RayPair<T>, PushError> {
        let left = self.left.ray_of_checked(c.left).map_err(|e| PushError::Pixel(Side::Left, e))?;
        let right =
            self.right.ray_of_checked(c.right).map_err(|e| PushError::Pixel(Side::Right, e))?;
        let tag = c.score_steps() | (cell.bits() << SCORE_BITS);
        let step = step_of([c.left[1], c.right[1]], c.grid_step);
        Ok(RayPair::of(&left, &right, tag, GRID_STEP.code(step)))
    }

    /// Returns the rays of the pixels of one point, with score 1 and continuous coordinates.
    ///
    /// # Errors
    /// [`UndistortError`] of the left or the right pixel.
    pub(crate) fn pair(&self, left: [T; 2], right: [T; 2]) -> Result<RayPair<T>, UndistortError> {
        self.left.check(left)?;
        self.right.check(right)?;
        let (left, right) = (self.left.ray_of_checked(left)?, self.right.ray_of_checked(right)?);
        Ok(RayPair::of(&left, &right, FULL_SCORE, 0))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::camera::Intrinsics;
    use crate::geometry::lens::Lens;
    use proptest::prelude::*;

    /// Returns two equal pinhole cameras of 640 x 480 px.
    pub(in crate::batch) fn cameras() -> Cameras<f32> {
        let intrinsics =
            Intrinsics { focal: [500.0; 2], principal: [320.0, 240.0], size: [640, 480] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        Cameras { left: camera, right: camera }
    }

    fn rays(score: f32, grid_step: f32) -> Result<RayPair<f32>, PushError> {
        let c = Correspondence { left: [300.0, 300.3], right: [290.0, 300.6], score, grid_step };
        cameras().rays(&c)
    }

    #[test]
    fn a_ray_pair_takes_20_bytes() {
        assert_eq!(size_of::<RayPair<f32>>(), 20);
    }

    proptest! {
        #[test]
        fn score_and_grid_step_are_rounded(
            score in 0.0..=1.0_f32,
            step in 0.0..=255.99_f32,
        ) {
            let kept = rays(score, step).unwrap();
            prop_assert!((kept.score() - score).abs() <= 0.501 / 1023.0);
            prop_assert!((kept.grid_step() - step.min(252.0)).abs() <= 0.002 + step / 127.9);
        }
    }

    #[test]
    fn the_ends_of_both_ranges_are_exact_and_values_beyond_are_refused() {
        let ends = |score, step| rays(score, step).map(|pair| (pair.score(), pair.grid_step()));
        let largest = 65_535.0 / 256.0;
        assert_eq!(ends(0.0, 0.0), Ok((0.0, 0.0)));
        assert_eq!(ends(1.0, largest), Ok((1.0, 252.0)));
        for step in [1.0 / 256.0, 0.25, 1.0, 1.5, 100.0] {
            assert_eq!(ends(1.0, step), Ok((1.0, step)));
        }
        assert_eq!(ends(1.0_f32.next_up(), 0.0), Err(PushError::Score));
        assert_eq!(ends(1.0, largest.next_up()), Err(PushError::GridStep));
        assert_eq!(ends(1.0, -f32::MIN_POSITIVE), Err(PushError::GridStep));
    }
}
