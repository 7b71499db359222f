//! Frames of the tests.

use std::vec::Vec;

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{FrameCrc, FrameHeader, MatchRecord};

/// The `i`-th match. All are different, and their scene makes all directions observable.
pub(crate) fn correspondence(i: u16) -> Correspondence<f32> {
    let [u, v] = [i * 37 % 900 + 700, i * 71 % 1100].map(f32::from);
    let disparity = f32::from(i * 13 % 97) + 20.0;
    Correspondence {
        left: [u, v],
        right: [u - disparity, v + 1.5],
        // A value of the wire, so that it is not rounded.
        score: 13_107.0 / 65_535.0,
        grid_step: 1.0 / 256.0,
    }
}

/// Encodes a frame of these matches, of images of 1920 x 1200 px.
pub(crate) fn frame(sequence: u32, matches: impl ExactSizeIterator<Item = u16>) -> Vec<u8> {
    let header = FrameHeader {
        timestamp_us: 0,
        sequence,
        count: matches.len().try_into().expect("within a frame"),
        image_size: [1920, 1200],
        grid_step: 0,
        fraction_bits: 8,
        pyramid_ratio: 64,
        dropped_before: false,
        more_found: false,
    };
    let mut bytes = header.encode().expect("a valid header").to_vec();
    let mut crc = FrameCrc::new(bytes.first_chunk().expect("of a header's length"));
    for i in matches {
        let record = MatchRecord::encode(&correspondence(i), &header).expect("in range").to_bytes();
        crc.add(&record);
        bytes.extend(record);
    }
    bytes.extend(crc.value().to_le_bytes());
    bytes
}
