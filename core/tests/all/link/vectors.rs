//! The test frames in `core/vectors`: their bytes, and their effect on a receiver. `UPDATE_EXPECT=1` rewrites them.

use core::fmt::Write;
use std::path::Path;
use std::{env, fs};

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Decoder, Encoder, Event, FrameHeader, MatchRecord};

pub(crate) const HEADER: FrameHeader = FrameHeader {
    timestamp_us: 0,
    sequence: 0,
    count: 0,
    image_size: [1920, 1200],
    grid_step: 256,
    fraction_bits: 4,
    pyramid_ratio: 128,
    dropped_before: false,
    more_found: false,
};

fn frame(header: FrameHeader, records: &[MatchRecord]) -> Vec<u8> {
    let header = FrameHeader { count: records.len() as u16, ..header };
    let (mut encoder, start) = Encoder::begin(header).unwrap();
    let mut bytes = start.to_vec();
    bytes.extend(records.iter().flat_map(|record| encoder.push_record(record).unwrap()));
    bytes.extend(encoder.finish().unwrap());
    bytes
}

/// A frame of two matches.
fn good(sequence: u32) -> Vec<u8> {
    let header = FrameHeader { sequence, timestamp_us: 50_000 * u64::from(sequence), ..HEADER };
    let one =
        Correspondence { left: [960.0, 600.0], right: [910.5, 601.25], score: 1.0, grid_step: 1.0 };
    let two =
        Correspondence { left: [83.0, 1199.75], right: [12.0, 1198.0], score: 0.2, grid_step: 4.0 };
    frame(header, &[one, two].map(|m| MatchRecord::encode(&m, &header).unwrap()))
}

/// A frame in which timestamp, image size and scales, and coordinates, score and level of each record, are at the ends
/// of their ranges.
fn maximal() -> Vec<u8> {
    let header = FrameHeader {
        timestamp_us: u64::MAX,
        sequence: 2,
        image_size: [u16::MAX; 2],
        grid_step: u16::MAX,
        fraction_bits: 8,
        pyramid_ratio: u8::MAX,
        ..HEADER
    };
    let mut record = [0xff; MatchRecord::BYTES];
    [record[14], record[15]] = [15, 0];
    frame(header, &[MatchRecord::from_bytes(&record); 3])
}

/// A frame of two matches, the second with a track.
fn tracked() -> Vec<u8> {
    let header = FrameHeader { sequence: 1, ..HEADER };
    let one =
        Correspondence { left: [960.0, 600.0], right: [910.5, 601.25], score: 1.0, grid_step: 1.0 };
    let record = MatchRecord::encode(&one, &header).unwrap();
    frame(header, &[record, record.with_track(0x5a3)])
}

fn flipped(mut bytes: Vec<u8>, at: usize) -> Vec<u8> {
    bytes[at] ^= 0x10;
    bytes
}

fn vectors() -> [(&'static str, Vec<u8>); 9] {
    [
        ("empty", frame(HEADER, &[])),
        ("good", good(1)),
        ("maximal", maximal()),
        ("damaged_header", [flipped(good(1), 25), good(2)].concat()),
        ("damaged_body", [flipped(good(1), 40), good(2)].concat()),
        ("cut", [&good(1)[..50], &good(2), &good(3)].concat()),
        ("lost_byte", [&good(1)[..40], &good(1)[41..], &good(2)].concat()),
        ("tracked", tracked()),
        ("repeated", [good(1), good(1), good(2)].concat()),
    ]
}

/// Effect of a vector on a receiver, as text: counters, then the events.
fn meaning(name: &str, bytes: &[u8]) -> String {
    let (mut decoder, mut rest, mut events) = (Decoder::new(), bytes, String::new());
    while let Some(event) = decoder.next(&mut rest) {
        match event {
            Event::Finished(h) => writeln!(events, "whole {h:?}").unwrap(),
            Event::Match(m, 0) => writeln!(events, "match {m:?}").unwrap(),
            Event::Match(m, track) => writeln!(events, "match {m:?}, track {track}").unwrap(),
            Event::Discarded => writeln!(events, "discarded").unwrap(),
            Event::Started(h) => writeln!(events, "started, sequence {}", h.sequence).unwrap(),
        }
    }
    format!("# {name}.bin, {} bytes\n{:?}\n{events}\n", bytes.len(), decoder.counters())
}

fn expect(file: &str, content: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors").join(file);
    if env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&path, content).unwrap();
    }
    assert!(fs::read(&path).unwrap() == content, "{file} differs; UPDATE_EXPECT=1 writes it");
}

#[test]
fn the_vectors_match_the_encoder() {
    for (name, bytes) in vectors() {
        expect(&format!("{name}.bin"), &bytes);
    }
}

#[test]
fn the_vectors_mean_what_their_text_says() {
    let text: String = vectors().iter().map(|(name, bytes)| meaning(name, bytes)).collect();
    expect("meaning.txt", text.as_bytes());
}
