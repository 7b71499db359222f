//! Recorded correspondences with known extrinsics: `meta.json` and `pairs/NNNN.csv`.
//!
//! `meta.json` has intrinsics (px) and lens coefficients (in OpenCV's order) of both cameras, the image size, and `R`
//! and unit `t` of `p_r = R p_l + t`. A pair file has the columns `ul,vl,ur,vr,score` and, optionally, `step` (the step
//! of the matcher's grid). Coordinates are px of the captured images, before undistortion. Instead of the pair files,
//! one file `pairs.csv` may have all pairs, with a column `frame`. If the rig moves, `rigs.csv` has the rig of each
//! pair.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use stereo_selfcal::{Cameras, Extrinsics, Scalar};

use super::csv_file;
use super::frame_rows::FrameRows;
use super::matches::Match;
use super::meta::Meta;
use super::pairs_folder::PairsFolder;
use super::rigs::{self, Rig};

/// A rig and its pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Short name: the name of the folder or of the generated scene.
    pub name: String,
    /// The rig; if it moves, its pose after the last pair.
    pub meta: Meta,
    /// Correspondences, pair by pair.
    pub pairs: Vec<Vec<Match>>,
    /// The rig of each pair; empty if the rig does not move.
    pub rigs: Vec<Rig>,
}

impl Dataset {
    /// Folder of the shipped sets.
    pub fn shipped() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../data")
    }

    /// Names of the shipped sets.
    pub const SHIPPED: [&str; 5] =
        ["opencv_chess_corners", "opencv_chess_sift", "motorcycle_sift", "aloe_sift", "oak_sift"];

    /// Reads a folder, or the shipped set of that name if there is no such folder.
    ///
    /// # Errors
    /// As [`Dataset::load`]. If there is neither, the error lists the names of the shipped sets.
    pub fn find(place: &Path) -> Result<Self> {
        let name = place.to_str().filter(|name| Self::SHIPPED.contains(name));
        match name {
            Some(name) if !place.exists() => Self::load(&Self::shipped().join(name)),
            _ if !place.exists() => bail!(
                "{} does not exist, and is not one of the shipped sets ({})",
                place.display(),
                Self::SHIPPED.join(", ")
            ),
            _ => Self::load(place),
        }
    }

    /// The rig of a `meta.json`, of a folder, or of the shipped set of that name.
    ///
    /// # Errors
    /// As [`Dataset::find`]. For a `meta.json`, the error names the file.
    pub fn find_meta(place: &Path) -> Result<Meta> {
        if place.is_file() { Meta::read(place) } else { Ok(Self::find(place)?.meta) }
    }

    /// Reads a folder; pairs in the order of their file names, or of `pairs.csv`.
    pub fn load(dir: &Path) -> Result<Self> {
        let meta = Meta::read(&dir.join("meta.json"))
            .with_context(|| format!("{} is not a data set", dir.display()))?;
        let pairs = pairs(dir)?;
        let rigs = rigs::read(dir, pairs.len())?;
        let name = dir.file_name().unwrap_or(dir.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, meta, pairs, rigs })
    }

    /// Writes a folder that [`Dataset::load`] reads back, if there is a pair.
    ///
    /// # Errors
    /// If the folder exists and is not empty, or a file cannot be written; names the file.
    pub fn save(&self, dir: &Path) -> Result<()> {
        let mut folder = PairsFolder::begin(dir, &self.meta)?;
        for pair in &self.pairs {
            folder.push(pair)?;
        }
        rigs::write(dir, &self.rigs)
    }

    /// Both cameras.
    pub fn cameras<T: Scalar>(&self) -> Result<Cameras<T>> {
        self.meta.cameras()
    }

    /// True extrinsics of the data set; if the rig moves, those of the last pair.
    pub fn truth<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        self.meta.extrinsics()
    }

    /// True extrinsics of each pair; empty if the rig does not move.
    ///
    /// # Errors
    /// Names the pair whose rig is not a stereo rig.
    pub fn truths(&self) -> Result<Vec<Extrinsics<f64>>> {
        let truth =
            |(i, rig): (usize, &Rig)| rig.extrinsics().with_context(|| format!("rig of pair {i}"));
        self.rigs.iter().enumerate().map(truth).collect()
    }
}

/// The pairs of a folder: a file for each pair, or one file for all.
fn pairs(dir: &Path) -> Result<Vec<Vec<Match>>> {
    let (pairs_dir, one_file) = (dir.join("pairs"), dir.join("pairs.csv"));
    if one_file.is_file() {
        ensure!(!pairs_dir.exists(), "{} has both pairs/ and pairs.csv", dir.display());
        let read =
            || -> Result<_> { FrameRows::open(BufReader::new(File::open(&one_file)?))?.collect() };
        return read().with_context(|| format!("cannot read {}", one_file.display()));
    }
    let mut files: Vec<PathBuf> = fs::read_dir(&pairs_dir)
        .with_context(|| format!("cannot list {}", pairs_dir.display()))?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<std::io::Result<_>>()?;
    files.retain(|path| path.extension().is_some_and(|e| e == "csv"));
    files.sort();
    ensure!(!files.is_empty(), "no pair files (*.csv) in {}", pairs_dir.display());
    files.iter().map(|path| csv_file::read(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::meta::LensModel;
    use stereo_selfcal::geometry::LensCorrection;

    #[test]
    fn a_saved_set_loads_back_equal_and_nothing_is_overwritten() {
        for name in Dataset::SHIPPED {
            let set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
            let dir = tempfile::tempdir().unwrap();
            let copy = dir.path().join(name);
            set.save(&copy).unwrap();
            assert_eq!(Dataset::load(&copy).unwrap(), set, "{name}");
            assert!(set.save(&copy).is_err(), "{name} was overwritten");
        }
    }

    #[test]
    fn a_corrected_rig_has_the_cameras_that_the_core_corrects() {
        let correction = LensCorrection { focal: 0.002, k1: -0.01 };
        let meta = |name: &str| Dataset::load(&Dataset::shipped().join(name)).unwrap().meta;
        let radial = meta("opencv_chess_sift");
        let pinhole = Meta { dist_r: Vec::new(), ..meta("motorcycle_sift") };
        let with = |lens, dist: &[f64]| Meta {
            dist_l: dist.to_vec(),
            dist_r: dist.to_vec(),
            lens,
            ..radial.clone()
        };
        let fisheye = with(LensModel::Fisheye, &[0.01, -0.02, 0.0, 0.0]);
        let rational = [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2];
        let rational = with(LensModel::Rational, &rational);
        for meta in [radial.clone(), pinhole, fisheye, rational] {
            let corrected = meta.corrected(&correction).cameras::<f64>().unwrap();
            assert_eq!(corrected, meta.cameras().unwrap().corrected(&correction).unwrap());
            assert_eq!(meta.corrected(&LensCorrection::NONE), meta);
        }
    }

    #[test]
    fn a_damaged_row_is_named_with_its_file_and_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("0007.csv");
        fs::write(&path, "ul,vl,ur,vr,score\n1,2,3,4,1\n1,2,x,4,1\n").unwrap();
        let error = format!("{:#}", csv_file::read::<Match>(&path).unwrap_err());
        assert!(error.contains("0007.csv") && error.contains("line 3, column 3"), "{error}");
    }
}
