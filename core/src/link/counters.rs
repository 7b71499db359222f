//! What a link has been through.

/// Counts since the decoder was made. They stay at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Counters {
    /// Frames handed out whole.
    pub good: u32,
    /// Frames whose CRC was wrong.
    pub bad_crc: u32,
    /// Starts of a frame whose header had a wrong CRC.
    pub bad_header: u32,
    /// Headers or frames with a right CRC that version 1 does not have.
    pub unsupported: u32,
    /// Frames that the next one began inside of.
    pub truncated: u32,
    /// Frames that never came whole, by the sequence numbers of those that did.
    pub gaps: u32,
    /// Frames with the sequence number of the frame before; not handed out.
    pub repeats: u32,
    /// Steps back in the sequence: the sender was restarted.
    pub restarts: u32,
    /// Whole frames before which the sender had dropped some, and what was noted of the receiver's
    /// own overruns.
    pub overruns: u32,
    /// Frames that were refused by what they were to go into.
    pub refused: u32,
    /// Bytes passed over in search of a frame.
    pub skipped_bytes: u32,
}

impl Counters {
    /// The counts of two decoders together.
    #[must_use]
    pub const fn plus(&self, other: &Self) -> Self {
        Self {
            good: self.good.saturating_add(other.good),
            bad_crc: self.bad_crc.saturating_add(other.bad_crc),
            bad_header: self.bad_header.saturating_add(other.bad_header),
            unsupported: self.unsupported.saturating_add(other.unsupported),
            truncated: self.truncated.saturating_add(other.truncated),
            gaps: self.gaps.saturating_add(other.gaps),
            repeats: self.repeats.saturating_add(other.repeats),
            restarts: self.restarts.saturating_add(other.restarts),
            overruns: self.overruns.saturating_add(other.overruns),
            refused: self.refused.saturating_add(other.refused),
            skipped_bytes: self.skipped_bytes.saturating_add(other.skipped_bytes),
        }
    }

    pub(super) const NONE: Self = Self {
        good: 0,
        bad_crc: 0,
        bad_header: 0,
        unsupported: 0,
        truncated: 0,
        gaps: 0,
        repeats: 0,
        restarts: 0,
        overruns: 0,
        refused: 0,
        skipped_bytes: 0,
    };
}

/// One more, but for the largest value.
pub(super) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
