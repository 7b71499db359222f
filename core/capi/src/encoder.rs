//! Encoder of frames, for a matcher in software.

use core::mem::MaybeUninit;

use stereo_selfcal::link::{Encoder, FrameHeader, HeaderError, MatchRecord};
use zerocopy::FromBytes;

use crate::error::{selfcal_error_t, status};
use crate::marked::{self, Marked};
use crate::pointer::{Out, read};
use crate::push::selfcal_correspondence_t;

/// Length of the header of a frame, bytes.
pub const SELFCAL_FRAME_HEADER_BYTES: usize = 32;

/// Length of a match in a frame, bytes.
pub const SELFCAL_FRAME_MATCH_BYTES: usize = 16;

/// Length of the end of a frame, bytes.
pub const SELFCAL_FRAME_END_BYTES: usize = 4;

/// Flag of a header: frames were dropped right before this one because the receiver did not read.
pub const SELFCAL_FRAME_DROPPED_BEFORE: u8 = 1;

/// Flag of a header: more matches were found than are sent.
pub const SELFCAL_FRAME_MORE_FOUND: u8 = 2;

/// Size of `selfcal_encoder_t` in words of 8 bytes, sufficient on every target.
pub const SELFCAL_ENCODER_STORAGE_WORDS: usize = 10;

/// Size of `selfcal_encoder_t`, bytes.
pub const SELFCAL_ENCODER_STORAGE_SIZE: usize = 8 * SELFCAL_ENCODER_STORAGE_WORDS;

/// Encoder of one frame, for a matcher in software. The caller owns the encoder. It stores no
/// matches: each call returns the bytes of one match.
#[repr(C)]
pub struct selfcal_encoder_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_ENCODER_STORAGE_WORDS],
}

/// Content of an initialised `selfcal_encoder_t`.
#[repr(C)]
struct FrameEncoder {
    magic: [u32; 3],
    encoder: Encoder,
}

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for FrameEncoder {
    /// "SELFSEND".
    const NAME: [u32; 2] = [0x5345_4C46, 0x5345_4E44];
}

const _: () = marked::assert_fits::<FrameEncoder, selfcal_encoder_t>(SELFCAL_ENCODER_STORAGE_SIZE);
const _: () = assert!(SELFCAL_FRAME_HEADER_BYTES == FrameHeader::BYTES);
const _: () = assert!(SELFCAL_FRAME_MATCH_BYTES == MatchRecord::BYTES);

/// Header of a frame to be sent; core/src/link/FORMAT.md defines the fields.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
pub struct selfcal_frame_header_t {
    /// Time of exposure on the clock of the sender, us; 0 without a clock.
    pub timestamp_us: u64,
    /// Sequence number of the frame; it increases by 1 for each stereo pair, sent or not, and wraps around.
    pub sequence: u32,
    /// Width and height of the left image, px; the right image may have another size.
    pub size_px: [u16; 2],
    /// Number of matches in the frame.
    pub count: u16,
    /// Grid step of pyramid level 0, 1/256 px; 0 stands for the coordinate step, `2^-fraction_bits` px.
    pub grid_step: u16,
    /// Fraction bits of the coordinates, 0 to 8.
    pub fraction_bits: u8,
    /// Pixel size of a pyramid level over the pixel size of the level below, in 1/64: 64 to 255; 64 without a pyramid.
    pub pyramid_ratio: u8,
    /// Sum of `SELFCAL_FRAME_DROPPED_BEFORE` and `SELFCAL_FRAME_MORE_FOUND`, as far as they hold.
    pub flags: u8,
    /// Ignored.
    pub reserved: u8,
}

impl TryFrom<selfcal_frame_header_t> for FrameHeader {
    type Error = HeaderError;

    fn try_from(header: selfcal_frame_header_t) -> Result<Self, HeaderError> {
        let flags = header.flags;
        if flags & !(SELFCAL_FRAME_DROPPED_BEFORE | SELFCAL_FRAME_MORE_FOUND) != 0 {
            return Err(HeaderError::Flags(flags));
        }
        Ok(Self {
            timestamp_us: header.timestamp_us,
            sequence: header.sequence,
            count: header.count,
            image_size: header.size_px,
            grid_step: header.grid_step,
            fraction_bits: header.fraction_bits,
            pyramid_ratio: header.pyramid_ratio,
            dropped_before: flags & SELFCAL_FRAME_DROPPED_BEFORE != 0,
            more_found: flags & SELFCAL_FRAME_MORE_FOUND != 0,
        })
    }
}

/// Checks whether a match can be encoded in a frame. Count such matches before the frame begins, because the header
/// contains their number.
///
/// * `header`: header of the frame; its count is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_frame_check(
    header: *const selfcal_frame_header_t,
    correspondence: *const selfcal_correspondence_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (header, m) = unsafe { (read(header)?, read(correspondence)?) };
        let header = FrameHeader::try_from(header)?;
        header.encode()?;
        MatchRecord::encode(&(&m).into(), &header)?;
        Ok(())
    })
}

/// Begins a frame, also in an encoder in use. The header contains the number of matches that follow.
///
/// * `size`: size of the storage, bytes: `sizeof(selfcal_encoder_t)`.
/// * `bytes`: place for the first `SELFCAL_FRAME_HEADER_BYTES` bytes of the frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_frame_begin(
    encoder: *mut selfcal_encoder_t,
    size: usize,
    header: *const selfcal_frame_header_t,
    bytes: *mut u8,
) -> selfcal_error_t {
    status(|| {
        let place = encoder.cast::<FrameEncoder>();
        marked::check_place(place, size)?;
        // SAFETY: the caller keeps the contract of the crate.
        let (header, out) = unsafe { (read(header)?, Out::checked(bytes.cast())?) };
        let (encoder, start) = Encoder::begin(header.try_into()?)?;
        // SAFETY: not null, aligned and large enough.
        unsafe { place.write(FrameEncoder { magic: FrameEncoder::MAGIC, encoder }) };
        out.set(start);
        Ok(())
    })
}

/// Encodes the next match of a frame. A match that is refused changes nothing: send another one in its
/// place, or begin the next frame.
///
/// * `bytes`: place for the next `SELFCAL_FRAME_MATCH_BYTES` bytes of the frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_frame_match(
    encoder: *mut selfcal_encoder_t,
    correspondence: *const selfcal_correspondence_t,
    bytes: *mut u8,
) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { selfcal_frame_tracked_match(encoder, correspondence, 0, bytes) }
}

/// Does the same as `selfcal_frame_match`, for a match that a tracker follows.
///
/// * `track`: number of the track; its low 12 bits are sent. If they are 0, the match is sent without a track.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_frame_tracked_match(
    encoder: *mut selfcal_encoder_t,
    correspondence: *const selfcal_correspondence_t,
    track: u16,
    bytes: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate; storage is as large as `FrameEncoder`.
        let (frame, m, out) = unsafe {
            let frame = marked::exclusive(encoder.cast::<FrameEncoder>())?;
            (frame, read(correspondence)?, Out::checked(bytes.cast())?)
        };
        out.set(frame.encoder.push_tracked(&(&m).into(), track)?);
        Ok(())
    })
}

/// Ends a frame with its CRC. While matches are missing, it returns `SELFCAL_ERROR_FRAME_MISSING`: add them, or begin
/// the next frame; the receiver then drops this one.
///
/// * `bytes`: place for the last `SELFCAL_FRAME_END_BYTES` bytes of the frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_frame_end(
    encoder: *const selfcal_encoder_t,
    bytes: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate; storage is as large as `FrameEncoder`.
        let (frame, out) = unsafe {
            (marked::shared(encoder.cast::<FrameEncoder>())?, Out::checked(bytes.cast())?)
        };
        out.set(frame.encoder.finish()?);
        Ok(())
    })
}
