//! A record in flash: sequence number, record, CRC-32 of both; in whole words.

use embedded_storage::nor_flash::NorFlash;

use crate::checksum::of_record;

/// Bytes of the longest word, and of the longest slot.
const LONGEST: usize = 512;

/// Bytes of an access that compares, where a word is not longer.
const CHUNK: usize = 64;

/// Bytes before the record.
const HEAD: usize = 4;

/// The content of a slot. Aligned: drivers hand it to DMA, or write it word by word.
#[repr(align(8))]
pub(super) struct Slot([u8; LONGEST]);

/// Bytes of a slot for a record of this length.
pub(super) fn bytes<F: NorFlash>(record: usize) -> usize {
    const {
        assert!(LONGEST.is_multiple_of(F::WRITE_SIZE), "words up to 512 bytes");
        assert!(F::WRITE_SIZE.is_multiple_of(F::READ_SIZE), "a word is read in whole reads");
    }
    let whole = record.saturating_add(2 * HEAD);
    whole.checked_next_multiple_of(F::WRITE_SIZE).unwrap_or(LONGEST)
}

impl Slot {
    pub(super) const fn erased() -> Self {
        Self([0xff; LONGEST])
    }

    /// Place of a record of this length.
    pub(super) fn record(&mut self, length: usize) -> &mut [u8] {
        self.0.get_mut(HEAD..length.saturating_add(HEAD)).unwrap_or_default()
    }

    /// Adds sequence number and checksum.
    #[inline(never)]
    pub(super) fn seal(&mut self, sequence: u32, length: usize) {
        if let Some(head) = self.0.first_chunk_mut() {
            *head = sequence.to_le_bytes();
        }
        let (content, rest) = self.split(length);
        let sum = of_record(content);
        if let Some(tail) = rest.first_chunk_mut() {
            *tail = sum.to_le_bytes();
        }
    }

    fn split(&mut self, length: usize) -> (&mut [u8], &mut [u8]) {
        self.0.split_at_mut_checked(length.saturating_add(HEAD)).unwrap_or_default()
    }

    /// Sequence number, if the content is intact.
    #[inline(never)]
    fn sequence(&mut self, length: usize) -> Option<u32> {
        let sequence = u32::from_le_bytes(*self.0.first_chunk()?);
        // Erased flash, and a line stuck at 0, are no record.
        if sequence == 0 || sequence == u32::MAX {
            return None;
        }
        let (content, rest) = self.split(length);
        let sum = of_record(content);
        (u32::from_le_bytes(*rest.first_chunk()?) == sum).then_some(sequence)
    }

    /// Reads a slot; returns its sequence number if the record is intact.
    #[inline(never)]
    pub(super) fn read<F: NorFlash>(
        &mut self,
        flash: &mut F,
        address: u32,
        length: usize,
    ) -> Option<u32> {
        let content = self.0.get_mut(..bytes::<F>(length))?;
        flash.read(address, content).ok()?;
        self.sequence(length)
    }

    /// Writes a sealed slot onto erased words, and reads it back; returns whether it is there.
    ///
    /// # Errors
    /// Errors of the driver.
    #[inline(never)]
    pub(super) fn write<F: NorFlash>(
        &self,
        flash: &mut F,
        address: u32,
        length: usize,
    ) -> Result<bool, F::Error> {
        let content = self.0.get(..bytes::<F>(length)).unwrap_or_default();
        flash.write(address, content)?;
        let mut parts = content.chunks(chunk::<F>());
        let mut is_same = true;
        visit(flash, address, content.len(), &mut |found| {
            is_same &= found.is_some() && found == parts.next();
            is_same
        });
        Ok(is_same)
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

/// Bytes of an access of [`visit`].
fn chunk<F: NorFlash>() -> usize {
    F::WRITE_SIZE.max(CHUNK)
}

/// Reads a stretch chunk by chunk while more is wanted; `None` if the driver fails.
#[inline(never)]
fn visit<F: NorFlash>(
    flash: &mut F,
    start: u32,
    length: usize,
    each: &mut dyn FnMut(Option<&[u8]>) -> bool,
) {
    let (mut at, mut left, mut buffer) = (start, length, Slot::erased());
    while left > 0 {
        let part = buffer.0.get_mut(..left.min(chunk::<F>())).unwrap_or_default();
        let is_read = flash.read(at, part).is_ok();
        if !each(is_read.then_some(part)) {
            break;
        }
        at = at.saturating_add(to_u32(part.len()));
        left = left.saturating_sub(chunk::<F>());
    }
}

pub(super) fn to_u32(size: usize) -> u32 {
    u32::try_from(size).unwrap_or(u32::MAX)
}
