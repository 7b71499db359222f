//! Random damage: exactly the frames that the wire format promises are received.

use crate::link::roundtrip::frames;
use crate::link::sink::Taken;
use crate::link::stream::{Frame, events, received, sealed, whole};
use proptest::prelude::*;
use proptest::sample::Index;
use stereo_selfcal::link::{Decoder, FrameCrc, FrameHeader, MatchRecord};

/// Damage to one frame.
#[derive(Debug, Clone)]
enum Harm {
    None,
    /// Bits are flipped.
    Flip(Vec<Index>),
    /// A run of bytes is lost.
    Drop(Index, Index),
    /// A run of bytes is inserted.
    Insert(Index, Vec<u8>),
    /// Bytes that belong to no frame precede the frame.
    Idle(Vec<u8>),
    /// The frame is sent twice.
    Duplicate,
    /// The frame is sent twice, the first time with a flipped bit.
    Repeat(Index),
    /// The end of the frame is lost.
    Truncate(Index),
    /// The header of the frame precedes the records of another frame.
    Splice(Frame),
    /// The header of another frame is inserted.
    Header(Index, FrameHeader),
}

fn bytes(longest: usize) -> impl Strategy<Value = Vec<u8>> {
    // The magic and its parts are more frequent than in random bytes.
    let byte = prop_oneof![any::<u8>(), prop::sample::select(&b"SCMF"[..])];
    let piece = prop_oneof![4 => byte.prop_map(|byte| vec![byte]), 1 => Just(b"SCMF".to_vec())];
    prop::collection::vec(piece, 1..longest).prop_map(|pieces| pieces.concat())
}

fn flips() -> impl Strategy<Value = Harm> {
    prop::collection::vec(any::<Index>(), 1..4).prop_map(Harm::Flip)
}

fn inserts() -> impl Strategy<Value = Harm> {
    (any::<Index>(), bytes(80)).prop_map(|(at, run)| Harm::Insert(at, run))
}

fn harms() -> impl Strategy<Value = Harm> {
    let place = any::<Index>;
    prop_oneof![
        4 => Just(Harm::None),
        1 => flips(),
        1 => (place(), place()).prop_map(|(from, to)| Harm::Drop(from, to)),
        1 => inserts(),
        1 => bytes(80).prop_map(Harm::Idle),
        1 => Just(Harm::Duplicate),
        1 => place().prop_map(Harm::Repeat),
        1 => place().prop_map(Harm::Truncate),
        1 => frames().prop_map(Harm::Splice),
        1 => (place(), frames()).prop_map(|(at, frame)| Harm::Header(at, frame.header)),
    ]
}

fn flipped(mut bytes: Vec<u8>, bits: &[Index]) -> Vec<u8> {
    for index in bits {
        let bit = index.index(bytes.len() * 8);
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    bytes
}

/// `bytes` with `run` inserted between two of them.
fn inserted(bytes: &[u8], at: Index, run: &[u8]) -> Vec<u8> {
    let (head, tail) = bytes.split_at(1 + at.index(bytes.len() - 1));
    [head, run, tail].concat()
}

/// Bytes on the wire.
fn harmed(frame: &Frame, harm: &Harm) -> Vec<u8> {
    let sent = frame.bytes();
    match harm {
        Harm::None => sent,
        Harm::Idle(run) => [run.as_slice(), &sent].concat(),
        Harm::Duplicate => [sent.as_slice(), &sent].concat(),
        Harm::Repeat(bit) => [flipped(sent.clone(), &[*bit]), sent].concat(),
        Harm::Flip(bits) => flipped(sent, bits),
        Harm::Drop(from, to) => {
            let (from, to) = (from.index(sent.len()), to.index(sent.len()));
            let mut left = sent;
            left.drain(from.min(to)..=from.max(to));
            left
        }
        Harm::Insert(at, run) => inserted(&sent, *at, run),
        Harm::Truncate(at) => sent[..at.index(sent.len())].to_vec(),
        Harm::Splice(other) => {
            [&sent[..FrameHeader::BYTES], &other.bytes()[FrameHeader::BYTES..]].concat()
        }
        Harm::Header(at, other) => inserted(&sent, *at, &other.encode().unwrap()),
    }
}

/// A stream of numbered frames with damage.
fn streams() -> impl Strategy<Value = Vec<u8>> {
    let each = prop::collection::vec((frames(), harms()), 1..12);
    (any::<u32>(), each, bytes(60)).prop_map(|(first, each, end)| {
        let mut stream = Vec::new();
        for (sequence, (mut frame, harm)) in each.into_iter().enumerate() {
            frame.header.sequence = first.wrapping_add(sequence as u32);
            stream.extend(harmed(&frame, &harm));
        }
        // These bytes may complete a frame that was cut off.
        stream.extend(end);
        stream
    })
}

/// The frames that a reader of the whole stream finds, with the rules of the section on damage in the wire format.
fn promised(stream: &[u8]) -> Vec<Frame> {
    let (mut frames, mut at): (Vec<Frame>, _) = (Vec::new(), 0);
    while let Some(start) = stream.get(at..).and_then(|rest| rest.first_chunk()) {
        let Ok(header) = FrameHeader::decode(start) else {
            at += 1;
            continue;
        };
        let Some(sent) = stream.get(at..at + header.frame_bytes()) else { break };
        let records = sent[FrameHeader::BYTES..].as_chunks::<{ MatchRecord::BYTES }>().0;
        at += sent.len();
        if sealed(start, records) != sent {
            at -= FrameCrc::BYTES;
            continue;
        }
        let record = |bytes| MatchRecord::from_bytes(bytes).decode(&header);
        let frame = Frame { header, matches: records.iter().map(record).collect() };
        let is_repeat = |last: &Frame| last.header.sequence == header.sequence;
        if !frames.last().is_some_and(is_repeat) {
            frames.push(frame);
        }
    }
    frames
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(test_support::runs(400, 2000)))]

    #[test]
    fn exactly_the_promised_frames_are_received(stream in streams()) {
        let (frames, _, decoder) = received(&stream);
        prop_assert_eq!(decoder.counters().good as usize, frames.len());
        prop_assert_eq!(frames, promised(&stream));
    }

    #[test]
    fn flipped_and_inserted_bytes_cost_no_other_frame(
        mut all in prop::collection::vec(frames(), 3), harm in prop_oneof![flips(), inserts()],
    ) {
        for (sequence, frame) in (0..).zip(&mut all) {
            frame.header.sequence = sequence;
        }
        let stream = [all[0].bytes(), harmed(&all[1], &harm), all[2].bytes()].concat();
        let (received, ..) = received(&stream);
        prop_assert!(received.contains(&all[0]) && received.contains(&all[2]));
    }

    #[test]
    fn a_read_of_the_wanted_bytes_is_used_up_by_one_call(stream in streams()) {
        let (mut decoder, mut sink, mut rest) = (Decoder::new(), Taken::default(), &stream[..]);
        while let Some((mut piece, others)) = rest.split_at_checked(decoder.bytes_wanted()) {
            decoder.feed(&mut piece, &mut sink).unwrap();
            prop_assert!(piece.is_empty());
            rest = others;
        }
    }

    #[test]
    fn events_do_not_depend_on_the_pieces_of_the_stream(
        stream in streams(),
        cuts in prop::collection::vec(1..70_usize, 1..40),
    ) {
        let mut at_once = Decoder::new();
        let expected = events(&mut at_once, [stream.as_slice()]);
        let mut cut = Decoder::new();
        let mut rest = stream.as_slice();
        let pieces = cuts.iter().cycle().map_while(|&length| {
            let (piece, others) = rest.split_at_checked(length).unwrap_or((rest, &[]));
            rest = others;
            (!piece.is_empty()).then_some(piece)
        });
        prop_assert_eq!(events(&mut cut, pieces), expected);
        prop_assert_eq!(cut.counters(), at_once.counters());
    }

    #[test]
    fn after_bytes_without_a_header_the_next_frame_is_received(noise in bytes(400), frame in frames()) {
        let mut decoder = Decoder::new();
        let before = events(&mut decoder, [noise.as_slice()]);
        prop_assert!(before.len() <= noise.len() / 16);
        let (frames, _) = whole(&events(&mut decoder, [frame.bytes().as_slice()]));
        prop_assert_eq!(frames, vec![frame]);
    }

    #[test]
    fn bytes_wanted_never_exceeds_the_current_frame(all in prop::collection::vec(frames(), 1..4)) {
        let mut decoder = Decoder::new();
        for (sequence, mut frame) in all.into_iter().enumerate() {
            frame.header.sequence = sequence as u32;
            let bytes = frame.bytes();
            let mut rest = bytes.as_slice();
            while !rest.is_empty() {
                let (piece, others) = rest.split_at(decoder.bytes_wanted());
                events(&mut decoder, [piece]);
                rest = others;
            }
        }
    }
}

#[test]
fn a_decoder_takes_less_than_160_bytes() {
    assert!(size_of::<Decoder>() < 160, "{}", size_of::<Decoder>());
}
