//! Statistics of a link.

/// Defines [`Counters`] from one list of its fields.
macro_rules! counters {
    ($($(#[$doc:meta])* $field:ident,)*) => {
        /// Statistics of a link since its decoder was created. Each count saturates.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub struct Counters {
            $($(#[$doc])* pub $field: u32,)*
        }

        impl Counters {
            pub(super) const ZERO: Self = Self { $($field: 0,)* };

            /// Returns the sum of the counts of two decoders.
            #[must_use]
            pub const fn plus(&self, other: &Self) -> Self {
                Self { $($field: self.$field.saturating_add(other.$field),)* }
            }
        }
    };
}

counters! {
    /// Whole frames, without repeats and refused frames.
    good,
    /// Frames with a wrong CRC: bytes were damaged or lost.
    bad_crc,
    /// Places where the magic is found, but the header has a wrong CRC.
    bad_header,
    /// Headers with a correct CRC whose content is not valid in version 1 of the format.
    unsupported,
    /// Frames missing between received sequence numbers.
    gaps,
    /// Whole frames with the sequence number of the last whole frame before; they are dropped.
    repeats,
    /// Backward steps of the sequence number: the sender restarted.
    restarts,
    /// Whole frames, without repeats, with the flag [`dropped_before`](super::FrameHeader::dropped_before); and
    /// overruns that the receiver reported.
    overruns,
    /// Frames that the sink refused.
    refused,
    /// Bytes skipped in search of a frame.
    skipped_bytes,
}

/// Adds 1 to a counter; saturates.
pub(super) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
