//! The common part of the formats: two cameras, a pose between them, and the checks of both.

use anyhow::{Context, Result, ensure};
use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::Extrinsics;

use super::scale;
use host_tests::data::WrongSign;
use host_tests::data::{LensModel, Meta};
use host_tests::data::{Rows, matrix};

/// How far `R^T R` may be from the identity, in any element: a matrix of three decimals passes.
const ROTATION: f64 = 2e-3;

/// Number of coefficients of a rational lens.
const RATIONAL: usize = 8;

/// Values that files may lack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknowns {
    /// Image width and height, px: OpenCV's `stereo_calib.cpp` does not write them.
    pub size: Option<[u16; 2]>,
    /// Length of OpenCV's unit of `T`, m: that of the chessboard it was calibrated from.
    pub unit_m: f64,
}

impl Default for Unknowns {
    fn default() -> Self {
        Self { size: None, unit_m: 1.0 }
    }
}

/// One camera of a rig.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    /// Camera matrix, px.
    pub(super) k: Rows,
    /// Which lens.
    pub(super) lens: LensModel,
    /// Its coefficients, OpenCV's order.
    pub(super) dist: Vec<f64>,
    /// Width and height, px.
    pub(super) size: [u16; 2],
}

impl View {
    /// A camera with the coefficients as given: those of a rational lens make it one.
    pub(super) fn of(k: Rows, lens: LensModel, given: &[f64], size: [u16; 2]) -> Result<Self> {
        let dist = coefficients(lens, given)?;
        let lens = if dist.len() == RATIONAL { LensModel::Rational } else { lens };
        Ok(Self { k, lens, dist, size })
    }

    /// The same camera as a rational lens, if it is a radial-tangential one and the other is rational.
    fn like(mut self, other: LensModel) -> Self {
        if (self.lens, other) == (LensModel::RadialTangential, LensModel::Rational) {
            self.lens = LensModel::Rational;
            self.dist.resize(RATIONAL, 0.0);
        }
        self
    }
}

/// `p_r = R p_l + b t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) r: Rows,
    /// Unit length.
    pub(super) t: [f64; 3],
    /// `None`: not known.
    pub(super) baseline_m: Option<f64>,
}

impl Pose {
    /// From `R` and `T = b t`.
    pub(super) fn of(r: Rows, scaled: [f64; 3]) -> Result<Self> {
        let (t, baseline_m) = scale::split(scaled)?;
        let pose = Self { r, t, baseline_m };
        pose.extrinsics()?;
        Ok(pose)
    }

    /// Conversion to the core's type.
    pub(super) fn extrinsics(&self) -> Result<Extrinsics<f64>> {
        let r = matrix(&self.r);
        let off = (r.transpose() * r - Matrix3::identity()).amax();
        ensure!(
            off <= ROTATION && r.determinant() > 0.0,
            "R is not a rotation: R^T R is off the identity by {off:.1e}, or it is a reflection"
        );
        WrongSign::check(self.t)?;
        Ok(Extrinsics::try_new(&r, &Vector3::from(self.t))?)
    }
}

/// A rig from its parts.
pub(super) fn meta([left, right]: [View; 2], pose: &Pose, source: String) -> Result<Meta> {
    let lenses = [left.lens, right.lens];
    let (left, right) = (left.like(lenses[1]), right.like(lenses[0]));
    ensure!(
        left.lens == right.lens,
        "both cameras must have lenses of the same model: left {:?}, right {:?}",
        left.lens,
        right.lens
    );
    ensure!(
        left.size == right.size,
        "both images must be of the same size: left {:?}, right {:?}",
        left.size,
        right.size
    );
    let [width, height] = left.size;
    let meta = Meta {
        k_l: left.k,
        k_r: right.k,
        dist_l: left.dist,
        dist_r: right.dist,
        lens: left.lens,
        width,
        height,
        r: pose.r,
        t: pose.t,
        baseline_m: pose.baseline_m,
        source,
        license: String::new(),
        sigma_r_deg: None,
        sigma_t_deg: None,
        other: serde_json::Map::new(),
    };
    check(&meta)?;
    Ok(meta)
}

/// Whether the core would take it.
pub(super) fn check(meta: &Meta) -> Result<()> {
    meta.cameras::<f64>()?;
    Pose { r: meta.r, t: meta.t, baseline_m: meta.baseline_m }.extrinsics()?;
    if let Some(b) = meta.baseline_m {
        ensure!(b.is_normal() && b > 0.0, "the baseline must be longer than 0 m, not {b}");
    }
    Ok(())
}

/// Coefficients as we hold them: five of a radial-tangential lens, eight of a rational one, four of a fisheye.
fn coefficients(lens: LensModel, given: &[f64]) -> Result<Vec<f64>> {
    if lens == LensModel::Fisheye {
        ensure!(given.len() == 4, "{} lens coefficients: a fisheye has 4", given.len());
        return Ok(given.to_vec());
    }
    ensure!(
        matches!(given.len(), 0 | 4 | 5 | 8 | 12 | 14),
        "{} lens coefficients: k1 k2 p1 p2 [k3 [k4 k5 k6]] are expected",
        given.len()
    );
    let used = |from: usize, to: usize| given.iter().take(to).skip(from).any(|k| *k != 0.0);
    ensure!(!used(8, 12), "the thin prism coefficients s1 s2 s3 s4 are not 0: {ADVICE}");
    ensure!(!used(12, 14), "the tilt of the sensor, tau_x tau_y, is not 0: {ADVICE}");
    let held = if lens == LensModel::Rational || used(5, 8) { RATIONAL } else { 5 };
    let mut kept: Vec<f64> = given.iter().take(held).copied().collect();
    kept.resize(held, 0.0);
    Ok(kept)
}

/// Advice for a lens that the core has no model of.
const ADVICE: &str = "calibrate without them, with k1 k2 p1 p2 k3 or those and k4 k5 k6";

/// `K` of focal lengths and principal point, px.
pub(super) fn camera_matrix([fx, fy, cx, cy]: [f64; 4]) -> Rows {
    [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
}

/// Row-major numbers as rows.
pub(super) fn square(numbers: &[f64]) -> Result<Rows> {
    let [a, b, c, d, e, f, g, h, i]: [f64; 9] = numbers
        .try_into()
        .with_context(|| format!("{} numbers: 3 x 3 are expected", numbers.len()))?;
    Ok([[a, b, c], [d, e, f], [g, h, i]])
}

/// Comment of a file where the baseline's length is not known.
pub(super) const NO_SCALE: &str = "# The length of the baseline is not known: it is written as 1. Multiply it by the length in metres.\n";

/// Comment on the number after it, where the lenses have an apparent yaw.
pub(super) const LENS_YAW: &str = "\
# lens_yaw, rad: after rectification the right row is below the left one by lens_yaw x y, (x, y): left ray at unit depth,
# x = (u - cx) / fx, y = (v - cy) / fy of P. No rotation removes it. A look-up table does: for the rectified left pixel
# (u, v) take the source pixel of (u, v - fy lens_yaw x y). A table without it leaves these rows; depth is right with both.
";

/// The apparent yaw of the lenses as a comment, for a format that has no key for it; empty where there is none.
pub(super) fn lens_yaw_comment(meta: &Meta) -> String {
    meta.lens_yaw().map_or_else(String::new, |a| format!("{LENS_YAW}# lens_yaw: {a}\n"))
}
