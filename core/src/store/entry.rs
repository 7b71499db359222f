//! Layout 1 of an entry, little endian.
//!
//! | bytes | content |
//! |---|---|
//! | 0 | magic `SSC`, layout `1` |
//! | 4 | sequence number, `u64` |
//! | 12 | erasures of pages so far, `u32` |
//! | 16 | kind; flags: 1 copy of an older entry, 2 the kind is forgotten |
//! | 18 | length of the payload, `u16` |
//! | 20 | CRC-32 of these 20 bytes and of the address, so that an entry counts only where it belongs |
//! | 24 | payload |
//! | | `ff` up to the last 4 bytes of a whole word |
//! | end | CRC-32 of kind, flag 2, length and payload |
//!
//! Both are CRC-32/ISO-HDLC: they find every error of one byte.

use super::pages::Pages;
use crate::codec::checksum::{self, Checksum};

pub(super) const HEADER: usize = 24;
pub(super) const TAIL: usize = 4;
const MAGIC: [u8; 3] = *b"SSC";
const LAYOUT: u8 = 1;
const COPY: u8 = 1;
const FORGOTTEN: u8 = 2;

/// What a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Kind {
    /// Written once in production: what the rig was measured to be.
    Factory,
    /// What the calibrator has learnt since.
    State,
}

/// Kinds there are.
pub(super) const KINDS: [Kind; 2] = [Kind::Factory, Kind::State];

impl Kind {
    /// Its number in flash, for good.
    const fn wire(self) -> u8 {
        match self {
            Self::Factory => 1,
            Self::State => 2,
        }
    }
}

/// One value for each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PerKind<V> {
    pub(super) factory: V,
    pub(super) state: V,
}

impl<V> PerKind<V> {
    pub(super) fn of(&self, kind: Kind) -> &V {
        match kind {
            Kind::Factory => &self.factory,
            Kind::State => &self.state,
        }
    }

    pub(super) fn of_mut(&mut self, kind: Kind) -> &mut V {
        match kind {
            Kind::Factory => &mut self.factory,
            Kind::State => &mut self.state,
        }
    }
}

/// What an entry is about; the same for all its copies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Subject {
    pub(super) kind: Kind,
    /// The kind is forgotten: no payload.
    pub(super) forgotten: bool,
    pub(super) length: u16,
}

impl Subject {
    /// Bytes of the entry in flash.
    pub(super) fn bytes(self, pages: &Pages) -> u32 {
        pages.rounded(u32::from(self.length).saturating_add(28))
    }

    /// CRC of kind, flag and length, to go on with the payload.
    pub(super) fn digest(self) -> Checksum {
        let [low, high] = self.length.to_le_bytes();
        let flags = if self.forgotten { FORGOTTEN } else { 0 };
        let mut digest = checksum::begin();
        digest.update(&[self.kind.wire(), flags, low, high]);
        digest
    }
}

/// The header of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) sequence: u64,
    pub(super) erasures: u32,
    pub(super) subject: Subject,
    /// A copy of an entry that is, or was, elsewhere.
    pub(super) copy: bool,
}

/// What the bytes at an address are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    Entry(Header),
    /// A header of another layout, or of a kind that came later.
    Foreign,
    Nothing,
}

impl Header {
    /// As it is in flash at an address.
    pub(super) fn encoded(&self, address: u32) -> [u8; HEADER] {
        let subject = &self.subject;
        let copy = if self.copy { COPY } else { 0 };
        let flags = copy | if subject.forgotten { FORGOTTEN } else { 0 };
        let mut bytes = [0; HEADER];
        let fields = (MAGIC.into_iter().chain([LAYOUT]))
            .chain(self.sequence.to_le_bytes())
            .chain(self.erasures.to_le_bytes())
            .chain([subject.kind.wire(), flags])
            .chain(subject.length.to_le_bytes());
        bytes.iter_mut().zip(fields).for_each(|(to, from)| *to = from);
        if let Some((fields, crc)) = bytes.split_last_chunk_mut() {
            *crc = checksum(fields, address);
        }
        bytes
    }

    /// What there is at an address.
    pub(super) fn decode(bytes: &[u8; HEADER], address: u32) -> Found {
        Self::fields(bytes, address).unwrap_or(Found::Nothing)
    }

    fn fields(bytes: &[u8; HEADER], address: u32) -> Option<Found> {
        let (fields, crc) = bytes.split_last_chunk()?;
        let (magic, rest) = fields.split_first_chunk()?;
        if *magic != MAGIC || *crc != checksum(fields, address) {
            return None;
        }
        let (layout, rest) = rest.split_first()?;
        let (sequence, rest) = rest.split_first_chunk()?;
        let (erasures, rest) = rest.split_first_chunk()?;
        let ([kind, flags], rest) = rest.split_first_chunk()?;
        let (length, _) = rest.split_first_chunk()?;
        let kind = KINDS.into_iter().find(|k| k.wire() == *kind);
        let (true, Some(kind)) = (*layout == LAYOUT, kind) else { return Some(Found::Foreign) };
        let forgotten = flags & FORGOTTEN != 0;
        // The last number has none after it: no flash lives to see it.
        let sequence = Some(u64::from_le_bytes(*sequence)).filter(|n| *n < u64::MAX)?;
        Some(Found::Entry(Self {
            sequence,
            erasures: u32::from_le_bytes(*erasures),
            subject: Subject { kind, forgotten, length: u16::from_le_bytes(*length) },
            copy: flags & COPY != 0,
        }))
    }
}

fn checksum(fields: &[u8], address: u32) -> [u8; 4] {
    let mut digest = checksum::begin();
    digest.update(fields);
    digest.update(&address.to_le_bytes());
    digest.finalize().to_le_bytes()
}
