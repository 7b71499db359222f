//! What a rig was calibrated to in production, as a record: written once, and where everything that is
//! learnt starts from.

use crate::batch::correspondence::Cameras;
use crate::codec::{self, OVERHEAD_BYTES, Reader, RecordHeader, Writer};
use crate::error::{CameraError, RestoreError, SnapshotError};
use crate::geometry::camera::{Camera, Intrinsics};
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens::{Fisheye, Lens, RadialTangential};
use crate::geometry::rational::Rational;
use crate::scalar::Scalar;

/// Numbers of a camera, its lens included, and of the extrinsics; words of a camera.
const CAMERA_NUMBERS: usize = 12;
const EXTRINSICS_NUMBERS: usize = 12;
const CAMERA_WORDS: usize = 3;

/// Cameras and extrinsics of a rig as it left the factory: `p_r = R p_l + t`.
///
/// ```
/// # use stereo_selfcal::*;
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// # let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
/// # let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// # let cameras = Cameras { left: camera, right: camera };
/// let made = FactoryCalibration { cameras, extrinsics: Extrinsics::<f32>::SIDE_BY_SIDE };
/// let mut buffer = [0; FactoryCalibration::<f32>::MAX_BYTES];
/// let record = made.to_record(&mut buffer)?; // into flash, once
/// let found = FactoryCalibration::<f32>::from_record(record)?; // at each start
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust());
/// calibrator.set_cameras(found.cameras);
/// calibrator.set_factory(found.extrinsics);
/// # assert_eq!(found, made);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
pub struct FactoryCalibration<T: Scalar> {
    /// Both cameras.
    pub cameras: Cameras<T>,
    /// `R`, `t` between them.
    pub extrinsics: Extrinsics<T>,
}

impl<T: Scalar> FactoryCalibration<T> {
    /// Length of the longest record, of rational lenses: 184 bytes in `f32`, 328 in `f64`.
    pub const MAX_BYTES: usize = OVERHEAD_BYTES
        + 2 * 4 * CAMERA_WORDS
        + (2 * CAMERA_NUMBERS + EXTRINSICS_NUMBERS) * size_of::<T>();

    /// Writes the record; the part of the buffer that it takes.
    ///
    /// # Errors
    /// [`SnapshotError::Room`].
    pub fn to_record<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], SnapshotError> {
        codec::write::<T>(RecordHeader::FACTORY, buffer, |to| {
            write(&self.cameras, &self.extrinsics, to);
        })
        .map_err(|needed| SnapshotError::Room { needed })
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`RestoreError`].
    pub fn from_record(record: &[u8]) -> Result<Self, RestoreError> {
        let mut from = codec::open::<T>(RecordHeader::FACTORY, record)?;
        let cameras = Cameras { left: read_camera(&mut from)?, right: read_camera(&mut from)? };
        let extrinsics = Extrinsics::read(&mut from)?;
        from.end()?;
        Ok(Self { cameras, extrinsics })
    }
}

/// Changes, in all likelihood, with any number of the cameras or the extrinsics.
pub(crate) fn fingerprint<T: Scalar>(cameras: &Cameras<T>, extrinsics: &Extrinsics<T>) -> u32 {
    let mut writer = Writer::new(&mut []);
    write(cameras, extrinsics, &mut writer);
    writer.checksum()
}

fn write<T: Scalar>(cameras: &Cameras<T>, extrinsics: &Extrinsics<T>, to: &mut Writer<'_>) {
    write_camera(&cameras.left, to);
    write_camera(&cameras.right, to);
    extrinsics.write(to);
}

fn write_camera<T: Scalar>(camera: &Camera<T>, to: &mut Writer<'_>) {
    let Intrinsics { focal, principal, size } = camera.intrinsics();
    to.numbers(focal);
    to.numbers(principal);
    for length in size {
        to.word((*length).into());
    }
    match camera.lens() {
        Lens::Pinhole => to.word(0),
        Lens::RadialTangential(lens) => {
            to.word(1);
            to.numbers(&lens.coefficients());
        }
        Lens::Fisheye(lens) => {
            to.word(2);
            to.numbers(&lens.coefficients());
        }
        Lens::Rational(lens) => {
            to.word(3);
            to.numbers(&lens.coefficients());
        }
    }
}

fn read_camera<T: Scalar>(from: &mut Reader<'_>) -> Result<Camera<T>, RestoreError> {
    let absurd = |_: CameraError| RestoreError::Absurd;
    let (focal, principal) = (read_numbers(from)?, read_numbers(from)?);
    let mut length =
        || from.word().and_then(|n| u16::try_from(n).map_err(|_| RestoreError::Absurd));
    let size = [length()?, length()?];
    let lens = match from.word()? {
        0 => Lens::Pinhole,
        1 => {
            Lens::RadialTangential(RadialTangential::try_new(read_numbers(from)?).map_err(absurd)?)
        }
        2 => Lens::Fisheye(Fisheye::try_new(read_numbers(from)?).map_err(absurd)?),
        3 => Lens::Rational(Rational::try_new(read_numbers(from)?).map_err(absurd)?),
        _ => return Err(RestoreError::Absurd),
    };
    Camera::try_new(Intrinsics { focal, principal, size }, lens).map_err(absurd)
}

fn read_numbers<T: Scalar, const K: usize>(from: &mut Reader<'_>) -> Result<[T; K], RestoreError> {
    let mut numbers = [T::ZERO; K];
    from.numbers(&mut numbers)?;
    Ok(numbers)
}
