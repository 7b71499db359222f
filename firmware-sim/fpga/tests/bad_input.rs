//! Each bad input has a defined result, and the decoder loses at most the frame that it hits.

use fpga_sim::bench::{Beat, Bench, Sink};
use fpga_sim::matches::Found;
use fpga_sim::model::Size;
use fpga_sim::spi::transfer;
use stereo_selfcal::link::{Decoder, FrameHeader, MatchRecord};

const HEADER: FrameHeader = FrameHeader {
    timestamp_us: 7,
    sequence: 0,
    count: 0,
    image_size: [1920, 1200],
    grid_step: 256,
    fraction_bits: 8,
    pyramid_ratio: 77,
    dropped_before: false,
    more_found: false,
};

fn plain(sequence: u32, count: u8) -> Found {
    let records = (0..count).map(|i| [i, i, 1, 2, i, 3, 4, 5, i, 6, 7, 8, 9, 10, i % 16, 0]);
    Found { header: FrameHeader { sequence, ..HEADER }, records: records.collect() }
}

/// Offers the beats to the framer; returns all bytes that it sends.
fn sent(bench: &mut Bench, beats: impl IntoIterator<Item = Beat>) -> Vec<u8> {
    bench.beats.extend(beats);
    bench.run(60_000);
    std::mem::take(&mut bench.taken)
}

fn stream() -> Bench {
    Bench::new(Size::Small, Sink::Stream)
}

/// Number of whole frames, and of skipped bytes.
fn decoded(bytes: &[u8]) -> (u32, u32) {
    let (mut decoder, mut rest) = (Decoder::new(), bytes);
    while decoder.next(&mut rest).is_some() {}
    (decoder.counters().good, decoder.counters().skipped_bytes)
}

#[test]
fn the_golden_vectors_come_out() {
    let vector = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../core/vectors");
        std::fs::read(format!("{folder}/{name}.bin")).unwrap()
    };
    let mut bench = stream();
    for name in ["empty", "good", "maximal"] {
        let bytes = vector(name);
        let header = FrameHeader::decode(bytes.first_chunk().unwrap()).unwrap();
        let records = bytes[FrameHeader::BYTES..].as_chunks::<{ MatchRecord::BYTES }>().0;
        let records = records[..header.count.into()].to_vec();
        assert_eq!(sent(&mut bench, Found { header, records }.beats()), bytes, "{name}");
    }
}

#[test]
fn a_match_out_of_range_is_left_out_counted_and_flagged() {
    let mut bench = stream();
    for axis in 0..4 {
        let mut beats = plain(axis, 3).beats();
        beats[1].coordinates[usize::try_from(axis).unwrap()] = 1 << 24;
        let mut expected = plain(axis, 3);
        expected.records.remove(1);
        assert_eq!(sent(&mut bench, beats), expected.encoded(30, false, true), "axis {axis}");
    }
    assert_eq!(bench.outputs.out_of_range, 4);
    // The only match of a frame is out of range: the frame has no match.
    let mut beats = plain(4, 1).beats();
    beats[0].coordinates[0] = 0x1ff_ffff;
    assert_eq!(sent(&mut bench, beats), plain(4, 0).encoded(30, false, true));
}

#[test]
fn a_frame_longer_than_the_buffer_is_cut_counted_and_flagged() {
    let mut bench = stream();
    assert_eq!(sent(&mut bench, plain(0, 200).beats()), plain(0, 200).encoded(30, false, false));
    assert_eq!(bench.outputs.overfull, 170);
    assert_eq!(sent(&mut bench, plain(1, 2).beats()), plain(1, 2).encoded(30, false, false));
}

#[test]
fn a_frame_without_its_last_beat_is_dropped_at_the_next_first_one() {
    let mut bench = stream();
    let mut beats = plain(0, 5).beats();
    beats[4].last = false;
    assert_eq!(sent(&mut bench, beats), []);
    assert_eq!(sent(&mut bench, plain(1, 2).beats()), plain(1, 2).encoded(30, true, false));
    assert_eq!(bench.outputs.unfinished, 1);
    // Without a first beat the pairs merge, up to the size of the buffer.
    let mut beats = [plain(2, 20).beats(), plain(2, 20).beats()].concat();
    for beat in &mut beats {
        (beat.first, beat.last) = (false, false);
    }
    beats[39].last = true;
    let mut merged = plain(2, 20);
    merged.records.extend(plain(2, 20).records);
    assert_eq!(sent(&mut bench, beats), merged.encoded(30, false, false));
    assert_eq!(bench.outputs.overfull, 10);
}

#[test]
fn spi_without_a_frame_reads_ff() {
    let mut bench = Bench::new(Size::Small, Sink::Spi);
    let mut bytes = [0; 40];
    transfer(&mut bench, &mut bytes, 3);
    assert_eq!(bytes, [0xff; 40]);
    bench.beats.extend(plain(0, 2).beats());
    bench.run(1_000);
    let mut bytes = [0; 36 + 32 + 5];
    transfer(&mut bench, &mut bytes, 0);
    assert_eq!(bytes[..68], plain(0, 2).encoded(30, false, false));
    assert_eq!(bytes[68..], [0xff; 5]);
}

#[test]
fn a_stopped_clock_of_the_matcher_costs_one_byte() {
    let mut bench = Bench::new(Size::Small, Sink::Spi);
    bench.beats.extend(plain(0, 2).beats());
    bench.run(1_000);
    bench.set_half_period(0, 0);
    let mut bytes = [0; 20];
    transfer(&mut bench, &mut bytes, 0);
    // Without the clock of the matcher no frame is granted: the bus reads the first byte, equal in all frames, and then
    // idle bytes.
    assert_eq!((bytes[0], &bytes[1..]), (0x53, &[0xff; 19][..]));
    bench.set_half_period(0, 5);
    bench.run(1_000);
    let mut rest = [0; 68];
    transfer(&mut bench, &mut rest, 0);
    assert_eq!(rest[..], plain(0, 2).encoded(30, false, false));
    assert_eq!(decoded(&[&bytes[..], &rest].concat()), (1, 20));
}

#[test]
fn a_stopped_clock_in_a_frame_costs_nothing() {
    for clock in 0..2 {
        let mut bench = stream();
        bench.beats.extend(plain(0, 9).beats());
        while bench.taken.len() < 50 {
            bench.run(1);
        }
        let half_period = bench.half_periods[clock];
        bench.set_half_period(clock, 0);
        bench.run(100_000);
        bench.set_half_period(clock, half_period);
        assert_eq!(sent(&mut bench, []), plain(0, 9).encoded(30, false, false), "clock {clock}");
    }
}

#[test]
fn a_reset_within_a_transaction_costs_that_frame() {
    let mut bench = Bench::new(Size::Small, Sink::Spi);
    bench.beats.extend(plain(0, 9).beats());
    bench.run(1_000);
    let mut cut = [0; 50];
    transfer(&mut bench, &mut cut, 0);
    bench.inputs.cs_n = false;
    bench.reset();
    // Still selected: the output is idle until the controller ends the transaction.
    bench.beats.extend(plain(0, 2).beats());
    bench.run(2_000);
    let mut idle = [0; 3];
    transfer(&mut bench, &mut idle, 4);
    assert_eq!(idle, [0xff; 3]);
    let mut next = [0; 68];
    transfer(&mut bench, &mut next, 0);
    assert_eq!(next[..], plain(0, 2).encoded(30, false, false));
    assert_eq!(decoded(&[&cut[..], &idle, &next].concat()).0, 1);
}
