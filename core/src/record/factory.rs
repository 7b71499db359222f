//! Calibration of a rig in production, as a record. Every estimate starts from it.

use super::codec::{Reader, Writer, seal};
use super::{FACTORY, OVERHEAD_BYTES, believe};
use crate::checksum;
use crate::error::{CameraError, ConfigError, RestoreError};
use crate::geometry::camera::{Camera, Intrinsics};
use crate::geometry::cameras::Cameras;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens::{Fisheye, Lens, RadialTangential};
use crate::geometry::rational::Rational;
use crate::scalar::Scalar;
use crate::thresholds::CALIBRATED_YAW_SD_RAD;

/// Length of a camera, bytes: focal lengths, principal point, size, lens and its coefficients, padded with zeros.
const CAMERA_BYTES: usize = 4 * 4 + 4 + 4 + 8 * 4;

/// Length of both cameras and of the extrinsics, bytes.
const RIG_BYTES: usize = 2 * CAMERA_BYTES + 12 * 4;

pub(crate) const BYTES: usize = OVERHEAD_BYTES + RIG_BYTES + 2 * 4;

const fn is_yaw_sd(rad: f32) -> bool {
    rad >= 1e-6 && rad <= 1.0
}

const fn is_baseline(metres: f32) -> bool {
    metres >= 1e-3 && metres <= 1e3
}

/// Cameras and extrinsics of a rig as it left the factory, `p_r = R p_l + t`, and the uncertainty of its calibration.
///
/// ```
/// # use stereo_selfcal::*;
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// # let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
/// # let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// # let cameras = Cameras { left: camera, right: camera };
/// let extrinsics = Extrinsics::<f32>::SIDE_BY_SIDE;
/// let made = FactoryCalibration::new(cameras, extrinsics).with_yaw_sd_rad(8e-4)?.with_baseline_m(0.12)?;
/// let record: [u8; FactoryCalibration::<f32>::BYTES] = made.to_record(); // into flash, once
/// let found = FactoryCalibration::<f32>::from_record(&record)?; // at each start
/// let calibrator = Calibrator::<f32, 256>::new(Config::robust(), &found);
/// # assert_eq!(found, made);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "Parts<T>", bound(deserialize = "T: Scalar + serde::Deserialize<'de>"))
)]
pub struct FactoryCalibration<T: Scalar> {
    /// Both cameras.
    pub cameras: Cameras<T>,
    /// `R`, `t` between them.
    pub extrinsics: Extrinsics<T>,
    pub(crate) yaw_sd_rad: Option<f32>,
    pub(crate) baseline_m: Option<f32>,
}

/// Unchecked fields from which a calibration is deserialised.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(bound = "T: Scalar + serde::Deserialize<'de>")]
struct Parts<T: Scalar> {
    cameras: Cameras<T>,
    extrinsics: Extrinsics<T>,
    yaw_sd_rad: Option<f32>,
    baseline_m: Option<f32>,
}

#[cfg(feature = "serde")]
impl<T: Scalar> TryFrom<Parts<T>> for FactoryCalibration<T> {
    type Error = ConfigError;

    fn try_from(parts: Parts<T>) -> Result<Self, ConfigError> {
        let made = Self::new(parts.cameras, parts.extrinsics).without_yaw();
        let made = parts.yaw_sd_rad.map_or(Ok(made), |rad| made.with_yaw_sd_rad(rad))?;
        parts.baseline_m.map_or(Ok(made), |metres| made.with_baseline_m(metres))
    }
}

impl<T: Scalar> FactoryCalibration<T> {
    /// Length of a record: 180 bytes.
    pub const BYTES: usize = BYTES;

    /// Returns a calibration in which the yaw of `R` has a standard deviation of 8.7e-4 rad (0.05 degrees), the value
    /// of a calibration with boards. The length of the baseline is not measured.
    #[must_use]
    pub const fn new(cameras: Cameras<T>, extrinsics: Extrinsics<T>) -> Self {
        Self { cameras, extrinsics, yaw_sd_rad: Some(CALIBRATED_YAW_SD_RAD), baseline_m: None }
    }

    /// Returns a guess: `R = I`, `t = (-1, 0, 0)`. Until a witness measures the yaw, only the rows determine it, and
    /// its uncertainty includes the apparent yaw of the lens ([`crate::Config::with_lens_yaw_sd_rad`]).
    #[must_use]
    pub const fn guess(cameras: Cameras<T>) -> Self {
        Self::new(cameras, Extrinsics::SIDE_BY_SIDE).without_yaw()
    }

    /// Sets the standard deviation of the yaw of `R`, rad.
    ///
    /// Rows do not separate this yaw from the apparent yaw of the lens, so depth relies on the factory yaw until the
    /// rig changes or a witness measures the yaw. A larger value lets the rows change the yaw more; a smaller one keeps
    /// an error of the calibration.
    ///
    /// # Errors
    /// [`ConfigError::FactoryYaw`] if the value is outside 1e-6 to 1.
    pub const fn with_yaw_sd_rad(mut self, rad: f32) -> Result<Self, ConfigError> {
        if is_yaw_sd(rad) {
            self.yaw_sd_rad = Some(rad);
            Ok(self)
        } else {
            Err(ConfigError::FactoryYaw)
        }
    }

    /// Takes the yaw of `R` as unknown, as in a guess.
    #[must_use]
    pub const fn without_yaw(mut self) -> Self {
        self.yaw_sd_rad = None;
        self
    }

    /// Sets the length of the baseline, m; a [`crate::depth::RangeReading`] needs it.
    ///
    /// # Errors
    /// [`ConfigError::BaselineLength`] if the value is outside 1e-3 to 1e3.
    pub const fn with_baseline_m(mut self, metres: f32) -> Result<Self, ConfigError> {
        if is_baseline(metres) {
            self.baseline_m = Some(metres);
            Ok(self)
        } else {
            Err(ConfigError::BaselineLength)
        }
    }

    /// Returns the standard deviation of the yaw of `R`, rad; `None` if the yaw is unknown, as in a guess.
    pub const fn yaw_sd_rad(&self) -> Option<f32> {
        self.yaw_sd_rad
    }

    /// Returns the length of the baseline, m; `None` if it was not measured.
    pub const fn baseline_m(&self) -> Option<f32> {
        self.baseline_m
    }

    /// Returns the calibration as a record. The numbers of the record are `f32`.
    #[must_use]
    pub fn to_record(&self) -> [u8; BYTES] {
        let mut record = [0; BYTES];
        self.write(&mut record);
        record
    }

    /// Writes the record.
    #[inline(never)]
    pub(crate) fn write(&self, record: &mut [u8]) {
        let mut to = Writer::begin(record, FACTORY, [0; 2]);
        write_rig(&self.cameras, &self.extrinsics, &mut to);
        to.numbers(&[self.yaw_sd_rad, self.baseline_m].map(Option::unwrap_or_default));
        seal(record);
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`], [`RestoreError::Foreign`], [`RestoreError::Layout`], [`RestoreError::Absurd`].
    #[inline(never)]
    pub fn from_record(record: &[u8]) -> Result<Self, RestoreError> {
        let (mut from, more) = Reader::begin(record, FACTORY, BYTES)?;
        believe(more == [0; 2])?;
        let cameras = Cameras { left: read_camera(&mut from)?, right: read_camera(&mut from)? };
        let extrinsics = Extrinsics::from_row_major(from.numbers(), from.numbers());
        let extrinsics = extrinsics.map_err(|_| RestoreError::Absurd)?;
        // 0 stands for an unknown value.
        let known = |number: f32| Some(number).filter(|number| *number != 0.0);
        let [yaw_sd_rad, baseline_m] = from.numbers().map(known);
        believe(yaw_sd_rad.is_none_or(is_yaw_sd) && baseline_m.is_none_or(is_baseline))?;
        Ok(Self { cameras, extrinsics, yaw_sd_rad, baseline_m })
    }
}

/// Returns a hash that almost surely changes if any number of the cameras or the extrinsics changes.
#[inline(never)]
pub(crate) fn fingerprint<T: Scalar>(cameras: &Cameras<T>, extrinsics: &Extrinsics<T>) -> u32 {
    let mut rig = [0; RIG_BYTES];
    write_rig(cameras, extrinsics, &mut Writer { rest: &mut rig });
    checksum::of_record(&rig)
}

fn write_rig<T: Scalar>(cameras: &Cameras<T>, extrinsics: &Extrinsics<T>, to: &mut Writer<'_>) {
    write_camera(&cameras.left, to);
    write_camera(&cameras.right, to);
    to.numbers(&extrinsics.rotation_row_major());
    to.numbers(extrinsics.translation().as_slice());
}

#[inline(never)]
fn write_camera<T: Scalar>(camera: &Camera<T>, to: &mut Writer<'_>) {
    let Intrinsics { focal, principal, size: [width, height] } = camera.intrinsics();
    to.numbers(focal);
    to.numbers(principal);
    to.word(u32::from(*width) | u32::from(*height) << 16);
    let lens = match camera.lens() {
        Lens::Pinhole => 0,
        Lens::RadialTangential(_) => 1,
        Lens::Fisheye(_) => 2,
        Lens::Rational(_) => 3,
    };
    to.word(lens);
    let own = camera.lens().coefficients();
    to.numbers(own);
    to.numbers([T::ZERO; 8].get(own.len()..).unwrap_or_default());
}

#[inline(never)]
fn read_camera<T: Scalar>(from: &mut Reader<'_>) -> Result<Camera<T>, RestoreError> {
    let absurd = |_: CameraError| RestoreError::Absurd;
    let (focal, principal) = (from.numbers(), from.numbers());
    let [a, b, c, d] = from.word().to_le_bytes();
    let size = [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])];
    let lens = from.word();
    let coefficients: [T; 8] = from.numbers();
    let [a, b, c, d, e, ..] = coefficients;
    let lens = match lens {
        0 => Lens::Pinhole,
        1 => RadialTangential::try_new([a, b, c, d, e])
            .map(Lens::RadialTangential)
            .map_err(absurd)?,
        2 => Fisheye::try_new([a, b, c, d]).map(Lens::Fisheye).map_err(absurd)?,
        3 => Rational::try_new(coefficients).map(Lens::Rational).map_err(absurd)?,
        _ => return Err(RestoreError::Absurd),
    };
    let mut unused = coefficients.iter().skip(lens.coefficients().len());
    believe(unused.all(|unused| *unused == T::ZERO))?;
    Camera::try_new(Intrinsics { focal, principal, size }, lens).map_err(absurd)
}
