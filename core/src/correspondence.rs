//! What the matcher delivers, and the fixed-capacity batch of it that one pair is solved from.

use nalgebra::Vector2;

use crate::camera::{Camera, MAX_TANGENT};
use crate::error::{PushError, Side};
use crate::scalar::Scalar;

/// One left/right correspondence, in pixels of the images as they are (before undistortion).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correspondence<T> {
    /// `[u, v]` in the left image, px.
    pub left: [T; 2],
    /// `[u, v]` in the right image, px.
    pub right: [T; 2],
    /// The matcher's confidence, 0 (none) to 1 (certain), dimensionless.
    pub score: T,
    /// Step of the grid that the coordinates were found on, px: 1 for whole pixels, 1/2^f for f
    /// fraction bits, 1.2^level on a pyramid, 0 where they are continuous.
    pub grid_step: T,
}

/// The rays of one correspondence at unit depth (camera frames), dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPair<T> {
    pub(crate) left: Vector2<T>,
    pub(crate) right: Vector2<T>,
    score: T,
    grid_step: T,
}

impl<T: Scalar> RayPair<T> {
    /// From undistorted rays; `None` if a coordinate is not finite or above 11.43 (85 degrees).
    pub fn try_new(left: [T; 2], right: [T; 2]) -> Option<Self> {
        let limit = T::lit(MAX_TANGENT);
        let sane = |x: &T| x.abs() <= limit;
        (left.iter().all(sane) && right.iter().all(sane)).then(|| Self {
            left: left.into(),
            right: right.into(),
            score: T::ONE,
            grid_step: T::ZERO,
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

    /// The matcher's confidence, 0 to 1.
    pub fn score(&self) -> T {
        self.score
    }

    /// Step of the matcher's grid, px; 0 where the coordinates are continuous.
    pub fn grid_step(&self) -> T {
        self.grid_step
    }
}

/// The two cameras of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cameras<T> {
    /// Left camera.
    pub left: Camera<T>,
    /// Right camera.
    pub right: Camera<T>,
}

impl<T: Scalar> Cameras<T> {
    /// Mean focal length of both, px: turns row offsets at unit depth into pixels.
    pub fn mean_focal(&self) -> T {
        (self.left.mean_focal() + self.right.mean_focal()) * T::HALF
    }

    /// Undistorts one correspondence. Cost: two undistortions, each of bounded iterations.
    ///
    /// # Errors
    /// [`PushError`]: pixel without a ray, score or grid step out of range.
    pub fn rays(&self, c: &Correspondence<T>) -> Result<RayPair<T>, PushError> {
        if !(c.score >= T::ZERO && c.score <= T::ONE) {
            return Err(PushError::Score);
        }
        if !(c.grid_step >= T::ZERO && c.grid_step <= T::lit(256.0)) {
            return Err(PushError::GridStep);
        }
        Ok(RayPair {
            left: self.left.ray(c.left).map_err(|e| PushError::Pixel(Side::Left, e))?,
            right: self.right.ray(c.right).map_err(|e| PushError::Pixel(Side::Right, e))?,
            score: c.score,
            grid_step: c.grid_step,
        })
    }
}

/// Up to `N` correspondences as rays, and how many were refused on the way in.
///
/// RAM: 24 bytes a correspondence in `f32`.
#[derive(Debug, Clone)]
pub struct Batch<T, const N: usize> {
    pairs: heapless::Vec<RayPair<T>, N>,
    refused: u32,
}

impl<T: Scalar, const N: usize> Batch<T, N> {
    /// An empty batch.
    #[must_use]
    pub const fn new() -> Self {
        Self { pairs: heapless::Vec::new(), refused: 0 }
    }

    /// Undistorts and keeps one correspondence.
    ///
    /// # Errors
    /// [`PushError`]; the batch is unchanged but for the count of refusals.
    pub fn push(&mut self, cameras: &Cameras<T>, c: &Correspondence<T>) -> Result<(), PushError> {
        let pushed = if self.pairs.is_full() {
            Err(PushError::Full)
        } else {
            cameras.rays(c).and_then(|pair| self.pairs.push(pair).map_err(|_| PushError::Full))
        };
        if pushed.is_err() {
            self.refused = self.refused.saturating_add(1);
        }
        pushed
    }

    /// The correspondences kept so far, in order of arrival.
    pub fn pairs(&self) -> &[RayPair<T>] {
        &self.pairs
    }

    /// Correspondences refused since the last [`Batch::clear`].
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Forgets all correspondences and the count of refusals.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.refused = 0;
    }
}

impl<T: Scalar, const N: usize> Default for Batch<T, N> {
    fn default() -> Self {
        Self::new()
    }
}
