//! Content of a slot in flash: sequence number, record and CRC-32 of both, in whole words.

use embedded_storage::nor_flash::NorFlash;

use crate::checksum::of_record;

/// Length of the longest word and of the longest slot, bytes.
const LONGEST: usize = 512;

/// Length of a read in [`is_blank`], bytes; if words are longer, a read has one word.
const CHUNK: usize = 64;

/// Length of the sequence number before the record, and of the checksum after it, bytes.
const HEAD: usize = 4;

/// Content of a slot. It is aligned to 8 bytes, because drivers pass it to DMA or write it word by word.
#[repr(align(8))]
pub(super) struct Slot([u8; LONGEST]);

/// Returns the length of a slot for a record of this length, bytes.
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

    /// Returns the place of a record of this length.
    pub(super) fn record(&mut self, length: usize) -> &mut [u8] {
        self.0.get_mut(HEAD..length.saturating_add(HEAD)).unwrap_or_default()
    }

    /// Writes the sequence number before a record of this length, and the checksum after it.
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

    /// Reads a slot; returns its sequence number if the record is intact.
    #[inline(never)]
    pub(super) fn read<F: NorFlash>(
        &mut self,
        flash: &mut F,
        address: u32,
        length: usize,
    ) -> Option<u32> {
        flash.read(address, self.0.get_mut(..bytes::<F>(length))?).ok()?;
        let sequence = u32::from_le_bytes(*self.0.first_chunk()?);
        let (content, rest) = self.split(length);
        let is_intact = u32::from_le_bytes(*rest.first_chunk()?) == of_record(content);
        // The numbers 0 and `u32::MAX` are no sequence numbers: erased flash or a data line stuck at 0 may read so.
        Some(sequence).filter(|sequence| is_intact && ![0, u32::MAX].contains(sequence))
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
        let mut found = Self::erased();
        let found = found.0.get_mut(..content.len()).unwrap_or_default();
        Ok(flash.read(address, found).is_ok() && found == content)
    }
}

/// Returns whether a slot counts as erased: it reads as all ones or all zeros, or no part of it can be read, as in
/// flash with ECC before its first write. A torn word cannot be read either, but other words of its slot can.
#[inline(never)]
pub(super) fn is_blank<F: NorFlash>(flash: &mut F, address: u32, length: usize) -> bool {
    let (mut at, mut left, mut buffer) = (address, bytes::<F>(length), Slot::erased());
    let [mut ones, mut zeros, mut silence] = [true; 3];
    let chunk = F::WRITE_SIZE.max(CHUNK);
    while left > 0 && (ones || zeros || silence) {
        let part = buffer.0.get_mut(..left.min(chunk)).unwrap_or_default();
        let is_read = flash.read(at, part).is_ok();
        let is = |value: u8| is_read && part.iter().all(|byte| *byte == value);
        (ones, zeros, silence) = (ones && is(0xff), zeros && is(0), silence && !is_read);
        at = at.saturating_add(to_u32(chunk));
        left = left.saturating_sub(chunk);
    }
    ones || zeros || silence
}

pub(super) fn to_u32(size: usize) -> u32 {
    u32::try_from(size).unwrap_or(u32::MAX)
}
