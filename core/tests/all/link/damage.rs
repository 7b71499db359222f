//! Random damage: exactly the undamaged frames are received.

use crate::link::roundtrip::frames;
use crate::link::stream::{Frame, events, received, whole};
use proptest::prelude::*;
use proptest::sample::Index;
use stereo_selfcal::link::{Decoder, FrameHeader};

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

fn harms() -> impl Strategy<Value = Harm> {
    let place = any::<Index>;
    prop_oneof![
        4 => Just(Harm::None),
        1 => prop::collection::vec(place(), 1..4).prop_map(Harm::Flip),
        1 => (place(), place()).prop_map(|(from, to)| Harm::Drop(from, to)),
        1 => (place(), bytes(80)).prop_map(|(at, run)| Harm::Insert(at, run)),
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

/// Bytes on the wire, and whether the frame is still whole.
fn harmed(frame: &Frame, harm: &Harm) -> (Vec<u8>, bool) {
    let sent = frame.bytes();
    let damaged = match harm {
        Harm::None => return (sent, true),
        Harm::Idle(run) => return ([run.as_slice(), &sent].concat(), true),
        Harm::Duplicate => return ([sent.as_slice(), &sent].concat(), true),
        Harm::Repeat(bit) => {
            let hit = flipped(sent.clone(), &[*bit]);
            return ([hit, sent].concat(), true);
        }
        Harm::Flip(bits) => flipped(sent.clone(), bits),
        Harm::Drop(from, to) => {
            let (from, to) = (from.index(sent.len()), to.index(sent.len()));
            let mut left = sent.clone();
            left.drain(from.min(to)..=from.max(to));
            left
        }
        Harm::Insert(at, run) => inserted(&sent, *at, run),
        Harm::Truncate(at) => sent[..at.index(sent.len())].to_vec(),
        Harm::Splice(other) => {
            [&sent[..FrameHeader::BYTES], &other.bytes()[FrameHeader::BYTES..]].concat()
        }
        Harm::Header(at, other) => inserted(&sent, *at, &other.encode().unwrap()),
    };
    // Two flips of one bit cancel; a lost or inserted run may leave equal bytes.
    let whole = damaged == sent;
    (damaged, whole)
}

/// A stream of numbered frames, and the frames that remain whole.
fn streams() -> impl Strategy<Value = (Vec<u8>, Vec<Frame>)> {
    let each = prop::collection::vec((frames(), harms()), 1..12);
    let by_chance = "the stream contains a damaged frame as it was sent";
    (any::<u32>(), each, bytes(60)).prop_filter_map(by_chance, |(first, each, end)| {
        let (mut stream, mut through, mut lost) = (Vec::new(), Vec::new(), Vec::new());
        for (sequence, (mut frame, harm)) in each.into_iter().enumerate() {
            frame.header.sequence = first.wrapping_add(sequence as u32);
            let (bytes, whole) = harmed(&frame, &harm);
            if whole {
                through.push(frame);
            } else {
                lost.push((stream.len(), frame.bytes()));
            }
            stream.extend(bytes);
        }
        // These bytes may complete a frame that was cut off.
        stream.extend(end);
        let untouched = |(at, sent): &(usize, Vec<u8>)| {
            stream[*at..].windows(sent.len()).any(|run| run == sent)
        };
        (!lost.iter().any(untouched)).then_some((stream, through))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(test_support::runs(400, 2000)))]

    #[test]
    fn exactly_the_undamaged_frames_are_received((stream, through) in streams()) {
        let (frames, _, decoder) = received(&stream);
        prop_assert_eq!(decoder.counters().good as usize, through.len());
        prop_assert_eq!(frames, through);
    }

    #[test]
    fn events_do_not_depend_on_the_pieces_of_the_stream(
        (stream, _) in streams(),
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
    fn after_any_bytes_the_next_frame_is_received(noise in bytes(400), frame in frames()) {
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
fn a_decoder_takes_less_than_256_bytes() {
    assert!(size_of::<Decoder>() < 256, "{}", size_of::<Decoder>());
}
