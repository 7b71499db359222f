//! Encoder of frames for matchers in software.

use super::crc::FrameCrc;
use super::header::{FrameHeader, HeaderError};
use super::layout::{CRC_BYTES, HEADER_BYTES, RECORD_BYTES};
use super::record::{EncodeError, MatchRecord};
use crate::batch::correspondence::Correspondence;

/// Encodes one frame piece by piece; holds no records.
///
/// The count of a frame precedes its records: set it to the number of matches that [`MatchRecord::encode`]
/// accepts. A refused call changes nothing. A frame that is given up costs the receiver only that frame.
///
/// ```
/// # use stereo_selfcal::{Correspondence, link::{EncodeError, Encoder, FrameHeader, HeaderError, MatchRecord}};
/// fn send(
///     header: FrameHeader,
///     matches: &[Correspondence<f32>],
///     mut put: impl FnMut(&[u8]),
/// ) -> Result<(), HeaderError> {
///     let records = matches.iter().flat_map(|m| MatchRecord::encode(m, &header)).take(u16::MAX.into());
///     let count = records.clone().map(|_| 1).sum();
///     let (mut encoder, start) = Encoder::begin(FrameHeader { count, ..header })?;
///     put(&start);
///     records.flat_map(|record| encoder.push_record(&record)).for_each(|bytes| put(&bytes));
///     put(&encoder.finish().expect("as many records as counted"));
///     Ok(())
/// }
/// # let c = Correspondence { left: [9.0, 2.0], right: [5.0, 2.0], score: 1.0, grid_step: 0.0 };
/// # let h = FrameHeader { timestamp_us: 0, sequence: 0, count: 0, image_size: [64, 48], grid_step: 0,
/// #     fraction_bits: 8, pyramid_ratio: 64, dropped_before: false, more_found: false };
/// # let mut sent = 0;
/// # send(h, &[c, Correspondence { left: [-1.0, 2.0], ..c }, c], |bytes| sent += bytes.len()).unwrap();
/// # assert_eq!(sent, 36 + 2 * 16);
/// ```
#[derive(Debug, Clone)]
pub struct Encoder {
    header: FrameHeader,
    crc: FrameCrc,
    missing: u16,
}

impl Encoder {
    /// Begins a frame; returns its first bytes, the header.
    ///
    /// # Errors
    /// [`HeaderError::FractionBits`], [`HeaderError::PyramidRatio`].
    pub fn begin(header: FrameHeader) -> Result<(Self, [u8; HEADER_BYTES]), HeaderError> {
        let bytes = header.encode()?;
        Ok((Self { header, crc: FrameCrc::new(&bytes), missing: header.count }, bytes))
    }

    /// Encodes the next match.
    ///
    /// * `correspondence`: match, in px of the image before undistortion; see [`MatchRecord::encode`].
    ///
    /// # Errors
    /// [`EncodeError::Coordinate`], [`EncodeError::Score`], [`EncodeError::GridStep`]: the match cannot
    /// be encoded; push another one in its place. [`EncodeError::Full`]: the frame has all its records.
    pub fn push(
        &mut self,
        correspondence: &Correspondence<f32>,
    ) -> Result<[u8; RECORD_BYTES], EncodeError> {
        self.push_tracked(correspondence, 0)
    }

    /// Encodes the next match, which a tracker follows.
    ///
    /// * `id`: number of the track; see [`MatchRecord::with_track`].
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn push_tracked(
        &mut self,
        correspondence: &Correspondence<f32>,
        id: u16,
    ) -> Result<[u8; RECORD_BYTES], EncodeError> {
        self.push_record(&MatchRecord::encode(correspondence, &self.header)?.with_track(id))
    }

    /// Encodes the next record.
    ///
    /// # Errors
    /// [`EncodeError::Full`]: the frame has all records that its header counts.
    pub fn push_record(&mut self, record: &MatchRecord) -> Result<[u8; RECORD_BYTES], EncodeError> {
        self.missing = self.missing.checked_sub(1).ok_or(EncodeError::Full)?;
        let bytes = record.to_bytes();
        self.crc.add(&bytes);
        Ok(bytes)
    }

    /// Returns the number of records that the frame still needs.
    #[must_use]
    pub fn missing(&self) -> u16 {
        self.missing
    }

    /// Returns the last bytes of the frame: its CRC.
    ///
    /// # Errors
    /// [`EncodeError::Missing`]: the frame needs more records. Push them, or begin the next frame: the
    /// receiver drops this one.
    pub fn finish(&self) -> Result<[u8; CRC_BYTES], EncodeError> {
        match self.missing {
            0 => Ok(self.crc.value().to_le_bytes()),
            missing => Err(EncodeError::Missing(missing)),
        }
    }
}
