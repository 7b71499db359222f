//! True depths of matches: `truth/NNNN.csv` beside the pairs of a data set. `NNNN` is the number of the pair, from 0.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

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
///
/// # Errors
/// Names the file.
pub fn read(dir: &Path, pairs: usize) -> Result<Option<Vec<Vec<TrueDepth>>>> {
    let truth = dir.join("truth");
    if !truth.is_dir() {
        return Ok(None);
    }
    (0..pairs).map(|i| of_pair(&truth.join(format!("{i:04}.csv")))).collect::<Result<_>>().map(Some)
}

fn of_pair(path: &Path) -> Result<Vec<TrueDepth>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let read = || -> Result<Vec<TrueDepth>> {
        let text = fs::read_to_string(path)?;
        let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
        let depths: Vec<TrueDepth> = rows.collect::<Result<_, _>>()?;
        ensure!(depths.iter().all(|d| d.depth_m > 0.0), "a depth must be above 0 m");
        Ok(depths)
    };
    read().with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
mod tests {
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
