//! The rig in any files: of another tool, or of a data set.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::bounded;
use crate::data::{Dataset, Meta};
use crate::formats::{self, Unknowns};

/// The rig of files that [`formats::import`] reads, of a `meta.json`, or of a data set.
///
/// # Errors
/// Names file, key and value.
pub fn read_rig(places: &[PathBuf], unknowns: Unknowns) -> Result<Meta> {
    match places {
        [one] if is_ours(one) => Dataset::find_meta(one),
        _ => formats::import(places, unknowns),
    }
}

/// Whether a place is a file with the keys of a `meta.json`, a folder with a `meta.json`, or a place that does not
/// exist and may be the name of a data set.
fn is_ours(place: &Path) -> bool {
    if place.is_dir() {
        return place.join("meta.json").is_file();
    }
    if !place.exists() {
        return place.extension().is_none();
    }
    let bytes = bounded::bytes(place).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    text.contains("\"K_l\"") && text.contains("\"dist_l\"")
}
