//! The common part of the formats: two cameras, the pose between them, and their checks.

use std::fmt::Display;

use anyhow::{Context, Result, anyhow, bail, ensure};
use nalgebra::{Matrix3, Rotation3, Vector3};
use stereo_selfcal::Extrinsics;

use super::node::Value;
use super::rigid::Rigid;
use super::scale;
use crate::data::{LensModel, Meta, Rows, WrongSign, check_camera_matrix, matrix, rows};

/// Largest element of `R^T R - 1` of an `R` with eight digits or more.
const ROUNDED: f64 = 1e-6;

/// Number of coefficients of a rational lens.
const RATIONAL: usize = 8;

/// Values that files may lack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknowns {
    /// Width and height of the left and the right images, px: OpenCV's `stereo_calib.cpp` does not write them.
    pub sizes: Option<[[u16; 2]; 2]>,
    /// Length of the unit of `T`, m: the unit of the calibration board.
    pub unit_m: f64,
    /// Numbers of the left and right camera in a file with more than two.
    pub cameras: Option<[u8; 2]>,
}

impl Default for Unknowns {
    fn default() -> Self {
        Self { sizes: None, unit_m: 1.0, cameras: None }
    }
}

impl Unknowns {
    /// The numbers of the left and the right camera; `usual` by default.
    pub(super) fn cameras_or(self, usual: [u8; 2]) -> [u8; 2] {
        self.cameras.unwrap_or(usual)
    }

    /// Whether the first camera of a file of two is the right one.
    pub(super) fn are_exchanged(self, place: &impl Display) -> Result<bool> {
        match self.cameras {
            None | Some([0, 1]) => Ok(false),
            Some([1, 0]) => Ok(true),
            Some([left, right]) => {
                bail!("{place}: --cameras {left},{right}: of two cameras, expected 0,1 or 1,0")
            }
        }
    }

    /// The size of a side's images, from the file or from the arguments.
    pub(super) fn size(self, side: usize, own: Option<[u16; 2]>, place: &str) -> Result<[u16; 2]> {
        own.or(self.sizes.map(|sizes| sizes[side])).with_context(|| {
            format!("{place}: the file lacks the size of the images: give it (--size W,H)")
        })
    }
}

/// The chosen two of several cameras, or the only two.
pub(super) fn two<'a, T>(all: &'a [T], unknowns: Unknowns, place: &str) -> Result<[&'a T; 2]> {
    let chosen = match (unknowns.cameras, all) {
        (None, [left, right]) => Some([left, right]),
        (None, _) => None,
        (Some([left, right]), _) => {
            all.get(usize::from(left)).zip(all.get(usize::from(right))).map(<[&T; 2]>::from)
        }
    };
    chosen.with_context(|| {
        let (count, last) = (all.len(), all.len().saturating_sub(1));
        format!("{place}: {count} cameras: choose the left and the right one from 0 to {last} (--cameras)")
    })
}

/// The camera of the wanted size in a file with several sizes, or the only one.
pub(super) fn of_size<'a, T>(
    all: &'a [T],
    size_of: impl Fn(&T) -> [u16; 2],
    wanted: Option<[u16; 2]>,
    place: &str,
) -> Result<&'a T> {
    let found = match (all, wanted) {
        ([one], None) => Some(one),
        (_, Some(size)) => all.iter().find(|one| size_of(one) == size),
        _ => None,
    };
    found.with_context(|| {
        let sizes = all.iter().map(|one| size_of(one).map(|n| n.to_string()).join(","));
        let sizes = sizes.collect::<Vec<_>>().join(" or ");
        format!("{place}: intrinsics of several sizes: choose one with --size {sizes}")
    })
}

/// One camera of a rig.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    /// Camera matrix, px.
    pub(super) k: Rows,
    /// Lens model.
    pub(super) lens: LensModel,
    /// Its coefficients, OpenCV's order.
    pub(super) dist: Vec<f64>,
    /// Width and height, px.
    pub(super) size: [u16; 2],
}

impl View {
    /// A camera without distortion.
    pub(super) fn pinhole(k: Rows, size: [u16; 2]) -> Self {
        Self { k, lens: LensModel::RadialTangential, dist: vec![0.0; 5], size }
    }

    /// A camera with the given coefficients; eight of them make the lens rational.
    ///
    /// * `given`: the coefficients; `None` if the file has no such key.
    pub(super) fn of(
        k: Rows,
        lens: LensModel,
        given: Option<&Value>,
        size: [u16; 2],
    ) -> Result<Self> {
        let Some(given) = given else { return Self::with(k, lens, &[], size) };
        Self::with(k, lens, &given.numbers()?, size).map_err(|why| given.refuse(why))
    }

    /// A camera of `fx fy cx cy`, which are checked. The error does not name file and key.
    pub(super) fn try_new(
        k: [f64; 4],
        lens: LensModel,
        given: &[f64],
        size: [u16; 2],
    ) -> Result<Self> {
        let k = camera_matrix(k);
        check_camera_matrix(&k)?;
        Self::with(k, lens, given, size)
    }

    /// As [`Self::of`], from numbers. The error does not name file and key.
    pub(super) fn with(k: Rows, lens: LensModel, given: &[f64], size: [u16; 2]) -> Result<Self> {
        let dist = coefficients(lens, given)?;
        let lens = if dist.len() == RATIONAL { LensModel::Rational } else { lens };
        Ok(Self { k, lens, dist, size })
    }
}

/// The camera matrix of 3 x 3 numbers, or of `fx fy cx cy`.
pub(super) fn intrinsics(value: &Value) -> Result<Rows> {
    let numbers = value.numbers()?;
    let k = match *numbers.as_slice() {
        [fx, fy, cx, cy] => camera_matrix([fx, fy, cx, cy]),
        _ => value.square()?,
    };
    check_camera_matrix(&k).map_err(|why| value.refuse(why))?;
    Ok(k)
}

/// Names of a fisheye in the files of all tools: letters and digits alone.
const FISHEYE: [&str; 5] =
    ["equidistant", "fisheye", "kannalabrandt", "kannalabrandt4", "fisheyeequidistant4"];

/// Names of other lenses. The number of coefficients, five or eight, tells a radial-tangential lens from a rational one.
#[rustfmt::skip]
const RADIAL: [&str; 12] = [
    "", "none", "pinhole", "plumbbob", "rational", "rationalpolynomial", "radtan", "radialtangential", "radialtangential8",
    "brownconrady", "pinholeradtan5", "pinholeradtan8",
];

/// The lens by its name in any spelling, from the first of these keys; a pinhole without a name.
pub(super) fn lens_at(of: &Value, keys: &[&str]) -> Result<LensModel> {
    let Some(model) = of.get(keys) else { return Ok(LensModel::RadialTangential) };
    let name = model.text().to_lowercase();
    let name: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
    match name.as_str() {
        fisheye if FISHEYE.contains(&fisheye) => Ok(LensModel::Fisheye),
        radial if RADIAL.contains(&radial) => Ok(LensModel::RadialTangential),
        _ => Err(model.refuse(
            "expected radtan (plumb_bob, brown_conrady), rational_polynomial or equidistant (fisheye, kannala_brandt4): \
             calibrate with one of them",
        )),
    }
}

/// The coefficients of a file that has a key for each, OpenCV's order.
pub(super) fn coefficient_keys(lens: LensModel) -> &'static [&'static str] {
    match lens {
        LensModel::Fisheye => &["k1", "k2", "k3", "k4"],
        _ => &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"],
    }
}

/// `R` and `b t` of two rectifying rotations.
///
/// * `[x, y]`: position of the right camera along the first and the second axis of the rectified frame; `b t` is in its
///   unit.
pub(super) fn of_rectification([r_l, r_r]: [&Matrix3<f64>; 2], [x, y]: [f64; 2]) -> Rigid {
    let t = -(r_r.row(0).transpose() * x + r_r.row(1).transpose() * y);
    Rigid { r: r_r.transpose() * r_l, t }
}

/// A rotation of 3 x 3 numbers, or of 3: its axis times its angle, rad.
pub(super) fn rotation(value: &Value) -> Result<Matrix3<f64>> {
    let r = match *value.numbers()?.as_slice() {
        [x, y, z] => *Rotation3::new(Vector3::new(x, y, z)).matrix(),
        _ => matrix(&value.square()?),
    };
    Rigid { r, ..Rigid::NONE }.check().map_err(|why| value.refuse(why))?;
    Ok(r)
}

/// `p_r = R p_l + b t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) r: Rows,
    /// Unit length.
    pub(super) t: [f64; 3],
    /// `None` if unknown.
    pub(super) baseline_m: Option<f64>,
    /// Largest element of `R^T R - 1` of the given `R`, if its writer rounded it, so that it was made orthonormal.
    pub(super) rounded: Option<f64>,
}

impl Pose {
    /// The pose of `R` and `T = b t`. `place`: file and key of both, for errors.
    pub(super) fn of(rigid: &Rigid, place: &str) -> Result<Self> {
        let read = || -> Result<Self> {
            let (t, baseline_m) = scale::split(rigid.t.into())?;
            let mut pose = Self { r: rows(&rigid.r), t, baseline_m, rounded: None };
            let exact = pose.extrinsics()?;
            let off = (rigid.r.transpose() * rigid.r - Matrix3::identity()).amax();
            if off > ROUNDED {
                (pose.r, pose.rounded) = (rows(exact.rotation().matrix()), Some(off));
            }
            Ok(pose)
        };
        read().with_context(|| place.to_owned())
    }

    /// The pose with its baseline converted to metres from units of `unit_m` metres. A length of 1 means an unknown
    /// baseline only in metres.
    pub(super) fn in_unit(mut self, unit_m: f64) -> Result<Self> {
        ensure!(
            unit_m.is_normal() && unit_m > 0.0,
            "--unit {unit_m}: the unit of T must be longer than 0 m"
        );
        if unit_m.to_bits() != 1.0_f64.to_bits() {
            self.baseline_m = Some(self.baseline_m.unwrap_or(1.0) * unit_m);
        }
        Ok(self)
    }

    /// Conversion to the core's type.
    pub(super) fn extrinsics(&self) -> Result<Extrinsics<f64>> {
        let rigid = Rigid { r: matrix(&self.r), t: self.t.into() };
        rigid.check()?;
        WrongSign::check(&self.r, self.t)?;
        Extrinsics::try_new(&rigid.r, &rigid.t).map_err(|why| {
            let [x, y, z] = self.t;
            anyhow!("t = ({x}, {y}, {z}): {why}; expected cameras beside or above each other")
        })
    }
}

/// A rig from its parts.
pub(super) fn meta([left, right]: [View; 2], pose: &Pose, source: String) -> Result<Meta> {
    let mut meta = Meta {
        dist_l: left.dist,
        dist_r: right.dist,
        lens: left.lens,
        r: pose.r,
        t: pose.t,
        baseline_m: pose.baseline_m,
        other: [(Meta::CALIBRATED.to_owned(), true.into())].into_iter().collect(),
        ..Meta::side_by_side([left.k, right.k], [left.size, right.size], source)
    };
    meta.other.extend(pose.rounded.map(|off| (Meta::ROUNDED.to_owned(), off.into())));
    meta.set_right(right.lens, right.size);
    check(&meta)?;
    Ok(meta)
}

/// Checks that the core accepts the rig, and that a known baseline is above 0.
pub(super) fn check(meta: &Meta) -> Result<()> {
    meta.cameras::<f64>()?;
    Pose { r: meta.r, t: meta.t, baseline_m: meta.baseline_m, rounded: None }.extrinsics()?;
    if let Some(b) = meta.baseline_m {
        ensure!(b.is_normal() && b > 0.0, "the baseline must be longer than 0 m, not {b}");
    }
    Ok(())
}

/// Coefficients in our form: five for a radial-tangential lens, eight for a rational one, four for a fisheye.
fn coefficients(lens: LensModel, given: &[f64]) -> Result<Vec<f64>> {
    let len = given.len();
    if lens == LensModel::Fisheye {
        // Some drivers add a zero coefficient, which other lenses use.
        let (four, rest) = given.split_at(len.min(4));
        let whole = four.len() == 4 && rest.iter().all(|k| *k == 0.0);
        ensure!(whole, "{len} lens coefficients: expected the 4 of a fisheye, k1 k2 k3 k4");
        return Ok(four.to_vec());
    }
    ensure!(
        matches!(len, 0 | 1 | 2 | 4 | 5 | 8 | 12 | 14),
        "{len} lens coefficients: expected k1 k2 p1 p2 [k3 [k4 k5 k6]]"
    );
    let names = ["s1", "s2", "s3", "s4", "tau_x", "tau_y"];
    for (name, k) in names.iter().zip(given.iter().skip(RATIONAL)) {
        let what = if name.starts_with('s') { "the thin prism" } else { "the tilt of the sensor" };
        ensure!(
            *k == 0.0,
            "{what}, {name} = {k}, is not handled: calibrate without it, with k1 k2 p1 p2 k3 or those and k4 k5 k6"
        );
    }
    let used = given.iter().take(RATIONAL).skip(5).any(|k| *k != 0.0);
    let held = if lens == LensModel::Rational || used { RATIONAL } else { 5 };
    let mut kept: Vec<f64> = given.iter().take(held).copied().collect();
    kept.resize(held, 0.0);
    Ok(kept)
}

/// `K` of focal lengths and principal point, px.
pub(super) fn camera_matrix([fx, fy, cx, cy]: [f64; 4]) -> Rows {
    [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
}

/// Comment in a file whose baseline length is unknown.
pub(super) const NO_SCALE: &str = "# The length of the baseline is unknown: it is written as 1. Multiply it by the length in metres.\n";

/// Comment on the number after it, if the lenses have an apparent yaw.
pub(super) const LENS_YAW: &str = "\
# lens_yaw, rad: after rectification the right row is below the left one by lens_yaw x y, (x, y): left ray at unit depth,
# x = (u - cx) / fx, y = (v - cy) / fy of P. No rotation removes it. A look-up table does: for the rectified left pixel
# (u, v) take the source pixel of (u, v - fy lens_yaw x y). A table without it leaves these rows; depth is the same.
";

/// The apparent yaw of the lenses as a comment, for a format without a key for it; empty without apparent yaw.
pub(super) fn lens_yaw_comment(meta: &Meta) -> String {
    meta.lens_yaw().map_or_else(String::new, |a| format!("{LENS_YAW}# lens_yaw: {a}\n"))
}
