//! A rig in the form of a data set's `meta.json`.

use std::path::Path;

use anyhow::{Context, Error, Result, anyhow, ensure};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stereo_selfcal::geometry::{Fisheye, LensCorrection, RadialTangential, Rational};
use stereo_selfcal::{Calibration, Camera, Cameras, Extrinsics, Intrinsics, Lens, Scalar};

use super::geometry::{Rows, matrix};
use super::sign::WrongSign;
use crate::bounded;

/// A rig in the form of `meta.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Left camera matrix, px.
    #[serde(rename = "K_l")]
    pub k_l: Rows,
    /// Right camera matrix, px.
    #[serde(rename = "K_r")]
    pub k_r: Rows,
    /// Coefficients of the left lens: `k1 k2 p1 p2 [k3]`, `k1 k2 k3 k4` of a fisheye, or `k1 k2 p1 p2 k3 k4 k5 k6` of a
    /// rational lens.
    pub dist_l: Vec<f64>,
    /// Coefficients of the right lens.
    pub dist_r: Vec<f64>,
    /// Lens model of the coefficients.
    #[serde(default, skip_serializing_if = "LensModel::is_default")]
    pub lens: LensModel,
    /// Lens model of the right camera, if it differs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens_r: Option<LensModel>,
    /// Image width, px.
    pub width: u16,
    /// Image height, px.
    pub height: u16,
    /// Width and height of the right image, px, if they differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_r: Option<[u16; 2]>,
    /// Rotation, left to right camera frame; if the rig moves, that of the last pair. Without a known reference `R` and
    /// `t` are zero, and may be absent from the file.
    #[serde(rename = "R", default)]
    pub r: Rows,
    /// Unit baseline direction, right camera frame; if the rig moves, that of the last pair.
    #[serde(default)]
    pub t: [f64; 3],
    /// Length of the baseline, m, if known.
    pub baseline_m: Option<f64>,
    /// Source of the data.
    #[serde(default)]
    pub source: String,
    /// Licence of the data.
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
    /// Two pinholes with these camera matrices and image sizes, side by side: `R = I`, `t = (-1, 0, 0)`. Nothing else is
    /// known.
    pub fn side_by_side(
        [k_l, k_r]: [Rows; 2],
        [left, right]: [[u16; 2]; 2],
        source: String,
    ) -> Self {
        Self {
            k_l,
            k_r,
            dist_l: vec![0.0; 5],
            dist_r: vec![0.0; 5],
            lens: LensModel::RadialTangential,
            lens_r: None,
            width: left[0],
            height: left[1],
            size_r: (right != left).then_some(right),
            r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            t: [-1.0, 0.0, 0.0],
            baseline_m: None,
            source,
            license: String::new(),
            sigma_r_deg: None,
            sigma_t_deg: None,
            other: serde_json::Map::new(),
        }
    }

    /// Key in [`Meta::other`]: standard deviation of the yaw of the extrinsics that a run starts from, degrees; null if
    /// they are a guess.
    pub const FACTORY_YAW_SD: &str = "factory_yaw_sd_deg";

    /// Key in [`Meta::other`]: apparent yaw `a` of the lenses, rad. The right row is below the left one by `a x y`,
    /// where `(x, y)` is the rectified left ray at unit depth. Extrinsics cannot remove these row offsets. A rectifier
    /// with a look-up table can: for the rectified ray `(x, y)` it samples the left image at `(x, y - a x y)`.
    pub const LENS_YAW: &str = "lens_yaw";

    /// Value of [`Self::LENS_YAW`], rad; `None` if the key is absent, or the value is 0 or not a number.
    pub fn lens_yaw(&self) -> Option<f64> {
        self.other.get(Self::LENS_YAW)?.as_f64().filter(|a| *a != 0.0)
    }

    /// Reads a `meta.json`.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let bytes =
            bounded::bytes(path).with_context(|| format!("cannot read {}", path.display()))?;
        let read = || -> Result<Self> {
            let meta: Self = serde_json::from_slice(&bytes).map_err(|why| in_words(&why))?;
            meta.check_reference()?;
            Ok(meta)
        };
        read().with_context(|| format!("cannot understand {}", path.display()))
    }

    /// Checks that `R` and `t` are both known or both unknown, and that `t` follows the project's sign convention.
    fn check_reference(&self) -> Result<()> {
        let [r, t] = [self.r.as_flattened(), &self.t].map(|of| of.iter().any(|&x| x != 0.0));
        ensure!(t || !r, "R without t: a reference has both");
        ensure!(r || !t, "t without R: a reference has both");
        Ok(WrongSign::check(&self.r, self.t)?)
    }

    /// Key in [`Meta::other`]: largest element of `R^T R - 1` of the `R` in the file that was read, if its digits were few
    /// and it was made orthonormal.
    pub const ROUNDED: &str = "R_rounded_by";

    /// Key in [`Meta::other`]: whether the file has four coefficients of each lens and does not name the lens model.
    pub const UNNAMED_LENS: &str = "lens_not_named";

    /// Key in [`Meta::other`]: other formats whose keys the file has, too, which were not read.
    pub const UNREAD: &str = "also_keys_of";

    /// Key in [`Meta::other`]: keys of a file of no known format whose words told what they are.
    pub const TAKEN: &str = "keys_taken";

    /// Key in [`Meta::other`]: whether a calibration measured `R` and `t`, so that by default a run starts from them.
    /// Otherwise they are only the reference that a run is compared with.
    pub const CALIBRATED: &str = "calibrated";

    /// Whether a calibration measured `R` and `t`.
    pub fn is_calibrated(&self) -> bool {
        self.has_reference() && self.other.get(Self::CALIBRATED) == Some(&true.into())
    }

    /// Lens models, left and right.
    pub fn lenses(&self) -> [LensModel; 2] {
        [self.lens, self.lens_r.unwrap_or(self.lens)]
    }

    /// Width and height of the left and of the right image, px.
    pub fn sizes(&self) -> [[u16; 2]; 2] {
        let left = [self.width, self.height];
        [left, self.size_r.unwrap_or(left)]
    }

    /// Sets a lens model and a size for the right camera alone.
    pub fn set_right(&mut self, lens: LensModel, size: [u16; 2]) {
        self.lens_r = (lens != self.lens).then_some(lens);
        self.size_r = (size != [self.width, self.height]).then_some(size);
    }

    /// Both cameras.
    ///
    /// # Errors
    /// Names the intrinsics or lens coefficients that are not valid.
    pub fn cameras<T: Scalar>(&self) -> Result<Cameras<T>> {
        let ([lens_l, lens_r], [size_l, size_r]) = (self.lenses(), self.sizes());
        let of = |side, k, dist, lens, size| {
            camera(k, dist, lens, size).map_err(|why| refused(side, k, dist, size, &why))
        };
        let left = of("left", &self.k_l, &self.dist_l, lens_l, size_l)?;
        let right = of("right", &self.k_r, &self.dist_r, lens_r, size_r)?;
        Ok(Cameras { left, right })
    }

    /// A calibration: the extrinsics, and the cameras with a correction.
    pub fn calibration(
        &self,
        extrinsics: &Extrinsics<f64>,
        correction: &LensCorrection<f64>,
    ) -> Result<Calibration<f64>> {
        let cameras = self.corrected(correction).cameras()?;
        Ok(Calibration { cameras, extrinsics: *extrinsics, generation: 0 })
    }

    /// The rig with the right focal lengths and radial coefficients corrected as in [`Cameras::corrected`].
    pub fn corrected(&self, correction: &LensCorrection<f64>) -> Self {
        let mut meta = self.clone();
        if correction.is_none() {
            return meta;
        }
        let [[fx, ..], [_, fy, _], _] = &mut meta.k_r;
        (*fx, *fy) = (*fx * (1.0 + correction.focal), *fy * (1.0 + correction.focal));
        let [_, lens] = self.lenses();
        // A pinhole may have any number of coefficients, all 0.
        if lens == LensModel::RadialTangential && meta.dist_r.iter().all(|&k| k == 0.0) {
            meta.dist_r = vec![0.0; 5];
        }
        match (lens, meta.dist_r.as_mut_slice()) {
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

    /// Whether `R` and `t` are present, that is, not zero.
    pub fn has_reference(&self) -> bool {
        self.r.iter().flatten().chain(&self.t).any(|&x| x != 0.0)
    }

    /// `R` and unit `t`.
    ///
    /// # Errors
    /// If they are unknown, or do not describe a stereo rig.
    pub fn extrinsics<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        ensure!(self.has_reference(), "no reference: meta.json has no R and t");
        let r = matrix(&self.r).map(T::lit);
        let t = Vector3::from(self.t).map(T::lit);
        Extrinsics::try_new(&r, &t).context("extrinsics of the data set")
    }
}

/// A JSON error with the number types in words.
fn in_words(why: &serde_json::Error) -> Error {
    let numbers = why.to_string().replace("expected f64", "a number is expected");
    anyhow!(numbers.replace("expected u16", "a whole number from 0 to 65535 is expected"))
}

/// Lens model of a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LensModel {
    /// `k1 k2 p1 p2 [k3]`; if all are 0, the lens is a pinhole.
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

/// Checks that a matrix is a camera matrix `[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]` with `fx` and `fy` above 0.
///
/// # Errors
/// Says what is wrong with the matrix, and the remedy.
pub fn check_camera_matrix(k: &Rows) -> Result<()> {
    let [[fx, skew, _], [zero, fy, centre_v], bottom] = *k;
    ensure!(
        k.iter().flatten().any(|x| *x != 0.0),
        "K is all zeros: the camera was never calibrated; calibrate it"
    );
    ensure!(
        fx > 0.0 && fy > 0.0,
        "K has the focal lengths {fx} and {fy}: they must be above 0 px; calibrate the camera"
    );
    ensure!(
        !(skew == 0.0 && centre_v == 0.0 && bottom[0] > 0.0 && bottom[1] > 0.0),
        "K is transposed, as MATLAB has it: give the transposes of K and R, and subtract 1 from cx and cy, because \
         MATLAB counts pixels from 1"
    );
    ensure!(skew == 0.0, "K has the skew {skew}, which is not supported: calibrate without it");
    ensure!(
        (zero, bottom) == (0.0, [0.0, 0.0, 1.0]),
        "K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]: give it row by row"
    );
    Ok(())
}

/// An error that names the camera and shows its numbers.
fn refused(side: &str, k: &Rows, dist: &[f64], [width, height]: [u16; 2], why: &Error) -> Error {
    let [[fx, _, cx], [_, fy, cy], _] = *k;
    anyhow!(
        "{side} camera, fx {fx}, fy {fy}, cx {cx}, cy {cy}, lens coefficients {dist:?}, image size {width} x {height}: \
         {why:#}; compare these numbers with the calibration: order, units, size of the images"
    )
}

fn camera<T: Scalar>(
    k: &Rows,
    dist: &[f64],
    model: LensModel,
    size: [u16; 2],
) -> Result<Camera<T>> {
    check_camera_matrix(k)?;
    let [[fx, _, cx], [_, fy, cy], _] = *k;
    let lens = match model {
        _ if dist.iter().all(|&k| k == 0.0) && model == LensModel::RadialTangential => {
            Lens::Pinhole
        }
        LensModel::RadialTangential => {
            ensure!(
                matches!(dist.len(), 4 | 5),
                "{} lens coefficients: expected k1 k2 p1 p2 [k3]",
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
