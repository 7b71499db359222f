//! The link to a matcher: decodes the bytes of any driver into the batch.

use core::mem::MaybeUninit;

use stereo_selfcal::link::{Decoder, FrameRefusal, FrameSink, Received};
use zerocopy::IntoBytes;

use crate::error::{selfcal_error_t, status};
use crate::instance::{Held, exclusive, selfcal_t};
use crate::marked::{self, Marked};
use crate::pointer::{Out, read_array};

/// Size of `selfcal_link_t` in words of 8 bytes, sufficient on every target.
pub const SELFCAL_LINK_STORAGE_WORDS: usize = 19;

/// Size of `selfcal_link_t`, bytes.
pub const SELFCAL_LINK_STORAGE_SIZE: usize = 8 * SELFCAL_LINK_STORAGE_WORDS;

/// Decoder that finds the frames of a matcher in the bytes of a driver. The caller owns the storage, as with
/// `selfcal_t`. It holds its position in a frame, but no frame. Each wire needs its own.
#[repr(C)]
pub struct selfcal_link_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_LINK_STORAGE_WORDS],
}

/// Content of an initialised `selfcal_link_t`.
#[repr(C)]
struct Link {
    magic: [u32; 3],
    decoder: Decoder,
}

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Link {
    /// "SELFLINK".
    const NAME: [u32; 2] = [0x5345_4C46, 0x4C49_4E4B];
}

const _: () = marked::assert_fits::<Link, selfcal_link_t>(SELFCAL_LINK_STORAGE_SIZE);

/// A whole frame. All fields are 0 if no frame is whole.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoBytes)]
pub struct selfcal_frame_t {
    /// Time of exposure on the clock of the matcher, us; 0 without a clock. Not interpreted.
    pub timestamp_us: u64,
    /// Sequence number of the frame; it wraps around.
    pub sequence: u32,
    /// Number of matches in the frame.
    pub count: u32,
    /// Number of these matches in the batch. The batch refuses matches that are not valid, and a full batch selects;
    /// see `selfcal_batch`.
    pub taken: u32,
    /// Whether a frame is whole. Then its matches are the batch: solve it before the next feed.
    pub whole: bool,
    /// The matcher dropped unread frames right before this one.
    pub dropped_before: bool,
    /// The matcher found more matches than it sent.
    pub more_found: bool,
    /// Always 0.
    pub reserved: u8,
}

impl From<Option<Received>> for selfcal_frame_t {
    fn from(received: Option<Received>) -> Self {
        let Some(Received { header, taken }) = received else {
            return Self {
                timestamp_us: 0,
                sequence: 0,
                count: 0,
                taken: 0,
                whole: false,
                dropped_before: false,
                more_found: false,
                reserved: 0,
            };
        };
        Self {
            timestamp_us: header.timestamp_us,
            sequence: header.sequence,
            count: header.count.into(),
            taken: u32::try_from(taken).unwrap_or(u32::MAX),
            whole: true,
            dropped_before: header.dropped_before,
            more_found: header.more_found,
            reserved: 0,
        }
    }
}

/// Counters of a link since `selfcal_link_init`. They saturate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoBytes)]
pub struct selfcal_link_counters_t {
    /// Whole frames returned.
    pub good: u32,
    /// Frames with a wrong CRC: bytes are being damaged or lost. Check the wiring and the clock of the bus.
    pub bad_crc: u32,
    /// Places where the magic is found, but the header has a wrong CRC.
    pub bad_header: u32,
    /// Headers with a correct CRC whose content is not valid in version 1 of the format: correct the sender.
    pub unsupported: u32,
    /// Frames missing between the sequence numbers of the whole frames.
    pub gaps: u32,
    /// Whole frames with the sequence number of the last whole frame before; they are not returned.
    pub repeats: u32,
    /// Backward steps of the sequence number: the sender restarted.
    pub restarts: u32,
    /// Whole frames before which the sender dropped some, and calls of `selfcal_link_note_overrun`.
    pub overruns: u32,
    /// Refused frames: their image size differs from the image size of the left camera.
    pub refused: u32,
    /// Bytes skipped in search of a frame.
    pub skipped_bytes: u32,
}

/// Returns the link in a storage.
///
/// # Safety
/// The contract of the crate.
unsafe fn link<'a>(storage: *mut selfcal_link_t) -> Result<&'a mut Link, selfcal_error_t> {
    // SAFETY: the contract of the crate; storage is as large as `Link`.
    unsafe { marked::exclusive(storage.cast()) }
}

/// Initialises a link. Call it before all other functions of the link. It also restarts a link in use; a frame that is
/// partly read is dropped, and the counters are 0.
///
/// * `size`: size of the storage, bytes: `sizeof(selfcal_link_t)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_init(
    link: *mut selfcal_link_t,
    size: usize,
) -> selfcal_error_t {
    status(|| {
        let place = link.cast::<Link>();
        marked::check_place(place, size)?;
        // SAFETY: not null, aligned and large enough.
        unsafe { place.write(Link { magic: Link::MAGIC, decoder: Decoder::new() }) };
        Ok(())
    })
}

/// Decodes bytes off the wire, in pieces of any length, up to the end of the first whole frame. A
/// frame replaces the batch. Damaged or lost bytes cost the frames they are part of; the decoder
/// finds the next frame.
///
/// Feed all bytes, in their order, in a loop:
///
/// ```c
/// do {
///     error = selfcal_link_feed(&wire, &cal, bytes, length, &used, &frame);
///     bytes += used;
///     length -= used;
///     if (frame.whole)
///         ...
/// } while (used > 0 && length > 0);
/// ```
///
/// Do not push a correspondence, and do not begin a pair, while a frame arrives: its matches are hidden until it is
/// whole. While a pair is being solved, the call returns `SELFCAL_ERROR_BUSY` and uses no bytes: feed the same bytes
/// later. After `SELFCAL_ERROR_IMAGE_SIZE` feed the rest: the frame is skipped, and the batch is unchanged.
///
/// * `bytes`: array of `length`; may be null if `length` is 0. Not needed after the call.
/// * `used`: number of bytes used, also written with errors; 0 if nothing was decoded.
/// * `frame`: the frame, if one is whole; otherwise, and with errors, all 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_feed(
    link: *mut selfcal_link_t,
    cal: *mut selfcal_t,
    bytes: *const u8,
    length: usize,
    used: *mut usize,
    frame: *mut selfcal_frame_t,
) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe {
        feed(link, cal, bytes, length, used, frame, |decoder, bytes, calibrator| {
            Ok(decoder.feed(bytes, calibrator)?)
        })
    }
}

/// Feeds bytes, and writes the number of bytes used and the frame.
///
/// * `take`: decodes bytes up to the end of a whole frame, and removes the used bytes from the front.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn feed(
    link: *mut selfcal_link_t,
    cal: *mut selfcal_t,
    bytes: *const u8,
    length: usize,
    used: *mut usize,
    frame: *mut selfcal_frame_t,
    take: impl FnOnce(&mut Decoder, &mut &[u8], &mut Held) -> Result<Option<Received>, selfcal_error_t>,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the contract of the crate.
        let (used, frame) = unsafe { (Out::checked(used)?, Out::checked(frame)?) };
        let mut count = 0;
        let fed = (|| {
            // SAFETY: as above.
            let (link, instance, mut bytes) =
                unsafe { (self::link(link)?, exclusive(cal)?, read_array(bytes, length)?) };
            if instance.calibrator.is_busy() {
                return Err(FrameRefusal::Busy.into());
            }
            let fed = take(&mut link.decoder, &mut bytes, &mut instance.calibrator);
            count = length.saturating_sub(bytes.len());
            fed
        })();
        // Written with errors, too, because the caller goes on after the used bytes.
        used.set(count);
        frame.set(fed.ok().flatten().into());
        fed.map(|_| ())
    })
}

/// Counts an overrun of the receiver, such as a ring buffer that wrapped or an overrun that a UART reports. Go on
/// feeding: the decoder finds the next whole frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_note_overrun(link: *mut selfcal_link_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { self::link(link) }?.decoder.note_overrun();
        Ok(())
    })
}

/// Reads the counters of a link.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_counters(
    link: *const selfcal_link_t,
    counters: *mut selfcal_link_counters_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate; storage is as large as `Link`.
        let link = unsafe { marked::shared(link.cast::<Link>()) }?;
        // SAFETY: as above.
        let out = unsafe { Out::checked(counters) }?;
        let counters = link.decoder.counters();
        out.set(selfcal_link_counters_t {
            good: counters.good,
            bad_crc: counters.bad_crc,
            bad_header: counters.bad_header,
            unsupported: counters.unsupported,
            gaps: counters.gaps,
            repeats: counters.repeats,
            restarts: counters.restarts,
            overruns: counters.overruns,
            refused: counters.refused,
            skipped_bytes: counters.skipped_bytes,
        });
        Ok(())
    })
}
