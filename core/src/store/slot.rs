//! A record in flash: sequence number, record, CRC-32 of both; in whole words.

use embedded_storage::nor_flash::NorFlash;

use crate::checksum::register_after;

/// Longest access to flash with words up to this size, and to any other, bytes.
const SHORT: usize = 128;
const LONG: usize = 512;

/// Bytes of sequence number and CRC.
const OVERHEAD: u32 = 8;

/// Aligned: drivers hand it to DMA, or write it word by word.
#[repr(align(8))]
struct Chunk<const N: usize>([u8; N]);

/// Bytes of a slot for a record of this length.
pub(super) fn bytes<F: NorFlash>(record: usize) -> u32 {
    const {
        assert!(
            F::WRITE_SIZE <= LONG && LONG.is_multiple_of(F::WRITE_SIZE),
            "words up to 512 bytes"
        );
        assert!(F::WRITE_SIZE.is_multiple_of(F::READ_SIZE), "a word is read in whole reads");
    }
    let whole = to_u32(record).saturating_add(OVERHEAD);
    whole.checked_next_multiple_of(to_u32(F::WRITE_SIZE)).unwrap_or(u32::MAX)
}

/// Writes a record onto erased words, and reads it back; returns whether it is there.
///
/// # Errors
/// Errors of the driver.
pub(super) fn write<F: NorFlash>(
    flash: &mut F,
    address: u32,
    sequence: u32,
    record: &[u8],
) -> Result<bool, F::Error> {
    if F::WRITE_SIZE <= SHORT {
        write_by::<F, SHORT>(flash, address, sequence, record)?;
    } else {
        write_by::<F, LONG>(flash, address, sequence, record)?;
    }
    let mut is_same = true;
    let mut rest = record;
    let found = read(flash, address, record.len(), &mut |part| {
        let (expected, others) = rest.split_at_checked(part.len()).unwrap_or_default();
        is_same &= expected == part;
        rest = others;
    });
    Ok(is_same && found == Some(sequence))
}

#[inline(never)]
fn write_by<F: NorFlash, const N: usize>(
    flash: &mut F,
    address: u32,
    sequence: u32,
    record: &[u8],
) -> Result<(), F::Error> {
    let head = sequence.to_le_bytes();
    let sum = register_after(register_after(u32::MAX, &head), record);
    let tail = (!sum).to_le_bytes();
    let mut content = head.iter().chain(record).chain(&tail);
    let end = address.saturating_add(bytes::<F>(record.len()));
    let mut at = address;
    while at < end {
        let mut chunk = Chunk([0xff; N]);
        chunk.0.iter_mut().zip(&mut content).for_each(|(to, from)| *to = *from);
        let part = chunk.0.get(..to_usize(end.saturating_sub(at))).unwrap_or(&chunk.0);
        flash.write(at, part)?;
        at = at.saturating_add(to_u32(N));
    }
    Ok(())
}

/// Reads a record into a buffer of its length; returns its sequence number if it is intact.
pub(super) fn load<F: NorFlash>(flash: &mut F, address: u32, record: &mut [u8]) -> Option<u32> {
    let length = record.len();
    let mut rest = record;
    read(flash, address, length, &mut |part| {
        let (place, others) =
            core::mem::take(&mut rest).split_at_mut_checked(part.len()).unwrap_or_default();
        place.iter_mut().zip(part).for_each(|(to, from)| *to = *from);
        rest = others;
    })
}

/// Sequence number of a record, if it is intact.
pub(super) fn check<F: NorFlash>(flash: &mut F, address: u32, length: usize) -> Option<u32> {
    read(flash, address, length, &mut |_| ())
}

/// Reads a record, and passes it on in parts; returns its sequence number if it is intact.
// Out of line, with a dynamic argument: all callers share one copy.
#[inline(never)]
fn read<F: NorFlash>(
    flash: &mut F,
    address: u32,
    length: usize,
    each: &mut dyn FnMut(&[u8]),
) -> Option<u32> {
    let mut reader = Reader { left: length, sequence: 0, head: 0, sum: u32::MAX, tail: 0, end: 0 };
    visit(flash, address, bytes::<F>(length), &mut |chunk| {
        chunk.is_some_and(|chunk| reader.take(chunk, each))
    });
    let Reader { sequence, sum, end, .. } = reader;
    // Erased flash, and a line stuck at 0, are no record.
    (end == 4 && !sum == reader.tail && sequence != u32::MAX && sequence != 0).then_some(sequence)
}

/// A record that is being read.
struct Reader {
    /// Bytes of the record left.
    left: usize,
    /// Sequence number and checksum, and the number of their bytes read.
    sequence: u32,
    head: u32,
    sum: u32,
    tail: u32,
    end: u32,
}

impl Reader {
    /// Takes the next bytes; returns whether more are needed.
    fn take(&mut self, chunk: &[u8], each: &mut dyn FnMut(&[u8])) -> bool {
        let mut rest = chunk;
        if self.head == 0 {
            let Some((head, others)) = rest.split_first_chunk() else { return false };
            (self.sequence, self.head, rest) = (u32::from_le_bytes(*head), 4, others);
            self.sum = register_after(self.sum, head);
        }
        let (part, others) = rest.split_at_checked(self.left).unwrap_or((rest, &[]));
        self.left = self.left.saturating_sub(part.len());
        self.sum = register_after(self.sum, part);
        each(part);
        for byte in others.iter().take(to_usize(4_u32.saturating_sub(self.end))) {
            self.tail |= u32::from(*byte) << (8 * self.end);
            self.end = self.end.saturating_add(1);
        }
        self.sequence != 0 && self.sequence != u32::MAX
    }
}

/// Whether a slot counts as erased: all ones, all zeros, or unreadable throughout, as flash with ECC is before its
/// first write. A torn word is unreadable too, but other words of its slot are not.
#[inline(never)]
pub(super) fn is_blank<F: NorFlash>(flash: &mut F, address: u32, length: usize) -> bool {
    let [mut ones, mut zeros, mut silence] = [true; 3];
    visit(flash, address, bytes::<F>(length), &mut |chunk| {
        let is = |value: u8| chunk.is_some_and(|chunk| chunk.iter().all(|byte| *byte == value));
        (ones, zeros, silence) = (ones && is(0xff), zeros && is(0), silence && chunk.is_none());
        ones || zeros || silence
    });
    ones || zeros || silence
}

/// Reads a stretch chunk by chunk while more is wanted; `None` if the driver fails.
#[inline(never)]
fn visit<F: NorFlash>(
    flash: &mut F,
    start: u32,
    length: u32,
    each: &mut dyn FnMut(Option<&[u8]>) -> bool,
) {
    let end = start.saturating_add(length);
    let mut at = start;
    while at < end {
        let mut chunk = Chunk([0; SHORT]);
        let part = match chunk.0.get_mut(..to_usize(end.saturating_sub(at))) {
            Some(part) => part,
            None => &mut chunk.0,
        };
        let is_read = flash.read(at, part).is_ok();
        if !each(is_read.then_some(part)) {
            break;
        }
        at = at.saturating_add(to_u32(SHORT));
    }
}

pub(super) fn to_u32(size: usize) -> u32 {
    u32::try_from(size).unwrap_or(u32::MAX)
}

pub(super) fn to_usize(size: u32) -> usize {
    usize::try_from(size).unwrap_or(usize::MAX)
}
