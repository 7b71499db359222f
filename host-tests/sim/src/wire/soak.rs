//! Soak test of the link: millions of frames over a wire with faults. Each frame must be received as sent, or not at
//! all, and each frame that the wire format promises must be received.

use std::collections::VecDeque;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Decoder, Event, FrameCrc, FrameHeader, MatchRecord};

use super::faulty_wire::{Faults, FaultyWire, Sent};
use super::sender::seal;

/// Number of latest frames that the receiver may still hand out. An older frame that was whole on the wire and was not
/// handed out counts as missed.
const WINDOW: usize = 8;

/// A soak test of one decoder; a campaign runs several.
#[derive(Debug, Clone, Copy)]
pub struct Soak {
    /// Number of frames to send.
    pub frames: u32,
    /// Rates of the faults.
    pub faults: Faults,
    /// Seed of frames and faults.
    pub seed: u64,
}

/// Frames counted by their fate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SoakCounts {
    /// Frames of the sender, with the damaged and dropped ones.
    pub frames: u64,
    /// Bytes on the wire.
    pub bytes: u64,
    /// Correspondences in the frames handed out.
    pub correspondences: u64,
    /// Frames that were whole on the wire and were handed out.
    pub decoded: u64,
    /// Frames damaged on the wire.
    pub damaged: u64,
    /// Frames that were not put on the wire.
    pub dropped: u64,
    /// Frames sent twice.
    pub repeated: u64,
    /// Frames handed out with content that differs from the frame sent under their number: must be 0.
    pub wrong: u64,
    /// Frames handed out a second time: must be 0.
    pub twice: u64,
    /// Frames that were whole on the wire, and were not handed out, because their start took the place of lost bytes of a
    /// damaged frame.
    pub taken: u64,
    /// Other frames that were whole on the wire, and were not handed out: must be 0.
    pub missed: u64,
    /// Damaged frames that were handed out as sent: the wire lost their last bytes, but the bytes that follow are equal
    /// to the lost ones.
    pub mended: u64,
}

impl SoakCounts {
    /// Sum of both counts.
    pub fn plus(self, other: Self) -> Self {
        Self {
            frames: self.frames + other.frames,
            bytes: self.bytes + other.bytes,
            correspondences: self.correspondences + other.correspondences,
            decoded: self.decoded + other.decoded,
            damaged: self.damaged + other.damaged,
            dropped: self.dropped + other.dropped,
            repeated: self.repeated + other.repeated,
            wrong: self.wrong + other.wrong,
            twice: self.twice + other.twice,
            taken: self.taken + other.taken,
            missed: self.missed + other.missed,
            mended: self.mended + other.mended,
        }
    }

    /// Whether the link passed: all counts that must be 0 are 0.
    pub fn is_good(&self) -> bool {
        [self.wrong, self.twice, self.missed] == [0; 3]
    }
}

/// A frame of the sender, with its fate so far.
struct Expected {
    sequence: u32,
    frame: Vec<u8>,
    sent: Sent,
    /// Place in the stream of its first byte, or of the first byte of its second copy.
    start: u64,
    /// Place in the stream of the end of its last byte.
    end: u64,
    /// Whether the receiver has handed it out.
    seen: bool,
}

impl Soak {
    /// Sends all frames.
    ///
    /// * `each`: called with the number of frames sent since its last call.
    pub fn run(&self, mut each: impl FnMut(u64)) -> SoakCounts {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut wire = FaultyWire::new(self.faults, self.seed ^ 0x5eed);
        let mut receiver = Receiver::new();
        let (mut on_wire, mut taken) = (Vec::new(), 0);
        // In about half of the runs, the first sequence number is so close to the largest that the numbers wrap around.
        let first = if rng.random() { rng.random() } else { u32::MAX - self.frames / 2 };
        for i in 0..self.frames {
            let sequence = first.wrapping_add(i);
            let frame = any_frame(&mut rng, sequence);
            let begin = taken + on_wire.len() as u64;
            let sent = wire.send(&frame, &mut on_wire);
            let end = taken + on_wire.len() as u64;
            let start = begin + if sent == Sent::Repeated { frame.len() as u64 } else { 0 };
            receiver.expect(Expected { sequence, frame, sent, start, end, seen: false });
            // The receiver takes the bytes in pieces that may end within a frame.
            let kept = if rng.random_bool(0.3) { rng.random_range(0..=on_wire.len()) } else { 0 };
            let cut = on_wire.len() - kept;
            receiver.take(&on_wire[..cut], &mut rng);
            on_wire.drain(..cut);
            taken += cut as u64;
            if i % 1000 == 999 {
                each(1000);
            }
        }
        receiver.take(&on_wire, &mut rng);
        each(u64::from(self.frames % 1000));
        receiver.finish()
    }
}

/// The receiver, and the latest frames of the sender.
struct Receiver {
    decoder: Decoder,
    matches: Vec<Correspondence<f32>>,
    expected: VecDeque<Expected>,
    /// Place in the stream up to which damaged frames may have taken the bytes of later frames.
    reach: u64,
    counts: SoakCounts,
}

impl Receiver {
    fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            matches: Vec::new(),
            expected: VecDeque::new(),
            reach: 0,
            counts: SoakCounts::default(),
        }
    }

    fn expect(&mut self, expected: Expected) {
        self.counts.frames += 1;
        match expected.sent {
            Sent::Damaged => self.counts.damaged += 1,
            Sent::Dropped => self.counts.dropped += 1,
            Sent::Repeated => self.counts.repeated += 1,
            Sent::Intact => (),
        }
        self.expected.push_back(expected);
        while self.expected.len() > WINDOW {
            self.settle();
        }
    }

    /// Counts the oldest frame, which can no longer be handed out, and forgets it.
    fn settle(&mut self) {
        let Some(oldest) = self.expected.pop_front() else { return };
        let whole = matches!(oldest.sent, Sent::Intact | Sent::Repeated);
        *match (whole, oldest.seen) {
            (true, true) => &mut self.counts.decoded,
            (true, false) if oldest.start < self.reach => &mut self.counts.taken,
            (true, false) => &mut self.counts.missed,
            (false, seen) => {
                // The frame ends where its header says, at the latest. The search goes on within a wrong checksum.
                let end = oldest.start + oldest.frame.len() as u64;
                let searched = if seen { 0 } else { FrameCrc::BYTES as u64 };
                self.reach = self.reach.max(end.max(oldest.end) - searched);
                if !seen {
                    return;
                }
                &mut self.counts.mended
            }
        } += 1;
    }

    fn take(&mut self, mut bytes: &[u8], rng: &mut ChaCha8Rng) {
        self.counts.bytes += bytes.len() as u64;
        while !bytes.is_empty() {
            let (mut piece, rest) = bytes.split_at(rng.random_range(1..=bytes.len().min(1500)));
            while let Some(event) = self.decoder.next(&mut piece) {
                match event {
                    Event::Started(_) | Event::Discarded => self.matches.clear(),
                    Event::Match(m, _) => self.matches.push(m),
                    Event::Finished(header) => self.check(&header),
                }
            }
            bytes = rest;
        }
    }

    fn check(&mut self, header: &FrameHeader) {
        self.counts.correspondences += self.matches.len() as u64;
        let sent = self.expected.iter_mut().find(|sent| sent.sequence == header.sequence);
        let right = sent.filter(|sent| is_content(&sent.frame, header, &self.matches));
        match right {
            None => self.counts.wrong += 1,
            Some(sent) if sent.seen => self.counts.twice += 1,
            Some(sent) => sent.seen = true,
        }
    }

    fn finish(mut self) -> SoakCounts {
        while !self.expected.is_empty() {
            self.settle();
        }
        self.counts
    }
}

/// A frame of random content; frames with few matches are the most frequent.
fn any_frame(rng: &mut ChaCha8Rng, sequence: u32) -> Vec<u8> {
    let most = [4, 16, 64, 512][rng.random_range(0..4)];
    let count = rng.random_range(0..=most);
    let header = FrameHeader {
        timestamp_us: rng.random(),
        sequence,
        count,
        image_size: [rng.random(), rng.random()],
        grid_step: rng.random(),
        fraction_bits: rng.random_range(0..=8),
        pyramid_ratio: rng.random_range(64..=255),
        dropped_before: rng.random(),
        more_found: rng.random(),
    };
    let record = |_| {
        let mut record = [0; MatchRecord::BYTES];
        rng.fill_bytes(&mut record);
        MatchRecord::from_bytes(&record)
    };
    let records: Vec<MatchRecord> = (0..count).map(record).collect();
    seal(&header, &records)
}

/// Whether the bytes of a frame have the decoded number, time and matches. Computed independently of the decoder.
#[expect(clippy::float_cmp, reason = "fixed point is exact")]
fn is_content(frame: &[u8], header: &FrameHeader, matches: &[Correspondence<f32>]) -> bool {
    let records = frame[32..frame.len() - 4].chunks_exact(16);
    let word = |at: usize| u32::from_le_bytes(frame[at..at + 4].try_into().expect("four bytes"));
    let step = 0.5_f64.powi(frame[6].into());
    let same = |record: &[u8], m: &Correspondence<f32>| {
        let fixed = |at: usize| {
            let [a, b, c] = [record[at], record[at + 1], record[at + 2]].map(u32::from);
            f64::from(a + (b << 8) + (c << 16)) * step
        };
        let pixels = [m.left[0], m.left[1], m.right[0], m.right[1]].map(f64::from);
        let score = f64::from(u16::from_le_bytes([record[12], record[13]])) / 65_535.0;
        pixels == [fixed(0), fixed(3), fixed(6), fixed(9)]
            && (f64::from(m.score) - score).abs() < 1e-7
    };
    word(8) == header.sequence
        && frame[16..24] == header.timestamp_us.to_le_bytes()
        && records.len() == matches.len()
        && records.zip(matches).all(|(record, m)| same(record, m))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAULTS: Faults =
        Faults { damaged: 0.2, dropped: 0.05, repeated: 0.05, noise_after: 0.05 };

    #[test]
    fn no_damaged_frame_comes_out_and_no_other_is_lost_but_those_in_the_place_of_lost_bytes() {
        let counts = Soak { frames: 20_000, faults: FAULTS, seed: 1 }.run(|_| ());
        assert!(counts.is_good(), "{counts:?}");
        assert!(
            counts.damaged > 3000 && counts.dropped > 800 && counts.repeated > 600,
            "{counts:?}"
        );
        assert_eq!(counts.frames, 20_000);
        assert_eq!(counts.decoded + counts.taken + counts.damaged + counts.dropped, counts.frames);
        // Two of eight kinds of damage lose bytes at once: a run, or the end of a frame.
        assert!((counts.damaged / 10..counts.damaged / 3).contains(&counts.taken), "{counts:?}");
    }

    #[test]
    fn a_perfect_wire_loses_nothing() {
        let counts = Soak { frames: 2_000, faults: Faults::NONE, seed: 2 }.run(|_| ());
        assert_eq!((counts.decoded, counts.damaged), (2_000, 0));
        assert!(counts.is_good(), "{counts:?}");
    }
}
