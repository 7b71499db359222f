//! The grid of a matcher's coordinates.

use anyhow::{Result, ensure};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Possible places of keypoints, in both images.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grid {
    /// Anywhere.
    #[default]
    Continuous,
    /// On multiples of this step, px.
    Pixels(f64),
    /// On multiples of `1.2^level` px: whole pixels of an image pyramid. The level, 0 to 7, is random for each match,
    /// and the same in both images.
    Pyramid,
}

/// Steps of the pyramid's levels, px. They are computed as products, because the last bits of `powi` depend on the
/// platform.
pub(crate) const LEVELS: [f64; 8] = {
    let mut steps = [1.0; 8];
    let mut level = 1;
    while level < steps.len() {
        steps[level] = steps[level - 1] * 1.2;
        level += 1;
    }
    steps
};

impl Grid {
    /// Checks the step.
    ///
    /// # Errors
    /// If the step is out of range.
    pub(crate) fn check(self) -> Result<()> {
        if let Self::Pixels(step) = self {
            ensure!((1e-3..=100.0).contains(&step), "grid must be from 0.001 to 100 px");
        }
        Ok(())
    }

    /// Step of the next match's grid, px; 0 without a grid.
    pub(crate) fn step(self, rng: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Continuous => 0.0,
            Self::Pixels(step) => step,
            Self::Pyramid => LEVELS[rng.random_range(0..LEVELS.len())],
        }
    }
}

/// The multiple of `step` nearest to `x` that is at most `last`; `x` itself if `step` is 0.
pub(crate) fn rounded(x: f64, step: f64, last: f64) -> f64 {
    if step == 0.0 { x } else { (x / step).round().min((last / step).floor()) * step }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_goes_to_the_nearest_multiple_inside_the_image() {
        for (x, step, expected) in [
            (7.3, 0.0, 7.3),
            (7.3, 1.0, 7.0),
            (7.5, 0.25, 7.5),
            (7.3, 2.0, 8.0),
            (9.0, 1.2, 1.2 * 7.0),
        ] {
            assert!((rounded(x, step, 9.0) - expected).abs() < 1e-12, "{x} {step}");
        }
    }

    #[test]
    fn a_step_outside_of_its_range_is_refused() {
        assert!(Grid::Pixels(0.0).check().is_err() && Grid::Pixels(f64::NAN).check().is_err());
    }
}
