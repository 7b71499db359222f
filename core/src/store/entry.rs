//! Entry layout 1, little endian: one record in flash.
//!
//! | byte | content |
//! |---|---|
//! | 0 | magic `SSC`, layout `1` |
//! | 4 | sequence number, `u64`; wraps: of two the newer one is ahead by less than 2^63 |
//! | 12 | page erasures so far, `u32` |
//! | 16 | kind; flags: 1 copy of an older entry, 2 removal of the kind (tombstone) |
//! | 18 | payload length, `u16` |
//! | 20 | CRC-32 of bytes 0 to 19 and of the address: an entry is valid only where it was written |
//! | 24 | payload |
//! | | `ff` up to the last 4 bytes of a whole word |
//! | end | CRC-32 of kind, flag 2, length and payload |
//!
//! Both are CRC-32/ISO-HDLC, which detects every error confined to one byte.

use super::pages::Pages;
use crate::codec::RecordKind;
use crate::codec::checksum::{self, Checksum};

/// Length of an entry header, bytes.
pub(super) const HEADER: usize = 24;
/// Length of the CRC at the end of an entry, bytes.
pub(super) const TAIL: usize = 4;
/// Length of an entry beside its payload, bytes.
const OVERHEAD: u32 = 28;
const MAGIC: [u8; 3] = *b"SSC";
const LAYOUT: u8 = 1;
const COPY: u8 = 1;
const REMOVED: u8 = 2;

/// At most one value for each kind of record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PerKind<V> {
    factory: Option<V>,
    state: Option<V>,
}

impl<V> PerKind<V> {
    pub(super) const NONE: Self = Self { factory: None, state: None };

    pub(super) const fn has_state(&self) -> bool {
        self.state.is_some()
    }

    pub(super) fn of(&self, kind: RecordKind) -> Option<&V> {
        match kind {
            RecordKind::Factory => self.factory.as_ref(),
            RecordKind::State => self.state.as_ref(),
        }
    }

    pub(super) fn of_mut(&mut self, kind: RecordKind) -> &mut Option<V> {
        match kind {
            RecordKind::Factory => &mut self.factory,
            RecordKind::State => &mut self.state,
        }
    }
}

/// Part of a header that all copies of an entry share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryMeta {
    pub(super) kind: RecordKind,
    /// Tombstone: the kind is removed, and there is no payload.
    pub(super) removed: bool,
    /// Payload length, bytes.
    pub(super) length: u16,
}

impl EntryMeta {
    /// Length of the entry in flash, bytes.
    pub(super) fn bytes(self, pages: &Pages) -> u32 {
        pages.rounded(u32::from(self.length).saturating_add(OVERHEAD))
    }

    /// CRC of kind, flag and length, to be continued with the payload.
    pub(super) fn digest(self) -> Checksum {
        let [low, high] = self.length.to_le_bytes();
        let flags = if self.removed { REMOVED } else { 0 };
        let mut digest = checksum::begin();
        digest.update(&[self.kind.number(), flags, low, high]);
        digest
    }
}

/// Header of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryHeader {
    pub(super) sequence: u64,
    pub(super) erasures: u32,
    pub(super) meta: EntryMeta,
    /// Copy of an older entry, made when its page was opened.
    pub(super) copy: bool,
}

/// Content of flash at an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecodedHeader {
    /// Start of an entry.
    Entry(EntryHeader),
    /// Header of another layout or of an unknown kind.
    Unsupported,
    /// No header.
    None,
}

impl EntryHeader {
    /// Encodes the header for an address.
    pub(super) fn encode(&self, address: u32) -> [u8; HEADER] {
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
            *crc = header_crc(fields, address);
        }
        bytes
    }

    /// Decodes the bytes at an address.
    pub(super) fn decode(bytes: &[u8; HEADER], address: u32) -> DecodedHeader {
        Self::decode_valid(bytes, address).unwrap_or(DecodedHeader::None)
    }

    /// `None` if magic or CRC are wrong.
    fn decode_valid(bytes: &[u8; HEADER], address: u32) -> Option<DecodedHeader> {
        let (fields, crc) = bytes.split_last_chunk()?;
        let (magic, rest) = fields.split_first_chunk()?;
        if *magic != MAGIC || *crc != header_crc(fields, address) {
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
        Some(DecodedHeader::Entry(Self {
            sequence: u64::from_le_bytes(*sequence),
            erasures: u32::from_le_bytes(*erasures),
            meta: EntryMeta { kind, removed, length: u16::from_le_bytes(*length) },
            copy: flags & COPY != 0,
        }))
    }
}

fn header_crc(fields: &[u8], address: u32) -> [u8; 4] {
    let mut digest = checksum::begin();
    digest.update(fields);
    digest.update(&address.to_le_bytes());
    digest.value().to_le_bytes()
}
