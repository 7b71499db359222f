//! The bytes of the simulated framer equal those of the core's encoder.

use fpga_sim::bench::{Bench, Sink};
use fpga_sim::matches::Found;
use fpga_sim::model::Size;
use fpga_sim::spi::transfer;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::link::{FrameHeader, MatchRecord};

const CAPACITY: usize = Size::Small.matches();

/// A frame of any content: without matches, with one, with a few, with as many as fit, or with more.
fn any_frame(rng: &mut ChaCha8Rng, sequence: u32) -> Found {
    let counts = [0, 1, rng.random_range(2..8), CAPACITY, CAPACITY + rng.random_range(1..20)];
    let count = counts[usize::from(rng.random_range(0..5_u8))];
    let header = FrameHeader {
        timestamp_us: rng.random(),
        sequence,
        count: 0,
        image_size: [rng.random(), rng.random()],
        grid_step: rng.random(),
        fraction_bits: rng.random_range(0..=8),
        pyramid_ratio: rng.random_range(64..=255),
        dropped_before: false,
        more_found: false,
    };
    let records = (0..count).map(|_| {
        let mut record = [0; MatchRecord::BYTES];
        rng.fill_bytes(&mut record);
        record[14] %= 16;
        record[15] = 0;
        record
    });
    Found { header, records: records.collect() }
}

/// Frames since a reset, and the position in the bytes.
#[derive(Default)]
struct Check {
    sent: Vec<Found>,
    /// Sequence number of the next frame if none is dropped.
    next: usize,
    at: usize,
    equal: usize,
}

impl Check {
    /// Compares all whole frames, and the remaining bytes with the start of a frame.
    fn compare(&mut self, bytes: &[u8]) {
        while let Some(header) = bytes[self.at..].first_chunk() {
            let header = FrameHeader::decode(header).expect("a frame follows the other directly");
            let sequence = usize::try_from(header.sequence).unwrap();
            assert!(sequence >= self.next, "frame {sequence} is sent after {}", self.next);
            let expected = self.sent[sequence].encoded(CAPACITY, sequence > self.next, false);
            let seen = &bytes[self.at..bytes.len().min(self.at + expected.len())];
            assert_eq!(seen, &expected[..seen.len()], "frame {sequence}");
            if seen.len() < expected.len() {
                return;
            }
            self.at += seen.len();
            self.next = sequence + 1;
            self.equal += 1;
        }
    }
}

/// Runs until `done`, in steps of time, for a bounded time.
fn run_until(bench: &mut Bench, step: u64, mut done: impl FnMut(&Bench) -> bool) {
    for _ in 0..1_000_000 {
        if done(bench) {
            return;
        }
        bench.run(step);
    }
    panic!("the framer hangs");
}

fn any_surroundings(rng: &mut ChaCha8Rng, bench: &mut Bench) {
    for clock in 0..2 {
        bench.set_half_period(clock, rng.random_range(1..12));
    }
    bench.stalls = [(); 2].map(|()| [0, 40, 200][usize::from(rng.random_range(0..3_u8))]);
}

#[test]
fn ten_thousand_frames_are_equal_byte_for_byte() {
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let mut bench = Bench::new(Size::Small, Sink::Stream);
    let (mut check, mut equal, mut resets) = (Check::default(), 0, 0);
    while equal + check.equal < 10_000 {
        if check.sent.len() % 50 == 0 {
            any_surroundings(&mut rng, &mut bench);
        }
        let frame = any_frame(&mut rng, check.sent.len().try_into().unwrap());
        bench.beats.extend(frame.beats());
        check.sent.push(frame);
        if rng.random_range(0..100) == 0 {
            // Resets within a frame, of the matches or of the bytes.
            bench.run(rng.random_range(0..5_000));
            check.compare(&bench.taken);
            bench.reset();
            bench.taken.clear();
            equal += check.equal;
            resets += 1;
            check = Check::default();
            continue;
        }
        // The next frame fills a bank while this one is read.
        let sent = check.sent.len();
        run_until(&mut bench, 64, |bench| {
            check.compare(&bench.taken);
            check.next + 1 == sent && bench.taken.len() > check.at || check.next == sent
        });
    }
    assert_eq!(bench.outputs.dropped, 0);
    assert!(resets > 50, "{resets} resets");
}

#[test]
fn frames_that_are_not_read_are_dropped_whole_and_flagged() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut bench = Bench::new(Size::Small, Sink::Stream);
    let mut check = Check::default();
    for round in 0..500 {
        bench.stalls = [0, [0, 255][round % 2]];
        let frame = any_frame(&mut rng, round.try_into().unwrap());
        bench.beats.extend(frame.beats());
        check.sent.push(frame);
        bench.run(rng.random_range(0..2_000));
        check.compare(&bench.taken);
    }
    bench.stalls = [0; 2];
    let last = check.sent.len();
    run_until(&mut bench, 64, |bench| {
        check.compare(&bench.taken);
        check.next == last
    });
    let dropped = 500 - check.equal;
    assert_eq!(usize::from(bench.outputs.dropped), dropped);
    assert!(dropped > 20, "{dropped} dropped");
}

#[test]
fn the_oldest_waiting_frame_is_dropped_first() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let mut bench = Bench::new(Size::Small, Sink::Spi);
    let mut check = Check::default();
    for sequence in 0..4 {
        let frame = any_frame(&mut rng, sequence);
        bench.beats.extend(frame.beats());
        check.sent.push(frame);
    }
    bench.run(10_000);
    assert_eq!(bench.outputs.dropped, 3);
    let expected = check.sent[3].encoded(CAPACITY, true, false);
    let mut bytes = vec![0; expected.len()];
    transfer(&mut bench, &mut bytes, 0);
    assert_eq!(bytes, expected);
    assert!(!bench.outputs.m_available, "data-ready falls after the last byte");
}

#[test]
fn transfers_over_spi_may_end_anywhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let mut bench = Bench::new(Size::Small, Sink::Spi);
    bench.set_half_period(1, 4);
    let (mut check, mut bytes) = (Check::default(), Vec::new());
    for sequence in 0..400 {
        bench.set_half_period(0, rng.random_range(1..20));
        let frame = any_frame(&mut rng, sequence);
        bench.beats.extend(frame.beats());
        check.sent.push(frame);
        for _ in 0..2_000 {
            if !bench.outputs.m_available && rng.random_range(0..4) > 0 {
                bench.run(500);
            }
            let idle = !bench.outputs.m_available;
            // A frame may become whole within a transaction that begins without one.
            let mut piece = vec![0; rng.random_range(0..300)];
            transfer(&mut bench, &mut piece, rng.random_range(0..8));
            let between = check.at == bytes.len();
            let start = if between { piece.iter().position(|b| *b != 0xff) } else { Some(0) };
            assert!(between || !idle, "data-ready falls in a frame");
            bytes.extend(&piece[start.unwrap_or(piece.len())..]);
            // Idle bytes follow the last frame.
            let whole = check.whole(&bytes);
            if let Some(end) = whole {
                assert!(bytes[end..].iter().all(|b| *b == 0xff));
                bytes.truncate(end);
            }
            check.compare(&bytes);
            if check.next == check.sent.len() {
                break;
            }
        }
    }
    assert_eq!((check.equal, bench.outputs.dropped), (400, 0));
}

impl Check {
    /// The end of the frame being read, if it is whole; no other frame follows it in these tests.
    fn whole(&self, bytes: &[u8]) -> Option<usize> {
        let header = FrameHeader::decode(bytes[self.at..].first_chunk()?).expect("a header");
        let end = self.at + header.frame_bytes();
        (end <= bytes.len()).then_some(end)
    }
}

#[test]
fn the_uart_sends_the_frames() {
    let mut rng = ChaCha8Rng::seed_from_u64(24);
    let mut bench = Bench::new(Size::Small, Sink::Uart);
    bench.set_half_period(1, 4);
    let (mut check, mut bytes) = (Check::default(), Vec::new());
    // A bit takes four cycles of 8 units of time.
    let bit = 4 * 8;
    for sequence in 0..60 {
        let frame = any_frame(&mut rng, sequence);
        bench.beats.extend(frame.beats());
        check.sent.push(frame);
        while check.next < check.sent.len() {
            run_until(&mut bench, 2, |bench| !bench.outputs.tx);
            bench.run(bit / 2);
            let mut byte = 0;
            for place in 0..8 {
                bench.run(bit);
                byte |= u8::from(bench.outputs.tx) << place;
            }
            bench.run(bit);
            assert!(bench.outputs.tx, "a stop bit");
            bytes.push(byte);
            check.compare(&bytes);
        }
    }
    assert_eq!(check.equal, 60);
}
