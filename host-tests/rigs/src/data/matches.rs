//! A correspondence in the form of the files.

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
    pub fn correspondence<T: Scalar>(&self) -> Correspondence<T> {
        Correspondence {
            left: [self.ul, self.vl].map(T::lit),
            right: [self.ur, self.vr].map(T::lit),
            score: T::lit(self.score),
            grid_step: T::lit(self.step),
        }
    }
}
