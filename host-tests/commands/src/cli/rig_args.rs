//! The rig of a command, and values that its files may lack.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use host_tests::data::{Dataset, Meta};

use super::parse::{numbers, sizes};
use crate::conventions::{self, Unknowns};

/// Values that rig files may lack.
#[derive(Debug, Clone, Default, Args)]
pub struct RigArgs {
    /// Size of the rig's images, px, if its files lack it or have several; of left and right if they differ.
    #[arg(long, value_parser = sizes, value_name = "W,H[,W,H]")]
    size: Option<[[u16; 2]; 2]>,

    /// Unit of T in metres, if T is in units of the board: 0.001 for mm [default: 1].
    #[arg(long, value_name = "M")]
    unit: Option<f64>,

    /// Numbers of the left and right camera in a file: 2,3 for the colour cameras of KITTI [default: 0,1; for a Luxonis
    /// camera the sockets that its file names].
    #[arg(long, value_parser = numbers::<u8, 2>, value_name = "LEFT,RIGHT")]
    cameras: Option<[u8; 2]>,
}

impl RigArgs {
    /// The values in the form of the readers.
    #[must_use]
    pub fn unknowns(&self) -> Unknowns {
        Unknowns { sizes: self.size, unit_m: self.unit.unwrap_or(1.0), cameras: self.cameras }
    }
}

/// The rig of files that [`conventions::import`] reads, of a `meta.json`, or of a data set.
///
/// # Errors
/// Names file, key and value.
pub fn read_rig(places: &[PathBuf], unknowns: Unknowns) -> Result<Meta> {
    match places {
        [one] if is_ours(one) => Dataset::find_meta(one),
        _ => conventions::import(places, unknowns),
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
    let text = std::fs::read_to_string(place).unwrap_or_default();
    text.contains("\"K_l\"") && text.contains("\"dist_l\"")
}
