//! Exact counters for every kind of damage.

use crate::link::stream::{Frame, received};
use stereo_selfcal::link::{Counters, Damage, FrameHeader};

fn plain(sequence: u32) -> Vec<u8> {
    Frame::plain(sequence, 5).bytes()
}

/// Sequence numbers of the frames that are handed out, the damage of the frames that are discarded after an intact
/// header, and the counters.
fn through(stream: &[Vec<u8>]) -> (Vec<u32>, Vec<Damage>, Counters) {
    let (frames, damages, decoder) = received(&stream.concat());
    let sequences = frames.iter().map(|frame| frame.header.sequence).collect();
    (sequences, damages, *decoder.counters())
}

fn counters(set: impl FnOnce(&mut Counters)) -> Counters {
    let mut counters = Counters::default();
    set(&mut counters);
    counters
}

#[test]
fn a_clean_stream_yields_every_frame_and_no_other_count() {
    let frames = [Frame::plain(7, 0), Frame::plain(8, 300), Frame::plain(9, 1)];
    let (got, damages, decoder) = received(&frames.clone().map(|frame| frame.bytes()).concat());
    assert_eq!((got.as_slice(), damages), (&frames[..], vec![]));
    assert_eq!(*decoder.counters(), counters(|c| c.good = 3));
}

#[test]
fn a_flipped_bit_in_a_record_discards_the_frame_by_its_crc() {
    let mut hit = plain(2);
    hit[40] ^= 1;
    assert_eq!(
        through(&[plain(1), hit, plain(3)]),
        (vec![1, 3], vec![Damage::Crc], counters(|c| (c.good, c.bad_crc, c.gaps) = (2, 1, 1)))
    );
}

#[test]
fn a_damaged_header_is_counted_and_its_frame_skipped() {
    let mut hit = plain(2);
    hit[12] ^= 1;
    let expected = counters(|c| {
        (c.good, c.bad_header, c.gaps, c.skipped_bytes) = (2, 1, 1, 36 + 5 * 16);
    });
    assert_eq!(through(&[plain(1), hit, plain(3)]), (vec![1, 3], vec![], expected));
}

#[test]
fn a_frame_cut_short_by_the_next_is_truncated() {
    let mut short = plain(2);
    short.truncate(60);
    let expected = counters(|c| (c.good, c.truncated, c.gaps) = (2, 1, 1));
    assert_eq!(
        through(&[plain(1), short, plain(3)]),
        (vec![1, 3], vec![Damage::Truncated], expected)
    );
}

#[test]
fn a_truncated_frame_that_takes_bytes_of_the_next_header_does_not_lose_the_next() {
    for missing in 1..FrameHeader::BYTES {
        let mut short = plain(2);
        short.drain(40..40 + missing);
        let expected = counters(|c| (c.good, c.bad_crc, c.gaps) = (2, 1, 1));
        let got = through(&[plain(1), short, plain(3)]);
        assert_eq!(got, (vec![1, 3], vec![Damage::Crc], expected), "{missing}");
    }
}

#[test]
fn a_header_with_the_records_of_another_frame_fails_the_crc() {
    let spliced = [&plain(2)[..32], &plain(3)[32..]].concat();
    let expected = counters(|c| (c.good, c.bad_crc, c.gaps) = (2, 1, 2));
    assert_eq!(through(&[plain(1), spliced, plain(4)]), (vec![1, 4], vec![Damage::Crc], expected));
}

#[test]
fn a_repeated_frame_is_handed_out_once() {
    let expected = counters(|c| (c.good, c.repeats) = (2, 1));
    assert_eq!(through(&[plain(1), plain(1), plain(2)]), (vec![1, 2], vec![], expected));
}

#[test]
fn a_repeat_of_a_damaged_frame_is_received() {
    let mut hit = plain(2);
    hit[40] ^= 1;
    let expected = counters(|c| (c.good, c.bad_crc) = (2, 1));
    assert_eq!(through(&[plain(1), hit, plain(2)]), (vec![1, 2], vec![Damage::Crc], expected));
}

#[test]
fn missing_sequence_numbers_are_gaps_also_across_the_wrap() {
    let expected = counters(|c| (c.good, c.gaps) = (4, 2));
    let frames = [u32::MAX - 1, u32::MAX, 0, 3].map(plain);
    assert_eq!(through(&frames), (vec![u32::MAX - 1, u32::MAX, 0, 3], vec![], expected));
}

#[test]
fn a_step_back_in_the_sequence_is_a_restart_and_the_frame_is_taken() {
    let expected = counters(|c| (c.good, c.restarts) = (3, 1));
    assert_eq!(through(&[plain(900), plain(0), plain(1)]), (vec![900, 0, 1], vec![], expected));
}

#[test]
fn a_step_of_half_the_sequence_numbers_is_a_gap_and_one_more_is_a_restart() {
    let half = u32::MAX / 2;
    let gap = counters(|c| (c.good, c.gaps) = (2, half - 1));
    assert_eq!(through(&[plain(1), plain(1 + half)]), (vec![1, 1 + half], vec![], gap));
    let restart = counters(|c| (c.good, c.restarts) = (2, 1));
    assert_eq!(through(&[plain(1), plain(2 + half)]), (vec![1, 2 + half], vec![], restart));
}

#[test]
fn overruns_of_both_sides_are_counted() {
    let mut late = Frame::plain(4, 2);
    late.header.dropped_before = true;
    let (_, _, mut decoder) = received(&late.bytes());
    assert_eq!(decoder.counters().overruns, 1);
    decoder.note_overrun();
    assert_eq!(decoder.counters().overruns, 2);
}

#[test]
fn a_header_of_another_version_is_unsupported_and_its_frame_skipped() {
    let mut other = plain(2);
    other[4] = 2;
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&other[..28]);
    other[28..32].copy_from_slice(&crc.to_le_bytes());
    let expected = counters(|c| {
        (c.good, c.unsupported, c.gaps, c.skipped_bytes) = (2, 1, 1, 36 + 5 * 16);
    });
    assert_eq!(through(&[plain(1), other, plain(3)]), (vec![1, 3], vec![], expected));
}

#[test]
fn idle_bytes_between_frames_are_skipped() {
    for idle in [0x00, 0xff, b'S', b'F'] {
        let expected = counters(|c| (c.good, c.skipped_bytes) = (2, 100));
        let got = through(&[vec![idle; 50], plain(1), vec![idle; 50], plain(2)]);
        assert_eq!(got, (vec![1, 2], vec![], expected), "{idle}");
    }
}

#[test]
fn a_magic_right_before_a_header_costs_no_frame() {
    for length in 1..=4 {
        let fragment = b"SCMF"[..length].to_vec();
        let (sequences, _, counted) = through(&[plain(1), fragment, plain(2)]);
        assert_eq!(sequences, [1, 2]);
        assert_eq!(counted.bad_header, u32::from(length == 4));
        assert_eq!(counted.skipped_bytes, u32::try_from(length).unwrap());
    }
}
