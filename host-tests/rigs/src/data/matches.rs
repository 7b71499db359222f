//! A correspondence in the form of the files.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use stereo_selfcal::{Correspondence, Scalar};

/// One correspondence, px of the captured images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// Left column.
    pub ul: f64,
    /// Left row.
    pub vl: f64,
    /// Right column.
    pub ur: f64,
    /// Right row.
    pub vr: f64,
    /// The matcher's confidence, 0 to 1.
    pub score: f64,
    /// Step of the matcher's grid, px; 0 for continuous coordinates.
    #[serde(default)]
    pub step: f64,
}

impl Match {
    /// Conversion to the core's type.
    #[must_use]
    pub fn correspondence<T: Scalar>(&self) -> Correspondence<T> {
        Correspondence {
            left: [self.ul, self.vl].map(T::lit),
            right: [self.ur, self.vr].map(T::lit),
            score: T::lit(self.score),
            grid_step: T::lit(self.step),
        }
    }
}

/// Reads the correspondences of one pair.
pub(super) fn read_pair(path: &Path) -> Result<Vec<Match>> {
    let read = || csv::Reader::from_path(path)?.into_deserialize().collect();
    let rows: Result<Vec<Match>, csv::Error> = read();
    rows.with_context(|| format!("cannot read {}", path.display()))
}
