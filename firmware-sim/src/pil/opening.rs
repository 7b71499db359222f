//! What the host opens with: both cameras, and how many pairs will come.
//!
//! | opening, 100 bytes | type | | camera, 44 bytes | type | unit |
//! |---|---|---|---|---|---|
//! | magic `SCPO` | 4 bytes | | focal lengths | 2 x `f32` | px |
//! | version, 1 | `u32` | | principal point | 2 x `f32` | px |
//! | pairs | `u32` | | size | 2 x `u16` | px |
//! | left, right | 2 cameras | | lens: 0 pinhole, 1 radial-tangential, 2 fisheye | `u32` | |
//! | | | | coefficients, OpenCV's order | 5 x `f32` | |

use stereo_selfcal::{
    Camera, CameraError, Cameras, Fisheye, Intrinsics, Lens, RadialTangential, Side,
};
use thiserror::Error;
use zerocopy::little_endian::{F32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, Unaligned, transmute};

const MAGIC: [u8; 4] = *b"SCPO";
const VERSION: u32 = 1;

const PINHOLE: u32 = 0;
const RADIAL_TANGENTIAL: u32 = 1;
const FISHEYE: u32 = 2;

/// Why the controller does not take an opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[non_exhaustive]
pub enum OpeningError {
    /// The bytes are no opening.
    #[error("no opening starts with {0:02x?}")]
    BadMagic([u8; 4]),
    /// The host speaks another version.
    #[error("opening of version {0}, only 1 is understood")]
    Version(u32),
    /// The lens is none of the three.
    #[error("lens {0} is not known")]
    Lens(u32),
    /// A camera is not valid.
    #[error("{0} camera: {1}")]
    Camera(Side, CameraError),
}

impl OpeningError {
    /// Stable number: of a camera that of [`CameraError::code`], 10 more for the right one.
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

/// The start of an exchange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Pairs that will come.
    pub pairs: u32,
    /// Cameras of all of them.
    pub cameras: Cameras<f32>,
}

#[derive(FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct WireOpening {
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
    coefficients: [F32; 5],
}

impl Opening {
    /// Length on the wire, bytes.
    pub const BYTES: usize = size_of::<WireOpening>();

    /// As bytes on the wire.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::BYTES] {
        transmute!(WireOpening {
            magic: MAGIC,
            version: VERSION.into(),
            pairs: self.pairs.into(),
            left: WireCamera::of(&self.cameras.left),
            right: WireCamera::of(&self.cameras.right),
        })
    }

    /// From bytes off the wire.
    ///
    /// # Errors
    /// [`OpeningError`].
    pub fn decode(bytes: [u8; Self::BYTES]) -> Result<Self, OpeningError> {
        let wire: WireOpening = transmute!(bytes);
        if wire.magic != MAGIC {
            return Err(OpeningError::BadMagic(wire.magic));
        }
        if wire.version != VERSION {
            return Err(OpeningError::Version(wire.version.get()));
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
            Lens::Pinhole => (PINHOLE, [0.0; 5]),
            Lens::RadialTangential(lens) => (RADIAL_TANGENTIAL, lens.coefficients()),
            Lens::Fisheye(lens) => {
                let [k1, k2, k3, k4] = lens.coefficients();
                (FISHEYE, [k1, k2, k3, k4, 0.0])
            }
        };
        Self {
            focal: focal.map(F32::new),
            principal: principal.map(F32::new),
            size: size.map(U16::new),
            lens: lens.into(),
            coefficients: coefficients.map(F32::new),
        }
    }

    fn camera(&self, side: Side) -> Result<Camera<f32>, OpeningError> {
        let refused = |why| OpeningError::Camera(side, why);
        let coefficients = self.coefficients.map(F32::get);
        let [k1, k2, k3, k4, _] = coefficients;
        let lens = match self.lens.get() {
            PINHOLE => Lens::Pinhole,
            RADIAL_TANGENTIAL => {
                Lens::RadialTangential(RadialTangential::try_new(coefficients).map_err(refused)?)
            }
            FISHEYE => Lens::Fisheye(Fisheye::try_new([k1, k2, k3, k4]).map_err(refused)?),
            other => return Err(OpeningError::Lens(other)),
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

    fn opening(lens: Lens<f32>) -> Opening {
        let intrinsics =
            Intrinsics { focal: [534.1, 534.2], principal: [342.0, 234.5], size: [640, 480] };
        let left = Camera::try_new(intrinsics, lens).unwrap();
        let right = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        Opening { pairs: 13, cameras: Cameras { left, right } }
    }

    #[test]
    fn every_lens_comes_back_as_it_was_sent() {
        let radial = RadialTangential::try_new([-0.28, 0.04, 1e-3, -1e-4, 0.1]).unwrap();
        let fisheye = Fisheye::try_new([-0.02, 0.01, -1e-3, 1e-4]).unwrap();
        for lens in [Lens::Pinhole, Lens::RadialTangential(radial), Lens::Fisheye(fisheye)] {
            let sent = opening(lens);
            assert_eq!(Opening::decode(sent.encode()), Ok(sent));
        }
    }

    #[test]
    fn it_is_laid_out_as_documented() {
        let bytes = opening(Lens::Pinhole).encode();
        assert_eq!(bytes.len(), 100);
        assert_eq!(bytes[..12], [b'S', b'C', b'P', b'O', 1, 0, 0, 0, 13, 0, 0, 0]);
        assert_eq!(bytes[12..16], 534.1_f32.to_le_bytes());
        assert_eq!(bytes[28..36], [128, 2, 224, 1, 0, 0, 0, 0]);
    }

    #[test]
    fn what_cannot_be_taken_is_named() {
        let good = opening(Lens::Pinhole).encode();
        let with = |at: usize, value: u8| {
            let mut bytes = good;
            bytes[at] = value;
            Opening::decode(bytes)
        };
        assert_eq!(with(0, b'X'), Err(OpeningError::BadMagic(*b"XCPO")));
        assert_eq!(with(4, 9), Err(OpeningError::Version(9)));
        assert_eq!(with(32, 3), Err(OpeningError::Lens(3)));
        let focal = OpeningError::Camera(Side::Right, CameraError::FocalLength);
        assert_eq!(with(56 + 3, 0xff), Err(focal));
    }
}
