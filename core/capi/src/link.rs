//! The link to a matcher: bytes of any driver into the batch.

use core::mem::MaybeUninit;

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Decoder, FrameHeader, FrameRefusal, FrameSink, Received};
use zerocopy::IntoBytes;

use crate::code::{code, selfcal_error_t};
use crate::instance::{Instance, instance};
use crate::marked::{self, Marked};
use crate::pointer::{Out, read_array};
use crate::storage::selfcal_t;

/// Storage of a link in words of 8 bytes: the same for every target, so with a little to spare.
pub const SELFCAL_LINK_STORAGE_WORDS: usize = 26;

/// Storage of a link, bytes.
pub const SELFCAL_LINK_STORAGE_SIZE: usize = 8 * SELFCAL_LINK_STORAGE_WORDS;

/// What looks for the frames of a matcher in the bytes of a driver. The caller owns it, as a `selfcal_t`;
/// it holds no frame, only the place in one. One for each wire.
#[repr(C)]
pub struct selfcal_link_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_LINK_STORAGE_WORDS],
}

/// What lies in its storage.
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

const _: () = assert!(size_of::<Link>() <= size_of::<selfcal_link_t>());
const _: () = assert!(align_of::<Link>() <= align_of::<selfcal_link_t>());
const _: () = assert!(size_of::<selfcal_link_t>() == SELFCAL_LINK_STORAGE_SIZE);

/// A whole frame and what was taken of it. All 0 where none is whole.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoBytes)]
pub struct selfcal_frame_t {
    /// When the images were taken: the matcher's clock, us; 0 without one. Not interpreted.
    pub timestamp_us: u64,
    /// Number of the frame; wraps around.
    pub sequence: u32,
    /// Matches in the frame.
    pub count: u32,
    /// Matches of it that the batch holds: a full one selects, and what is not valid is refused. See
    /// `selfcal_batch`.
    pub taken: u32,
    /// Whether a frame is whole now: its matches are the batch. Solve it before you feed on.
    pub whole: bool,
    /// The matcher dropped frames right before this one: nobody read them.
    pub dropped_before: bool,
    /// The matcher found more matches than it sends.
    pub more_found: bool,
    /// 0.
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

/// What a link has been through since `selfcal_link_init`. Counts stay at their largest value.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoBytes)]
pub struct selfcal_link_counters_t {
    /// Frames handed out whole.
    pub good: u32,
    /// Frames whose CRC was wrong: look at the wiring and the clock of the bus.
    pub bad_crc: u32,
    /// Starts of a frame whose header had a wrong CRC.
    pub bad_header: u32,
    /// Headers or frames with a right CRC that version 1 of the format does not have: correct the sender.
    pub unsupported: u32,
    /// Frames that the next one began inside of: bytes are being lost.
    pub truncated: u32,
    /// Frames that never came whole, by the sequence numbers of those that did.
    pub gaps: u32,
    /// Frames with the sequence number of the frame before; not handed out.
    pub repeats: u32,
    /// Steps back in the sequence: the sender was restarted.
    pub restarts: u32,
    /// Whole frames before which the sender had dropped some, and calls of `selfcal_link_note_overrun`.
    pub overruns: u32,
    /// Frames that were refused: no cameras, or images of another size.
    pub refused: u32,
    /// Bytes passed over in search of a frame.
    pub skipped_bytes: u32,
}

/// A frame replaces the batch, and what was solved of the batch before goes with that.
impl FrameSink for Instance {
    fn is_busy(&self) -> bool {
        self.calibrator.is_busy()
    }

    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal> {
        self.calibrator.start(header)?;
        self.solved = None;
        Ok(())
    }

    fn take(&mut self, correspondence: &Correspondence<f32>) {
        self.calibrator.take(correspondence);
    }

    fn finish(&mut self) -> usize {
        self.calibrator.finish()
    }

    fn discard(&mut self) {
        self.solved = None;
        self.calibrator.discard();
    }
}

/// The link in a storage.
///
/// # Safety
/// The contract of the crate.
unsafe fn link<'a>(storage: *mut selfcal_link_t) -> Result<&'a mut Link, selfcal_error_t> {
    // SAFETY: the contract of the crate; storage is as large as `Link`.
    unsafe { marked::exclusive(storage.cast()) }
}

/// Makes a link in search of its first frame. Comes before all other calls; on a link in use it begins
/// anew, and a frame half read is lost.
///
/// * `size`: of the storage, bytes: `sizeof(selfcal_link_t)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_init(
    link: *mut selfcal_link_t,
    size: usize,
) -> selfcal_error_t {
    code(|| {
        let place = link.cast::<Link>();
        marked::judge(place, size)?;
        // SAFETY: not null, aligned and large enough.
        unsafe { place.write(Link { magic: Link::MAGIC, decoder: Decoder::new() }) };
        Ok(())
    })
}

/// Takes bytes as they come off the wire, in pieces of any length, up to the end of the first whole frame.
/// A frame replaces the batch. What was damaged or lost on the way costs the frames it hit; the next one
/// is found.
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
/// Push nothing and begin no pair while a frame comes in: half of it is in the batch. A pair that is being
/// solved is not given up for a frame: `SELFCAL_ERROR_LINK_BUSY`, nothing is used, and the same bytes are
/// to be fed later. After the other `SELFCAL_ERROR_LINK_` codes feed the rest: the frame is passed over,
/// and the batch is as it was. What was solved is forgotten with the batch: fuse it before.
///
/// * `bytes`: `length` of them; may be null where that is 0. Not needed after the call.
/// * `used`: how many of them are done with, with errors too; 0 where nothing was done.
/// * `frame`: the frame, if one is whole now; all 0 if none is, and with errors.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_feed(
    link: *mut selfcal_link_t,
    cal: *mut selfcal_t,
    bytes: *const u8,
    length: usize,
    used: *mut usize,
    frame: *mut selfcal_frame_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (used, frame) = unsafe { (Out::checked(used)?, Out::checked(frame)?) };
        let mut count = 0;
        // SAFETY: as above.
        let fed = unsafe { feed(link, cal, bytes, length, &mut count) };
        // Whatever came of it: the caller goes on from there.
        used.set(count);
        frame.set(fed.ok().flatten().into());
        fed.map(|_| ())
    })
}

/// # Safety
/// The contract of the crate.
unsafe fn feed(
    link: *mut selfcal_link_t,
    cal: *mut selfcal_t,
    bytes: *const u8,
    length: usize,
    used: &mut usize,
) -> Result<Option<Received>, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    let (link, instance, mut bytes) =
        unsafe { (self::link(link)?, instance(cal)?, read_array(bytes, length)?) };
    if instance.is_busy() {
        return Err(FrameRefusal::Busy.into());
    }
    let fed = link.decoder.feed(&mut bytes, instance);
    *used = length.saturating_sub(bytes.len());
    Ok(fed?)
}

/// Counts an overrun on this side of the wire: a ring that was lapped, a UART that says so. Then feed on:
/// the next whole frame is found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_note_overrun(link: *mut selfcal_link_t) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { self::link(link) }?.decoder.note_overrun();
        Ok(())
    })
}

/// What the link has been through.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_counters(
    link: *const selfcal_link_t,
    counters: *mut selfcal_link_counters_t,
) -> selfcal_error_t {
    code(|| {
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
            truncated: counters.truncated,
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
