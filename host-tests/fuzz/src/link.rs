//! Arbitrary streams: the decoder with any cut, and a calibrator as its sink.

use arbitrary::{Arbitrary, Unstructured};
use stereo_selfcal::depth::Tracks;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::link::{
    Counters, Decoder, Event, FrameCrc, FrameHeader, MatchRecord, Tracking,
};
use stereo_selfcal::{Correspondence, FactoryCalibration, State};

use super::check::{check_estimate, check_in_use};
use super::{Target, configured, plausible, solve, usual_cameras};

/// Largest number of records of a generated frame: more than the 32 that the batch holds.
const MOST: usize = 48;

/// A match and its track.
type Sent = (Correspondence<f32>, u16);

/// Next item on the wire.
#[derive(Debug, Clone, Arbitrary)]
enum Piece {
    /// Any bytes.
    Raw(Vec<u8>),
    /// A frame.
    Frame(Content),
    /// A frame with some bits of one byte flipped, or none.
    Damaged(Content, u16, u8),
    /// A frame without a run of its bytes.
    Cut(Content, u16, u16),
    /// The first bytes of a frame, then another frame.
    Interrupted(Content, u16, Content),
    /// The last whole frame of `Frame` again; nothing before the first.
    Again,
}

/// Content of a frame.
#[derive(Debug, Clone, Arbitrary)]
struct Content {
    sequence: u8,
    timestamp: u64,
    fraction_bits: u8,
    pyramid_ratio: u8,
    grid_step: u16,
    flags: [bool; 2],
    /// Image size; `None` for the size of the usual cameras.
    size: Option<[u16; 2]>,
    /// Whether it has plausible matches instead of arbitrary records.
    usual: bool,
    /// Whether plausible matches have tracks.
    tracked: bool,
    records: Vec<[u8; MatchRecord::BYTES]>,
}

impl Content {
    fn bytes(&self) -> Vec<u8> {
        let records = &self.records[..self.records.len().min(MOST)];
        let header = FrameHeader {
            timestamp_us: self.timestamp,
            sequence: u32::from(self.sequence).wrapping_sub(3),
            count: records.len().try_into().expect("few"),
            image_size: self.size.unwrap_or([640, 480]),
            grid_step: if self.usual { 0 } else { self.grid_step },
            fraction_bits: if self.usual { 8 } else { self.fraction_bits % 9 },
            pyramid_ratio: if self.usual { 64 } else { self.pyramid_ratio.max(64) },
            dropped_before: self.flags[0],
            more_found: self.flags[1],
        };
        let start = header.encode().expect("fraction bits and ratio are in range");
        let mut crc = FrameCrc::new(&start);
        let mut bytes = start.to_vec();
        for record in records {
            let [a, b, c, d, track, ..] = *record;
            let track = if self.tracked { track } else { 0 };
            let usual = MatchRecord::encode(&plausible([a, b, c, d / 16]), &header)
                .map(|record| record.with_track(track.into()));
            let record =
                usual.ok().filter(|_| self.usual).map_or(*record, |usual| usual.to_bytes());
            crc.add(&record);
            bytes.extend(record);
        }
        bytes.extend(crc.value().to_le_bytes());
        bytes
    }
}

/// The bytes of the pieces that `input` stands for.
fn stream(input: &mut Unstructured<'_>) -> Vec<u8> {
    let (mut stream, mut last) = (Vec::new(), Vec::new());
    while let Ok(piece) = Piece::arbitrary(input) {
        match piece {
            Piece::Raw(bytes) => stream.extend(bytes),
            Piece::Frame(content) => {
                last = content.bytes();
                stream.extend(&last);
            }
            Piece::Damaged(content, at, change) => {
                let mut bytes = content.bytes();
                let at = usize::from(at) % bytes.len();
                bytes[at] ^= change;
                stream.extend(bytes);
            }
            Piece::Cut(content, from, run) => {
                let mut bytes = content.bytes();
                let from = usize::from(from) % bytes.len();
                let to = bytes.len().min(from + usize::from(run));
                bytes.drain(from..to);
                stream.extend(bytes);
            }
            Piece::Interrupted(content, at, next) => {
                let bytes = content.bytes();
                stream.extend(&bytes[..usize::from(at) % bytes.len()]);
                stream.extend(next.bytes());
            }
            Piece::Again => stream.extend(&last),
        }
        if input.is_empty() {
            break;
        }
    }
    stream
}

/// Decodes the stream that `bytes` stand for, whole and in pieces.
///
/// # Panics
/// If the decoder violates a property.
pub fn run_decoder(bytes: &[u8]) {
    let mut input = Unstructured::new(bytes);
    let cuts = <[u8; 4]>::arbitrary(&mut input).unwrap_or_default();
    let stream = stream(&mut input);
    let whole = decode(&stream, &[usize::MAX]);
    let pieces = decode(&stream, &cuts.map(|cut| usize::from(cut) + 1));
    assert_eq!(whole, pieces, "cuts matter");
    check_order(&whole.0, &stream);
}

fn decode(mut stream: &[u8], cuts: &[usize]) -> (Vec<Event>, Counters) {
    let (mut decoder, mut events) = (Decoder::new(), Vec::new());
    for cut in cuts.iter().cycle() {
        let (mut piece, rest) = stream.split_at((*cut).min(stream.len()));
        while let Some(event) = decoder.next(&mut piece) {
            events.push(event);
        }
        assert!(piece.is_empty(), "bytes are left");
        stream = rest;
        if stream.is_empty() {
            break;
        }
    }
    (events, *decoder.counters())
}

/// Checks that each frame that starts also ends, and that the stream contains each frame that is handed out.
fn check_order(events: &[Event], stream: &[u8]) {
    let mut open: Option<(FrameHeader, Vec<Sent>)> = None;
    for event in events {
        match event {
            Event::Started(header) => {
                assert!(open.replace((*header, Vec::new())).is_none(), "a frame within a frame");
            }
            Event::Match(m, track) => {
                let numbers = [m.left[0], m.left[1], m.right[0], m.right[1], m.grid_step];
                assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{m:?}");
                assert!((0.0..=1.0).contains(&m.score), "{m:?}");
                open.as_mut().expect("a frame has begun").1.push((*m, *track));
            }
            Event::Discarded => assert!(open.take().is_some(), "nothing to discard"),
            Event::Finished(header) => {
                let (begun, matches) = open.take().expect("a frame has begun");
                assert_eq!((begun, usize::from(header.count)), (*header, matches.len()));
                assert!(is_in(stream, header, &matches), "{header:?} was not sent");
            }
        }
    }
}

fn is_in(stream: &[u8], header: &FrameHeader, matches: &[Sent]) -> bool {
    let start = header.encode().expect("it was decoded");
    stream.windows(header.frame_bytes()).filter(|frame| frame.starts_with(&start)).any(|frame| {
        let mut crc = FrameCrc::new(&start);
        let (records, end) = frame[FrameHeader::BYTES..].as_chunks::<{ MatchRecord::BYTES }>();
        let same = records.iter().zip(matches).all(|(record, m)| {
            crc.add(record);
            let record = MatchRecord::from_bytes(record);
            (record.decode(header), record.track()) == *m
        });
        same && crc.value().to_le_bytes() == *end
    })
}

/// Feeds the stream that `bytes` encode to a calibrator that solves, fuses, applies, and restarts.
///
/// # Panics
/// If the decoder or the calibrator violates a property.
pub fn run_frames(bytes: &[u8]) {
    let mut input = Unstructured::new(bytes);
    let config = configured(&mut input).config;
    let acts = <[u8; 8]>::arbitrary(&mut input).unwrap_or_default();
    let stream = stream(&mut input);
    let made = FactoryCalibration::guess(usual_cameras([0; 5], false).expect("usual cameras"));
    let fresh = || Target::new(config, &made);
    let (mut calibrator, mut decoder, mut rest) = (fresh(), Decoder::new(), &stream[..]);
    let mut tracks = Tracks::<f32, 32>::new();
    let mut acts = acts.iter().cycle();
    loop {
        let mut sink = Tracking { calibrator: &mut calibrator, tracks: Some(&mut tracks) };
        match decoder.feed(&mut rest, &mut sink) {
            Err(_) => continue,
            Ok(None) => break,
            Ok(Some(received)) => {
                assert_eq!(received.taken, calibrator.batch().matches().len());
                assert!(received.taken <= received.header.count.into());
            }
        }
        let act = acts.next().copied().unwrap_or_default();
        // A frame that arrives while a pair is being solved is refused. `act & 2` leaves the pair unfinished.
        if act & 1 == 0 {
            let _ = solve(&mut calibrator);
        } else if calibrator.advance_pair().is_none() && act & 2 == 0 {
            calibrator.discard_pair();
        }
        assert!(tracks.quads().len() <= 32);
        let _ = if act & 16 == 0 {
            Some(calibrator.push_tracks(&mut tracks))
        } else {
            calibrator.advance_tracks(&mut tracks)
        };
        if act & 4 != 0 {
            let _ = calibrator.apply();
        }
        if act & 8 != 0 {
            calibrator.discard_pair();
            calibrator = restarted(&calibrator, fresh());
        }
        check_in_use(&calibrator, &made);
        if let Some(estimate) = calibrator.proposal() {
            check_estimate(&estimate);
        }
    }
}

/// The calibrator after a loss of power.
pub(super) fn restarted(before: &Target, mut fresh: Target) -> Target {
    let record = before.snapshot();
    if fresh.restore(&record).is_ok() {
        let [old, new] = [before, &fresh].map(|c| c.in_use().extrinsics);
        let apart = Deviation::between(&old, &new);
        assert!(apart.rotation.max(apart.translation) < 1e-5, "{apart:?}");
        assert_ne!(fresh.state(), State::Locked);
    }
    fresh
}
