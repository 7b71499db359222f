//! A wire that damages, drops and repeats frames, and knows which frames are intact.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Rates of the faults: probability for a frame, 0 to 1. Only a frame that is not dropped may be damaged, and only a
/// frame that is neither dropped nor damaged may be repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faults {
    /// Bits are flipped, bytes lost, inserted or overwritten, or the end is cut off.
    pub damaged: f64,
    /// The frame is not sent.
    pub dropped: f64,
    /// The frame is sent twice.
    pub repeated: f64,
    /// Idle bytes or noise follow the frame.
    pub noise_after: f64,
}

impl Faults {
    /// A perfect wire.
    pub const NONE: Self = Self { damaged: 0.0, dropped: 0.0, repeated: 0.0, noise_after: 0.0 };
}

/// State of a frame after the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sent {
    /// All its bytes are on the wire, in one piece.
    Intact,
    /// All its bytes are on the wire, twice.
    Repeated,
    /// The wire has no whole copy of it: bytes are missing, wrong or inserted.
    Damaged,
    /// No byte of it is on the wire.
    Dropped,
}

/// A wire with faults. The same seed and the same frames give the same faults.
#[derive(Debug, Clone)]
pub struct FaultyWire {
    faults: Faults,
    rng: ChaCha8Rng,
}

impl FaultyWire {
    /// * `seed`: of the random numbers.
    pub fn new(faults: Faults, seed: u64) -> Self {
        Self { faults, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Appends a frame with its faults, and perhaps noise, to the bytes of the wire.
    ///
    /// # Panics
    /// If a rate is not from 0 to 1, or the wire damages an empty frame.
    pub fn send(&mut self, frame: &[u8], wire: &mut Vec<u8>) -> Sent {
        let sent = self.put(frame, wire);
        if self.rng.random_bool(self.faults.noise_after) {
            self.noise(wire);
        }
        sent
    }

    fn put(&mut self, frame: &[u8], wire: &mut Vec<u8>) -> Sent {
        if self.rng.random_bool(self.faults.dropped) {
            return Sent::Dropped;
        }
        if self.rng.random_bool(self.faults.damaged) {
            let damaged = self.damage(frame.to_vec());
            // A frame may survive, for example if bytes are inserted before its first byte.
            let whole = damaged.windows(frame.len()).any(|part| part == frame);
            wire.extend(damaged);
            return if whole { Sent::Intact } else { Sent::Damaged };
        }
        wire.extend_from_slice(frame);
        if self.rng.random_bool(self.faults.repeated) {
            wire.extend_from_slice(frame);
            return Sent::Repeated;
        }
        Sent::Intact
    }

    fn damage(&mut self, mut frame: Vec<u8>) -> Vec<u8> {
        let rng = &mut self.rng;
        let at = rng.random_range(0..frame.len());
        let run = run(rng, frame.len() - at);
        match rng.random_range(0..8) {
            0 => frame[at] ^= 1 << rng.random_range(0..8),
            // A burst of wrong bytes.
            1 => frame[at..at + run].iter_mut().for_each(|byte| *byte ^= rng.random::<u8>()),
            // Independent wrong bits.
            2 => {
                let rate = libm::pow(10.0, rng.random_range(-4.0..-0.5));
                for byte in &mut frame {
                    for bit in 0..8 {
                        *byte ^= u8::from(rng.random_bool(rate)) << bit;
                    }
                }
            }
            3 => drop(frame.drain(at..at + run)),
            4 => {
                let mut put_in = vec![0; run];
                rng.fill_bytes(&mut put_in);
                frame.splice(at..at, put_in);
            }
            5 => frame.truncate(at),
            6 => frame[at..at + run].fill(if rng.random() { 0xff } else { 0 }),
            // The receiver reads a byte twice.
            _ => frame.insert(at, frame[at]),
        }
        frame
    }

    fn noise(&mut self, wire: &mut Vec<u8>) {
        let mut noise = vec![0xff; run(&mut self.rng, 4096)];
        if self.rng.random() {
            self.rng.fill_bytes(&mut noise);
        }
        wire.extend(noise);
    }
}

/// Random length of a run, 1 to `most`, log-uniform: short runs are the most frequent.
fn run(rng: &mut ChaCha8Rng, most: usize) -> usize {
    let scale = rng.random_range(0.0..1.0_f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a length of some thousand at most"
    )]
    let length = libm::pow(most as f64, scale) as usize;
    length.clamp(1, most)
}
