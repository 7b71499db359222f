//! Layout 1 of an entry, little endian.
//!
//! | bytes | content |
//! |---|---|
//! | 0 | magic `SSC`, layout `1` |
//! | 4 | sequence number, `u64` |
//! | 12 | erasures of pages so far, `u32` |
//! | 16 | kind; flags: 1 copy of an older entry, 2 the kind is removed |
//! | 18 | length of the payload, `u16` |
//! | 20 | CRC-32 of these 20 bytes and of the address, so that an entry counts only where it belongs |
//! | 24 | payload |
//! | | `ff` up to the last 4 bytes of a whole word |
//! | end | CRC-32 of kind, flag 2, length and payload |
//!
//! Both are CRC-32/ISO-HDLC: they find every error of one byte.

use super::pages::Pages;
use crate::codec::RecordKind;
use crate::codec::checksum::{self, Checksum};

pub(super) const HEADER: usize = 24;
pub(super) const TAIL: usize = 4;
const MAGIC: [u8; 3] = *b"SSC";
const LAYOUT: u8 = 1;
const COPY: u8 = 1;
const REMOVED: u8 = 2;

/// One value for each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PerKind<V> {
    pub(super) factory: V,
    pub(super) state: V,
}

impl<V> PerKind<V> {
    pub(super) fn of(&self, kind: RecordKind) -> &V {
        match kind {
            RecordKind::Factory => &self.factory,
            RecordKind::State => &self.state,
        }
    }

    pub(super) fn of_mut(&mut self, kind: RecordKind) -> &mut V {
        match kind {
            RecordKind::Factory => &mut self.factory,
            RecordKind::State => &mut self.state,
        }
    }
}

/// What an entry is about; the same for all its copies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryMeta {
    pub(super) kind: RecordKind,
    /// The kind is removed: no payload.
    pub(super) removed: bool,
    pub(super) length: u16,
}

impl EntryMeta {
    /// Bytes of the entry in flash.
    pub(super) fn bytes(self, pages: &Pages) -> u32 {
        pages.rounded(u32::from(self.length).saturating_add(28))
    }

    /// CRC of kind, flag and length, to go on with the payload.
    pub(super) fn digest(self) -> Checksum {
        let [low, high] = self.length.to_le_bytes();
        let flags = if self.removed { REMOVED } else { 0 };
        let mut digest = checksum::begin();
        digest.update(&[self.kind.number(), flags, low, high]);
        digest
    }
}

/// The header of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) sequence: u64,
    pub(super) erasures: u32,
    pub(super) meta: EntryMeta,
    /// A copy of an entry that is, or was, elsewhere.
    pub(super) copy: bool,
}

/// What the bytes at an address are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecodedHeader {
    Entry(Header),
    /// A header of another layout, or of a kind that came later.
    Unsupported,
    None,
}

impl Header {
    /// As it is in flash at an address.
    pub(super) fn encoded(&self, address: u32) -> [u8; HEADER] {
        let meta = &self.meta;
        let copy = if self.copy { COPY } else { 0 };
        let flags = copy | if meta.removed { REMOVED } else { 0 };
        let mut bytes = [0; HEADER];
        let fields = (MAGIC.into_iter().chain([LAYOUT]))
            .chain(self.sequence.to_le_bytes())
            .chain(self.erasures.to_le_bytes())
            .chain([meta.kind.number(), flags])
            .chain(meta.length.to_le_bytes());
        bytes.iter_mut().zip(fields).for_each(|(to, from)| *to = from);
        if let Some((fields, crc)) = bytes.split_last_chunk_mut() {
            *crc = checksum(fields, address);
        }
        bytes
    }

    /// What there is at an address.
    pub(super) fn decode(bytes: &[u8; HEADER], address: u32) -> DecodedHeader {
        Self::fields(bytes, address).unwrap_or(DecodedHeader::None)
    }

    fn fields(bytes: &[u8; HEADER], address: u32) -> Option<DecodedHeader> {
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
        let kind = RecordKind::ALL.into_iter().find(|k| k.number() == *kind);
        let (true, Some(kind)) = (*layout == LAYOUT, kind) else {
            return Some(DecodedHeader::Unsupported);
        };
        let removed = flags & REMOVED != 0;
        // The last number has none after it: no flash lives to see it.
        let sequence = Some(u64::from_le_bytes(*sequence)).filter(|n| *n < u64::MAX)?;
        Some(DecodedHeader::Entry(Self {
            sequence,
            erasures: u32::from_le_bytes(*erasures),
            meta: EntryMeta { kind, removed, length: u16::from_le_bytes(*length) },
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
