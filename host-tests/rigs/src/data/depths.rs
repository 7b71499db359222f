//! True depths of matches: `truth/NNNN.csv` beside the pairs of a data set. `NNNN` is the number of the pair, from 0.

use std::path::Path;

use anyhow::{Result, ensure};
use serde::Deserialize;

use super::csv_file;

/// The true depth of a match of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct TrueDepth {
    /// Row of the match in the file of the pair, from 0.
    #[serde(rename = "match")]
    pub row: usize,
    /// Depth along the optical axis of the left camera, m.
    pub depth_m: f64,
}

/// Reads the true depths of the first `pairs` pairs of a data set; `None` if it has no folder `truth`. A pair without a
/// file has no depths.
pub fn read(dir: &Path, pairs: usize) -> Result<Option<Vec<Vec<TrueDepth>>>> {
    let truth = dir.join("truth");
    if !truth.is_dir() {
        return Ok(None);
    }
    let of_pair = |pair| -> Result<Vec<TrueDepth>> {
        let depths: Vec<TrueDepth> = csv_file::read_pair(&truth, pair)?;
        let path = csv_file::of_pair(&truth, pair);
        let positive = depths.iter().all(|d| d.depth_m > 0.0);
        ensure!(positive, "cannot read {}: a depth must be above 0 m", path.display());
        Ok(depths)
    };
    (0..pairs).map(of_pair).collect::<Result<_>>().map(Some)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn depths_are_read_by_pair_and_a_wrong_one_is_named() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read(dir.path(), 2).unwrap(), None);
        let truth = dir.path().join("truth");
        fs::create_dir(&truth).unwrap();
        fs::write(truth.join("0001.csv"), "match,depth_m\n3,8.5\n").unwrap();
        let depth = TrueDepth { row: 3, depth_m: 8.5 };
        assert_eq!(read(dir.path(), 2).unwrap(), Some(vec![vec![], vec![depth]]));
        fs::write(truth.join("0000.csv"), "match,depth_m\n3,-1\n").unwrap();
        assert!(format!("{:#}", read(dir.path(), 2).unwrap_err()).contains("0000.csv"));
    }
}
