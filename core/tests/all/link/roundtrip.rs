//! Encoding and decoding of headers, records and frames.

use crate::link::stream::{Frame, HEADER, events, received};
use proptest::prelude::*;
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{
    Decoder, EncodeError, Encoder, Event, FrameHeader, HeaderError, MatchRecord,
};

prop_compose! {
    pub(crate) fn headers()(
        (timestamp_us, sequence) in any::<(u64, u32)>(),
        image_size: [u16; 2],
        grid_step: u16,
        fraction_bits in 0..=8_u8,
        pyramid_ratio in 64..=255_u8,
        (dropped_before, more_found) in any::<(bool, bool)>(),
    ) -> FrameHeader {
        FrameHeader {
            timestamp_us, sequence, count: 0, image_size, grid_step, fraction_bits, pyramid_ratio,
            dropped_before, more_found,
        }
    }
}

prop_compose! {
    pub(crate) fn records()(bytes: [u8; 16]) -> MatchRecord {
        MatchRecord::from_bytes(&bytes)
    }
}

prop_compose! {
    /// Any frame of fewer than 40 matches.
    pub(crate) fn frames()(
        header in headers(),
        records in prop::collection::vec(records(), 0..40),
    ) -> Frame {
        let header = FrameHeader { count: records.len() as u16, ..header };
        Frame { header, matches: records.iter().map(|record| record.decode(&header)).collect() }
    }
}

proptest! {
    #[test]
    fn a_frame_is_received_bit_identical(frame in frames()) {
        let (frames, discarded, _) = received(&frame.bytes());
        prop_assert_eq!((frames, discarded), (vec![frame], 0));
    }

    #[test]
    fn a_correspondence_moves_by_half_a_step_at_most(
        header in headers(),
        left in prop::array::uniform2(0.0..4096.0_f32),
        right in prop::array::uniform2(0.0..4096.0_f32),
        score in 0.0..=1.0_f32,
        level in 0..=15_u8,
    ) {
        let sent = Correspondence { left, right, score, grid_step: header.grid_step_px(level) };
        let seen = MatchRecord::encode(&sent, &header).unwrap().decode(&header);
        let step = 1.0 / f32::from(1_u16 << header.fraction_bits);
        for (a, b) in sent.left.iter().chain(&sent.right).zip(seen.left.iter().chain(&seen.right)) {
            prop_assert!((a - b).abs() <= step * 0.5001);
        }
        prop_assert!((score - seen.score).abs() <= 0.5001 / 65_535.0);
        prop_assert_eq!(seen.grid_step, sent.grid_step);
    }

    #[test]
    fn a_header_with_any_bit_flipped_is_refused(header in headers(), bit in 0..256_usize) {
        let mut bytes = header.encode().unwrap();
        prop_assert_eq!(FrameHeader::decode(&bytes), Ok(header));
        bytes[bit / 8] ^= 1 << (bit % 8);
        let expected = if bit < 32 { HeaderError::Magic } else { HeaderError::Crc };
        prop_assert_eq!(FrameHeader::decode(&bytes), Err(expected));
    }
}

#[test]
fn a_header_out_of_range_is_refused_with_the_field() {
    let bits = FrameHeader { fraction_bits: 9, ..HEADER };
    assert_eq!(bits.encode(), Err(HeaderError::FractionBits(9)));
    let ratio = FrameHeader { pyramid_ratio: 63, ..HEADER };
    assert_eq!(ratio.encode(), Err(HeaderError::PyramidRatio(63)));
}

#[test]
fn a_header_outside_version_1_is_refused_with_the_field() {
    let with = |at: usize, value: u8| {
        let mut bytes = HEADER.encode().unwrap();
        bytes[at] = value;
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes[..28]);
        bytes[28..].copy_from_slice(&crc.to_le_bytes());
        FrameHeader::decode(&bytes)
    };
    assert_eq!(with(4, 2), Err(HeaderError::Version(2)));
    assert_eq!(with(5, 4), Err(HeaderError::Flags(4)));
    assert_eq!(with(6, 9), Err(HeaderError::FractionBits(9)));
    assert_eq!(with(7, 63), Err(HeaderError::PyramidRatio(63)));
}

proptest! {
    #[test]
    fn any_bytes_are_a_record_of_level_and_track(bytes: [u8; 16], id: u16) {
        let record = MatchRecord::from_bytes(&bytes);
        prop_assert_eq!(record.to_bytes(), bytes);
        prop_assert_eq!(record.track(), u16::from_le_bytes([bytes[14], bytes[15]]) >> 4);
        let other = record.with_track(id);
        prop_assert_eq!(other.track(), id % 4096);
        prop_assert_eq!(other.with_track(record.track()), record);
        prop_assert_eq!(other.decode(&HEADER), record.decode(&HEADER));
    }

    #[test]
    fn a_track_is_received_with_its_match(
        header in headers(),
        records in prop::collection::vec(records(), 0..40),
    ) {
        let header = FrameHeader { count: records.len() as u16, ..header };
        let (mut encoder, mut bytes) = Encoder::begin(header).map(|(e, start)| (e, start.to_vec())).unwrap();
        bytes.extend(records.iter().flat_map(|record| encoder.push_record(record).unwrap()));
        bytes.extend(encoder.finish().unwrap());
        let sent: Vec<_> = records.iter().map(|r| (r.decode(&header), r.track())).collect();
        // In one piece, and byte by byte.
        for piece in [bytes.len(), 1] {
            let events = events(&mut Decoder::new(), bytes.chunks(piece));
            let matches = events.iter().filter_map(|event| match event {
                Event::Match(c, track) => Some((*c, *track)),
                _ => None,
            });
            prop_assert_eq!(matches.collect::<Vec<_>>(), sent.clone());
        }
    }
}

#[test]
fn a_match_without_a_track_is_sent_as_track_0() {
    let c = Correspondence { left: [9.0; 2], right: [8.0; 2], score: 1.0, grid_step: 1.0 };
    assert_eq!(MatchRecord::encode(&c, &HEADER).unwrap().track(), 0);
    let header = FrameHeader { count: 2, ..HEADER };
    let mut encoder = Encoder::begin(header).unwrap().0;
    let [plain, tracked] = [encoder.push(&c), encoder.push_tracked(&c, 5000)].map(Result::unwrap);
    assert_eq!(MatchRecord::from_bytes(&plain).track(), 0);
    assert_eq!(MatchRecord::from_bytes(&tracked).track(), 5000 % 4096);
    assert_eq!(plain[..14], tracked[..14]);
}

#[test]
fn a_match_that_does_not_fit_a_record_is_refused_with_the_quantity() {
    let good = Correspondence { left: [1.0; 2], right: [1.0; 2], score: 1.0, grid_step: 1.0 };
    assert!(MatchRecord::encode(&good, &HEADER).is_ok());
    for bad in [-0.1, 65_536.0, f32::NAN, f32::INFINITY] {
        let refused = |c| MatchRecord::encode(&c, &HEADER).unwrap_err();
        let at = [1.0, bad];
        assert_eq!(refused(Correspondence { left: at, ..good }), EncodeError::Coordinate, "{bad}");
        assert_eq!(refused(Correspondence { right: at, ..good }), EncodeError::Coordinate, "{bad}");
        assert_eq!(refused(Correspondence { score: bad, ..good }), EncodeError::Score, "{bad}");
        let grid_step = Correspondence { grid_step: bad, ..good };
        assert_eq!(refused(grid_step), EncodeError::GridStep, "{bad}");
    }
}

#[test]
fn a_grid_step_maps_to_the_nearest_level_within_a_sixteenth() {
    // Grid steps of a pyramid with a ratio of exactly 1.2.
    for level in 0..=15_u8 {
        assert_eq!(HEADER.level_of(1.2_f32.powi(level.into())), Some(level));
    }
    assert_eq!(HEADER.level_of(0.9), None);
    assert_eq!(HEADER.level_of(0.0), None);
    assert_eq!(HEADER.level_of(1.1), None);
    assert_eq!(HEADER.level_of(30.0), None);
}

#[test]
fn with_a_header_grid_step_of_0_any_finer_grid_is_level_0() {
    let header = FrameHeader { grid_step: 0, fraction_bits: 4, pyramid_ratio: 64, ..HEADER };
    assert_eq!(header.grid_step_px(0), 1.0 / 16.0);
    assert_eq!(header.level_of(0.0), Some(0));
    assert_eq!(header.level_of(1.0 / 32.0), Some(0));
    assert_eq!(header.level_of(1.0 / 8.0), None);
    assert_eq!(header.level_of(-1.0), None);
}
