//! A matrix as OpenCV's `!!opencv-matrix` and ROS write it: its shape, and all its numbers row by row.

use anyhow::{Result, ensure};
use serde::Deserialize;

/// As it is in the file: the count of its numbers may differ from its shape.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Mat {
    rows: usize,
    cols: usize,
    pub(super) data: Vec<f64>,
}

impl Mat {
    /// As many numbers as its shape has.
    pub(super) fn numbers(&self) -> Result<&[f64]> {
        let Self { rows, cols, data } = self;
        let len = data.len();
        ensure!(rows.checked_mul(*cols) == Some(len), "{len} numbers for {rows} x {cols}");
        Ok(data)
    }

    /// The same of a given shape.
    pub(super) fn shaped(&self, shape: [usize; 2]) -> Result<&[f64]> {
        let (said, [rows, cols]) = ([self.rows, self.cols], shape);
        ensure!(said == shape, "{} x {}: {rows} x {cols} are expected", self.rows, self.cols);
        self.numbers()
    }
}
