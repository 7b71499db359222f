//! The encoder against frames that the tests assemble from header, records and CRC.

use crate::link::roundtrip::{headers, records};
use crate::link::stream::{Frame, HEADER, received, sealed};
use proptest::prelude::*;
use stereo_selfcal::link::{Decoder, EncodeError, Encoder, FrameHeader, HeaderError, MatchRecord};

proptest! {
    #[test]
    fn a_frame_is_sealed_byte_for_byte(
        header in headers(),
        records in prop::collection::vec(records(), 0..40),
    ) {
        let header = FrameHeader { count: records.len() as u16, ..header };
        let (mut encoder, start) = Encoder::begin(header).unwrap();
        let mut bytes = start.to_vec();
        for (sent, record) in (0..).zip(&records) {
            prop_assert_eq!(encoder.missing(), header.count - sent);
            prop_assert_eq!(encoder.finish(), Err(EncodeError::Missing(header.count - sent)));
            bytes.extend(encoder.push_record(record).unwrap());
        }
        prop_assert_eq!(encoder.push_record(&MatchRecord::default()), Err(EncodeError::Full));
        bytes.extend(encoder.finish().unwrap());
        prop_assert_eq!(bytes.len(), header.frame_bytes());
        let records: Vec<_> = records.iter().map(MatchRecord::to_bytes).collect();
        prop_assert_eq!(bytes, sealed(&header.encode().unwrap(), &records));
    }
}

#[test]
fn a_match_out_of_range_is_refused_and_another_takes_its_place() {
    let frame = Frame::plain(0, 2);
    let (mut encoder, start) = Encoder::begin(frame.header).unwrap();
    let mut bytes = start.to_vec();
    let good = frame.matches[0];
    bytes.extend(encoder.push(&good).unwrap());
    // The largest coordinate is one step of 1/256 px below 2^24 steps.
    let largest = 65_536.0 - 1.0 / 256.0;
    for bad in [65_536.0, -1.0 / 256.0, f32::NAN, f32::INFINITY, f32::MAX] {
        for axis in 0..4 {
            let mut m = good;
            m.left.iter_mut().chain(&mut m.right).nth(axis).map(|place| *place = bad).unwrap();
            assert_eq!(encoder.push(&m), Err(EncodeError::Coordinate), "{bad}");
        }
    }
    let mut m = good;
    m.score = 1.1;
    assert_eq!(encoder.push(&m), Err(EncodeError::Score));
    m = good;
    m.grid_step = 1e6;
    assert_eq!(encoder.push(&m), Err(EncodeError::GridStep));
    m = good;
    m.left = [largest, 0.0];
    bytes.extend(encoder.push(&m).unwrap());
    bytes.extend(encoder.finish().unwrap());
    let (frames, discarded, _) = received(&bytes);
    assert_eq!((frames, discarded), (vec![Frame { matches: vec![good, m], ..frame }], 0));
}

#[test]
fn a_header_out_of_range_is_refused() {
    let begin = |header| Encoder::begin(header).map(|_| ());
    let bits = FrameHeader { fraction_bits: 9, ..HEADER };
    assert_eq!(begin(bits), Err(HeaderError::FractionBits(9)));
    let ratio = FrameHeader { pyramid_ratio: 63, ..HEADER };
    assert_eq!(begin(ratio), Err(HeaderError::PyramidRatio(63)));
}

#[test]
fn a_frame_given_up_costs_that_frame_and_the_next_one() {
    let [mut bytes, next, last] = [0, 1, 2].map(|sequence| Frame::plain(sequence, 9).bytes());
    bytes.truncate(100);
    bytes.extend([next, last].concat());
    let mut decoder = Decoder::new();
    let mut rest = bytes.as_slice();
    while decoder.next(&mut rest).is_some() {}
    let counters = decoder.counters();
    assert_eq!((counters.good, counters.bad_crc), (1, 1));
}
