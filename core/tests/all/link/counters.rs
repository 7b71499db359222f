//! Exact counters for every kind of damage.

use crate::link::stream::{Frame, received};
use stereo_selfcal::link::Counters;

fn plain(sequence: u32) -> Vec<u8> {
    Frame::plain(sequence, 5).bytes()
}

/// Sequence numbers of the frames that are handed out, the number of frames that are discarded after an intact header,
/// and the counters.
fn through(stream: &[Vec<u8>]) -> (Vec<u32>, usize, Counters) {
    let (frames, discarded, decoder) = received(&stream.concat());
    let sequences = frames.iter().map(|frame| frame.header.sequence).collect();
    (sequences, discarded, *decoder.counters())
}

fn counters(set: impl FnOnce(&mut Counters)) -> Counters {
    let mut counters = Counters::default();
    set(&mut counters);
    counters
}

#[test]
fn a_clean_stream_yields_every_frame_and_no_other_count() {
    let frames = [Frame::plain(7, 0), Frame::plain(8, 300), Frame::plain(9, 1)];
    let (got, discarded, decoder) = received(&frames.clone().map(|frame| frame.bytes()).concat());
    assert_eq!((got.as_slice(), discarded), (&frames[..], 0));
    assert_eq!(*decoder.counters(), counters(|c| c.good = 3));
}

#[test]
fn a_flipped_bit_in_a_record_discards_the_frame_by_its_crc() {
    let mut hit = plain(2);
    hit[40] ^= 1;
    assert_eq!(
        through(&[plain(1), hit, plain(3)]),
        (vec![1, 3], 1, counters(|c| (c.good, c.bad_crc, c.gaps) = (2, 1, 1)))
    );
}

#[test]
fn a_damaged_header_is_counted_and_its_frame_skipped() {
    let mut hit = plain(2);
    hit[12] ^= 1;
    let expected = counters(|c| {
        (c.good, c.bad_header, c.gaps, c.skipped_bytes) = (2, 1, 1, 36 + 5 * 16);
    });
    assert_eq!(through(&[plain(1), hit, plain(3)]), (vec![1, 3], 0, expected));
}

#[test]
fn up_to_4_lost_bytes_cost_a_frame_and_more_of_them_the_next_one_too() {
    let length = plain(2).len();
    for missing in 1..=length - 40 {
        for at in [32, 40, length - missing] {
            let mut short = plain(2);
            short.drain(at..at + missing);
            let got = through(&[plain(1), short, plain(3), plain(4)]);
            let lost = if missing <= 4 { vec![1, 3, 4] } else { vec![1, 4] };
            let expected = counters(|c| {
                (c.good, c.bad_crc, c.gaps) = (lost.len() as u32, 1, 4 - lost.len() as u32);
                // The rest of the frame whose start the damaged one has taken.
                c.skipped_bytes = if missing <= 4 { 0 } else { (length - missing) as u32 };
            });
            assert_eq!(got, (lost, 1, expected), "{missing} at {at}");
        }
    }
}

#[test]
fn lost_bytes_of_a_header_cost_its_frame() {
    for missing in 1..=32 {
        let mut short = plain(2);
        short.drain(32 - missing..32);
        let (sequences, discarded, _) = through(&[plain(1), short, plain(3)]);
        assert_eq!((sequences, discarded), (vec![1, 3], 0), "{missing}");
    }
}

#[test]
fn a_frame_without_its_end_costs_the_frames_that_take_the_place_of_the_end() {
    let mut cut = Frame::plain(2, 20).bytes();
    cut.truncate(cut.len() - 2 * plain(3).len() - 5);
    let (sequences, discarded, _) =
        through(&[plain(1), cut, plain(3), plain(4), plain(5), plain(6)]);
    assert_eq!((sequences, discarded), (vec![1, 6], 1));
}

#[test]
fn a_header_with_the_records_of_another_frame_fails_the_crc() {
    let spliced = [&plain(2)[..32], &plain(3)[32..]].concat();
    let expected = counters(|c| (c.good, c.bad_crc, c.gaps) = (2, 1, 2));
    assert_eq!(through(&[plain(1), spliced, plain(4)]), (vec![1, 4], 1, expected));
}

#[test]
fn a_repeated_frame_is_handed_out_once() {
    let expected = counters(|c| (c.good, c.repeats) = (2, 1));
    assert_eq!(through(&[plain(1), plain(1), plain(2)]), (vec![1, 2], 0, expected));
}

#[test]
fn a_repeat_of_a_damaged_frame_is_received() {
    let mut hit = plain(2);
    hit[40] ^= 1;
    let expected = counters(|c| (c.good, c.bad_crc) = (2, 1));
    assert_eq!(through(&[plain(1), hit, plain(2)]), (vec![1, 2], 1, expected));
}

#[test]
fn missing_sequence_numbers_are_gaps_also_across_the_wrap() {
    let expected = counters(|c| (c.good, c.gaps) = (4, 2));
    let frames = [u32::MAX - 1, u32::MAX, 0, 3].map(plain);
    assert_eq!(through(&frames), (vec![u32::MAX - 1, u32::MAX, 0, 3], 0, expected));
}

#[test]
fn a_step_back_in_the_sequence_is_a_restart_and_the_frame_is_taken() {
    let expected = counters(|c| (c.good, c.restarts) = (3, 1));
    assert_eq!(through(&[plain(900), plain(0), plain(1)]), (vec![900, 0, 1], 0, expected));
}

#[test]
fn a_step_of_half_the_sequence_numbers_is_a_gap_and_one_more_is_a_restart() {
    let half = u32::MAX / 2;
    let gap = counters(|c| (c.good, c.gaps) = (2, half - 1));
    assert_eq!(through(&[plain(1), plain(1 + half)]), (vec![1, 1 + half], 0, gap));
    let restart = counters(|c| (c.good, c.restarts) = (2, 1));
    assert_eq!(through(&[plain(1), plain(2 + half)]), (vec![1, 2 + half], 0, restart));
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
    assert_eq!(through(&[plain(1), other, plain(3)]), (vec![1, 3], 0, expected));
}

#[test]
fn idle_bytes_between_frames_are_skipped() {
    for idle in [0x00, 0xff, b'S', b'F'] {
        let expected = counters(|c| (c.good, c.skipped_bytes) = (2, 100));
        let got = through(&[vec![idle; 50], plain(1), vec![idle; 50], plain(2)]);
        assert_eq!(got, (vec![1, 2], 0, expected), "{idle}");
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
