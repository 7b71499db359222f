//! The host's request for a session: both cameras, and the number of pairs.
//!
//! | request, 124 bytes | type | | camera, 56 bytes | type | unit |
//! |---|---|---|---|---|---|
//! | magic `SCPO` | 4 bytes | | focal lengths | 2 x `f32` | px |
//! | version, 2 | `u32` | | principal point | 2 x `f32` | px |
//! | pairs | `u32` | | size | 2 x `u16` | px |
//! | left, right | 2 cameras | | lens: 0 pinhole, 1 radial-tangential, 2 fisheye, 3 rational | `u32` | |
//! | | | | coefficients, OpenCV's order, then 0 | 8 x `f32` | |

use stereo_selfcal::geometry::{CameraError, Fisheye, RadialTangential, Rational, Side};
use stereo_selfcal::{Camera, Cameras, Intrinsics, Lens};
use thiserror::Error;
use zerocopy::little_endian::{F32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, Unaligned, transmute};

const MAGIC: [u8; 4] = *b"SCPO";
const VERSION: u32 = 2;

const PINHOLE: u32 = 0;
const RADIAL_TANGENTIAL: u32 = 1;
const FISHEYE: u32 = 2;
const RATIONAL: u32 = 3;

/// Why the controller refuses a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[non_exhaustive]
pub enum RequestError {
    /// The magic is wrong.
    #[error("magic {0:02x?} is not the magic of a request")]
    BadMagic([u8; 4]),
    /// The version is not supported.
    #[error("request of version {0}, supported is 2")]
    Version(u32),
    /// The lens model is unknown.
    #[error("unknown lens {0}")]
    Lens(u32),
    /// A camera is invalid.
    #[error("{0} camera: {1}")]
    Camera(Side, CameraError),
}

impl RequestError {
    /// Stable number: for a camera [`CameraError::code`], plus 10 for the right one.
    #[must_use]
    pub const fn code(&self) -> u16 {
        match self {
            Self::BadMagic(_) => 1,
            Self::Version(_) => 2,
            Self::Lens(_) => 3,
            Self::Camera(side, why) => why.code() + 10 * side.code(),
        }
    }
}

/// The first message of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionRequest {
    /// Number of pairs.
    pub pairs: u32,
    /// Cameras of all pairs.
    pub cameras: Cameras<f32>,
}

#[derive(FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct WireRequest {
    magic: [u8; 4],
    version: U32,
    pairs: U32,
    left: WireCamera,
    right: WireCamera,
}

#[derive(FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct WireCamera {
    focal: [F32; 2],
    principal: [F32; 2],
    size: [U16; 2],
    lens: U32,
    coefficients: [F32; 8],
}

impl SessionRequest {
    /// Length on the wire, bytes.
    pub const BYTES: usize = size_of::<WireRequest>();

    /// Encodes the request.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::BYTES] {
        transmute!(WireRequest {
            magic: MAGIC,
            version: VERSION.into(),
            pairs: self.pairs.into(),
            left: WireCamera::of(&self.cameras.left),
            right: WireCamera::of(&self.cameras.right),
        })
    }

    /// Decodes a request.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn decode(bytes: [u8; Self::BYTES]) -> Result<Self, RequestError> {
        let wire: WireRequest = transmute!(bytes);
        if wire.magic != MAGIC {
            return Err(RequestError::BadMagic(wire.magic));
        }
        if wire.version != VERSION {
            return Err(RequestError::Version(wire.version.get()));
        }
        let cameras =
            Cameras { left: wire.left.camera(Side::Left)?, right: wire.right.camera(Side::Right)? };
        Ok(Self { pairs: wire.pairs.get(), cameras })
    }
}

impl WireCamera {
    fn of(camera: &Camera<f32>) -> Self {
        let Intrinsics { focal, principal, size } = *camera.intrinsics();
        let (lens, coefficients) = match camera.lens() {
            Lens::Pinhole => (PINHOLE, [0.0; 8]),
            Lens::RadialTangential(lens) => {
                let [k1, k2, p1, p2, k3] = lens.coefficients();
                (RADIAL_TANGENTIAL, [k1, k2, p1, p2, k3, 0.0, 0.0, 0.0])
            }
            Lens::Fisheye(lens) => {
                let [k1, k2, k3, k4] = lens.coefficients();
                (FISHEYE, [k1, k2, k3, k4, 0.0, 0.0, 0.0, 0.0])
            }
            Lens::Rational(lens) => (RATIONAL, lens.coefficients()),
        };
        Self {
            focal: focal.map(F32::new),
            principal: principal.map(F32::new),
            size: size.map(U16::new),
            lens: lens.into(),
            coefficients: coefficients.map(F32::new),
        }
    }

    fn camera(&self, side: Side) -> Result<Camera<f32>, RequestError> {
        let refused = |why| RequestError::Camera(side, why);
        let coefficients = self.coefficients.map(F32::get);
        let [k1, k2, k3, k4, k5, ..] = coefficients;
        let lens = match self.lens.get() {
            PINHOLE => Lens::Pinhole,
            RADIAL_TANGENTIAL => {
                let five = [k1, k2, k3, k4, k5];
                Lens::RadialTangential(RadialTangential::try_new(five).map_err(refused)?)
            }
            FISHEYE => Lens::Fisheye(Fisheye::try_new([k1, k2, k3, k4]).map_err(refused)?),
            RATIONAL => Lens::Rational(Rational::try_new(coefficients).map_err(refused)?),
            other => return Err(RequestError::Lens(other)),
        };
        let intrinsics = Intrinsics {
            focal: self.focal.map(F32::get),
            principal: self.principal.map(F32::get),
            size: self.size.map(U16::get),
        };
        Camera::try_new(intrinsics, lens).map_err(refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(lens: Lens<f32>) -> SessionRequest {
        let intrinsics =
            Intrinsics { focal: [534.1, 534.2], principal: [342.0, 234.5], size: [640, 480] };
        let left = Camera::try_new(intrinsics, lens).unwrap();
        let right = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        SessionRequest { pairs: 13, cameras: Cameras { left, right } }
    }

    #[test]
    fn every_lens_survives_encoding() {
        let radial = RadialTangential::try_new([-0.28, 0.04, 1e-3, -1e-4, 0.1]).unwrap();
        let fisheye = Fisheye::try_new([-0.02, 0.01, -1e-3, 1e-4]).unwrap();
        let rational = Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]).unwrap();
        let lenses = [
            Lens::Pinhole,
            Lens::RadialTangential(radial),
            Lens::Fisheye(fisheye),
            Lens::Rational(rational),
        ];
        for lens in lenses {
            let sent = request(lens);
            assert_eq!(SessionRequest::decode(sent.encode()), Ok(sent));
        }
    }

    #[test]
    fn the_layout_is_the_documented_one() {
        let bytes = request(Lens::Pinhole).encode();
        assert_eq!(bytes.len(), 124);
        assert_eq!(bytes[..12], [b'S', b'C', b'P', b'O', 2, 0, 0, 0, 13, 0, 0, 0]);
        assert_eq!(bytes[12..16], 534.1_f32.to_le_bytes());
        assert_eq!(bytes[28..36], [128, 2, 224, 1, 0, 0, 0, 0]);
    }

    #[test]
    fn each_invalid_field_has_its_error() {
        let good = request(Lens::Pinhole).encode();
        let with = |at: usize, value: u8| {
            let mut bytes = good;
            bytes[at] = value;
            SessionRequest::decode(bytes)
        };
        assert_eq!(with(0, b'X'), Err(RequestError::BadMagic(*b"XCPO")));
        assert_eq!(with(4, 9), Err(RequestError::Version(9)));
        assert_eq!(with(32, 4), Err(RequestError::Lens(4)));
        let focal = RequestError::Camera(Side::Right, CameraError::FocalLength);
        assert_eq!(with(68 + 3, 0xff), Err(focal));
    }
}
