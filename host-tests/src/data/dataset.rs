//! Recorded correspondences with known extrinsics: `meta.json` and `pairs/NNNN.csv`.
//!
//! `meta.json`: intrinsics and lens of both cameras (px, OpenCV's order), image size, `R` and unit
//! `t` of `p_r = R p_l + t`. A pair file: columns `ul,vl,ur,vr,score` and, optionally, `step` (the
//! matcher's grid), in px of the images as they are, before undistortion. Where the rig moves,
//! `rigs.csv` has that of each pair.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stereo_selfcal::{
    Calibration, Camera, Cameras, Correspondence, Extrinsics, Fisheye, Intrinsics, Lens,
    LensCorrection, RadialTangential, Rational, Scalar,
};

use super::geometry::{Rows, matrix};
use super::pairs_folder::PairsFolder;
use super::rigs::{self, Rig};

/// A rig as `meta.json` has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Left camera matrix, px.
    #[serde(rename = "K_l")]
    pub k_l: Rows,
    /// Right camera matrix, px.
    #[serde(rename = "K_r")]
    pub k_r: Rows,
    /// Left lens: `k1 k2 p1 p2 k3`, `k1 k2 k3 k4` of a fisheye, or `k1 k2 p1 p2 k3 k4 k5 k6` of a rational lens.
    pub dist_l: Vec<f64>,
    /// Right lens.
    pub dist_r: Vec<f64>,
    /// Which lens model the coefficients are of.
    #[serde(default, skip_serializing_if = "LensModel::is_default")]
    pub lens: LensModel,
    /// Image width, px.
    pub width: u16,
    /// Image height, px.
    pub height: u16,
    /// Rotation, left to right; of the last pair, where the rig moves. All zero, as `t`, where no reference
    /// is known: both are absent from the file.
    #[serde(rename = "R", default)]
    pub r: Rows,
    /// Unit baseline direction, right camera frame; of the last pair, where the rig moves.
    #[serde(default)]
    pub t: [f64; 3],
    /// Length of the baseline, m, where it is known.
    pub baseline_m: Option<f64>,
    /// Where the data come from.
    #[serde(default)]
    pub source: String,
    /// Under which licence.
    #[serde(default)]
    pub license: String,
    /// Standard error of `R` for these intrinsics, degrees.
    #[serde(rename = "gt_sigma_R_given_K_deg", skip_serializing_if = "Option::is_none")]
    pub sigma_r_deg: Option<f64>,
    /// Standard error of `t` for these intrinsics, degrees.
    #[serde(rename = "gt_sigma_t_given_K_deg", skip_serializing_if = "Option::is_none")]
    pub sigma_t_deg: Option<f64>,
    /// All other keys of the file.
    #[serde(flatten)]
    pub other: serde_json::Map<String, serde_json::Value>,
}

impl Meta {
    /// Reads a `meta.json`, that of a folder, or that of the shipped set of that name.
    ///
    /// # Errors
    /// Names the file.
    pub fn find(place: &Path) -> Result<Self> {
        if place.is_file() { Self::read(place) } else { Ok(Dataset::find(place)?.meta) }
    }

    fn read(path: &Path) -> Result<Self> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("cannot understand {}", path.display()))
    }

    /// Both cameras.
    ///
    /// # Errors
    /// Names the intrinsics or lens coefficients that are not valid.
    pub fn cameras<T: Scalar>(&self) -> Result<Cameras<T>> {
        let camera = |k: &Rows, dist: &[f64], side: &str| {
            camera(k, dist, self.lens, [self.width, self.height])
                .with_context(|| format!("{side} camera"))
        };
        Ok(Cameras {
            left: camera(&self.k_l, &self.dist_l, "left")?,
            right: camera(&self.k_r, &self.dist_r, "right")?,
        })
    }

    /// The rig with the right lens model corrected, as [`Cameras::corrected`] does it.
    #[must_use]
    pub fn corrected(&self, correction: &LensCorrection<f64>) -> Self {
        let mut meta = self.clone();
        if correction.is_none() {
            return meta;
        }
        let [[fx, ..], [_, fy, _], _] = &mut meta.k_r;
        (*fx, *fy) = (*fx * (1.0 + correction.focal), *fy * (1.0 + correction.focal));
        // A pinhole may come with any number of zeros.
        if meta.lens == LensModel::RadialTangential && meta.dist_r.iter().all(|&k| k == 0.0) {
            meta.dist_r = vec![0.0; 5];
        }
        match (meta.lens, meta.dist_r.as_mut_slice()) {
            (LensModel::Rational, [k1, k2, _, _, k3, k4, k5, _]) => {
                *k1 += correction.k1;
                *k2 += correction.k1 * *k4;
                *k3 += correction.k1 * *k5;
            }
            (_, [k1, ..]) => *k1 += correction.k1,
            _ => (),
        }
        meta
    }

    /// Whether `R` and `t` are known.
    #[must_use]
    pub fn has_reference(&self) -> bool {
        self.r.iter().flatten().chain(&self.t).any(|&x| x != 0.0)
    }

    /// `R` and unit `t`.
    ///
    /// # Errors
    /// If they are not known, or not those of a stereo rig.
    pub fn extrinsics<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        ensure!(self.has_reference(), "no reference: meta.json has no R and t");
        let r = matrix(&self.r).map(T::lit);
        let t = Vector3::from(self.t).map(T::lit);
        Extrinsics::try_new(&r, &t).context("extrinsics of the data set")
    }
}

/// Lens model of a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LensModel {
    /// `k1 k2 p1 p2 k3`; all zero is a pinhole.
    #[default]
    RadialTangential,
    /// `k1 k2 k3 k4`.
    Fisheye,
    /// `k1 k2 p1 p2 k3 k4 k5 k6`.
    Rational,
}

impl LensModel {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// One correspondence, px of the images as they are.
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
    /// Step of the matcher's grid, px; 0 where the coordinates are continuous.
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

/// A rig and its pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Short name: that of the folder or of the generated scene.
    pub name: String,
    /// The rig.
    pub meta: Meta,
    /// Correspondences, pair by pair.
    pub pairs: Vec<Vec<Match>>,
    /// The rig of each pair; empty where it does not move.
    pub rigs: Vec<Rig>,
}

impl Dataset {
    /// Folder of the sets that come with the project.
    #[must_use]
    pub fn shipped() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("data")
    }

    /// Names of the sets that come with the project.
    pub const SHIPPED: [&str; 4] =
        ["opencv_chess_corners", "opencv_chess_sift", "motorcycle_sift", "aloe_sift"];

    /// Reads a folder, or the shipped set of that name if there is no such folder.
    ///
    /// # Errors
    /// As [`Dataset::load`], with the shipped names where nothing was found.
    pub fn find(place: &Path) -> Result<Self> {
        let name = place.to_str().filter(|name| Self::SHIPPED.contains(name));
        match name {
            Some(name) if !place.exists() => Self::load(&Self::shipped().join(name)),
            _ if !place.exists() => bail!(
                "{} does not exist, and is none of the shipped sets ({})",
                place.display(),
                Self::SHIPPED.join(", ")
            ),
            _ => Self::load(place),
        }
    }

    /// Reads a folder; pairs in the order of their file names.
    ///
    /// # Errors
    /// Names the file, and the line where there is one.
    pub fn load(dir: &Path) -> Result<Self> {
        let meta = Meta::read(&dir.join("meta.json"))
            .with_context(|| format!("{} is not a data set", dir.display()))?;
        let pairs_dir = dir.join("pairs");
        let mut files: Vec<PathBuf> = fs::read_dir(&pairs_dir)
            .with_context(|| format!("cannot list {}", pairs_dir.display()))?
            .map(|entry| entry.map(|e| e.path()))
            .collect::<std::io::Result<_>>()?;
        files.retain(|path| path.extension().is_some_and(|e| e == "csv"));
        files.sort();
        ensure!(!files.is_empty(), "no pair files (*.csv) in {}", pairs_dir.display());
        let pairs = files.iter().map(|path| read_pair(path)).collect::<Result<_>>()?;
        let rigs = rigs::read(dir, files.len())?;
        let name = dir.file_name().unwrap_or(dir.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, meta, pairs, rigs })
    }

    /// Writes a folder that [`Dataset::load`] reads back. The folder must not exist, or be empty.
    ///
    /// # Errors
    /// Names the file.
    pub fn save(&self, dir: &Path) -> Result<()> {
        let mut folder = PairsFolder::begin(dir, &self.meta)?;
        for pair in &self.pairs {
            folder.push(pair)?;
        }
        rigs::write(dir, &self.rigs)
    }

    /// Both cameras.
    ///
    /// # Errors
    /// As [`Meta::cameras`].
    pub fn cameras<T: Scalar>(&self) -> Result<Cameras<T>> {
        self.meta.cameras()
    }

    /// Extrinsics with the cameras that they belong to.
    ///
    /// # Errors
    /// As [`Meta::cameras`].
    pub fn calibration(
        &self,
        extrinsics: &Extrinsics<f64>,
        correction: &LensCorrection<f64>,
    ) -> Result<Calibration<f64>> {
        let cameras = self.meta.corrected(correction).cameras()?;
        Ok(Calibration { cameras, extrinsics: *extrinsics })
    }

    /// True extrinsics of the data set; of the last pair, where the rig moves.
    ///
    /// # Errors
    /// As [`Meta::extrinsics`].
    pub fn truth<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        self.meta.extrinsics()
    }

    /// The truth of each pair; empty where the rig does not move.
    ///
    /// # Errors
    /// Names the pair whose rig is not a stereo rig.
    pub fn truths(&self) -> Result<Vec<Extrinsics<f64>>> {
        let truth =
            |(i, rig): (usize, &Rig)| rig.extrinsics().with_context(|| format!("rig of pair {i}"));
        self.rigs.iter().enumerate().map(truth).collect()
    }
}

fn camera<T: Scalar>(
    k: &Rows,
    dist: &[f64],
    model: LensModel,
    size: [u16; 2],
) -> Result<Camera<T>> {
    let [[fx, skew, cx], [zero, fy, cy], bottom] = *k;
    ensure!(
        (skew, zero, bottom) == (0.0, 0.0, [0.0, 0.0, 1.0]),
        "K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]: skew is not supported"
    );
    let lens = match model {
        _ if dist.iter().all(|&k| k == 0.0) && model == LensModel::RadialTangential => {
            Lens::Pinhole
        }
        LensModel::RadialTangential => {
            ensure!(
                matches!(dist.len(), 4 | 5),
                "{} lens coefficients: k1 k2 p1 p2 [k3] are handled",
                dist.len()
            );
            let coefficient = |i: usize| T::lit(dist.get(i).copied().unwrap_or(0.0));
            Lens::RadialTangential(RadialTangential::try_new(std::array::from_fn(coefficient))?)
        }
        LensModel::Fisheye => {
            let coefficients: [f64; 4] = dist
                .try_into()
                .with_context(|| format!("{} lens coefficients: a fisheye has 4", dist.len()))?;
            Lens::Fisheye(Fisheye::try_new(coefficients.map(T::lit))?)
        }
        LensModel::Rational => {
            let coefficients: [f64; 8] = dist.try_into().with_context(|| {
                format!("{} lens coefficients: a rational lens has 8", dist.len())
            })?;
            Lens::Rational(Rational::try_new(coefficients.map(T::lit))?)
        }
    };
    let intrinsics =
        Intrinsics { focal: [fx, fy].map(T::lit), principal: [cx, cy].map(T::lit), size };
    Ok(Camera::try_new(intrinsics, lens)?)
}

fn read_pair(path: &Path) -> Result<Vec<Match>> {
    let read = || csv::Reader::from_path(path)?.into_deserialize().collect();
    let rows: Result<Vec<Match>, csv::Error> = read();
    rows.with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_saved_loads_back_equal_and_nothing_is_overwritten() {
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
        let fisheye = [0.01, -0.02, 0.0, 0.0].to_vec();
        let fisheye = Meta {
            dist_l: fisheye.clone(),
            dist_r: fisheye,
            lens: LensModel::Fisheye,
            ..radial.clone()
        };
        let rational = [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2].to_vec();
        let rational = Meta {
            dist_l: rational.clone(),
            dist_r: rational,
            lens: LensModel::Rational,
            ..radial.clone()
        };
        for meta in [radial, pinhole, fisheye, rational] {
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
        let error = format!("{:#}", read_pair(&path).unwrap_err());
        assert!(error.contains("0007.csv") && error.contains("line: 3"), "{error}");
    }
}
