//! Matches on a repeated structure: a fence, whose pickets the matcher confuses.

use anyhow::{Result, ensure};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Matches that agree with each other, but not with the scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fence {
    /// Share of all matches, 0 to 1.
    pub share: f64,
    /// Vertical offset of the right pixels, the same for all matches, px.
    pub across_px: f64,
    /// Whether the fence covers only a part of the image: half of the width and two thirds of the height, at a new
    /// place in each pair.
    #[serde(default)]
    pub local: bool,
}

/// Place of a local fence in the left image: left and upper border, px. `None` covers the whole image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place(Option<[f64; 2]>);

/// Shares of the width and of the height that a local fence covers.
const LOCAL: [f64; 2] = [0.5, 2.0 / 3.0];

/// Distance between pickets, px.
const PICKET_PX: f64 = 12.0;

/// Largest number of pickets between the true and the found match.
const PICKETS: i32 = 5;

impl Fence {
    pub(crate) fn check(&self) -> Result<()> {
        ensure!((0.0..=1.0).contains(&self.share), "the fence's share must be from 0 to 1");
        ensure!(self.across_px.is_finite(), "the fence's offset must be finite");
        Ok(())
    }

    /// Random place of the fence in the next pair.
    pub(super) fn place(&self, size: [u16; 2], rng: &mut ChaCha8Rng) -> Place {
        let mut border = |i: usize| rng.random_range(0.0..(1.0 - LOCAL[i]) * f64::from(size[i]));
        Place(self.local.then(|| [border(0), border(1)]))
    }

    /// Pixels `ul vl ur vr` of a match to another picket: 1 to [`PICKETS`] pickets away along the row, and
    /// [`Fence::across_px`] away across the row.
    pub(super) fn matched(&self, [ul, vl, ur, vr]: [f64; 4], rng: &mut ChaCha8Rng) -> [f64; 4] {
        let pickets = rng.random_range(1..=PICKETS) * if rng.random() { 1 } else { -1 };
        [ul, vl, ur + f64::from(pickets) * PICKET_PX, vr + self.across_px]
    }
}

impl Place {
    /// Whether a left pixel is on the fence.
    pub(super) fn covers(&self, pixel: [f64; 2], size: [u16; 2]) -> bool {
        self.0.is_none_or(|border| {
            (0..2).all(|i| {
                let into = pixel[i] - border[i];
                (0.0..LOCAL[i] * f64::from(size[i])).contains(&into)
            })
        })
    }
}
