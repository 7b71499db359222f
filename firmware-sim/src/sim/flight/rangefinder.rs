//! A laser rangefinder beside the left camera, boresighted to a point that the matcher sees.

use std::fmt;

use host_tests::synth::{Scene, SynthPair};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::{Range, RangeError, RangeReading, Scalar, Witnessed};

/// Pairs between two readings.
const INTERVAL: u32 = 10;

/// Standard deviation of a reading over its distance.
const SD: f64 = 0.01;

/// Share of the readings that hit something nearer, such as a window.
const NEARER: f64 = 0.1;

/// The sensor, and counts of what became of its readings.
pub(super) struct Rangefinder {
    baseline_m: f64,
    rng: ChaCha8Rng,
    /// Readings taken, held back, refused.
    counts: [u32; 3],
}

impl Rangefinder {
    pub(super) fn new(baseline_m: f32, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed ^ 0x1a5e);
        Self { baseline_m: baseline_m.to_f64(), rng, counts: [0; 3] }
    }

    /// The reading after a pair: of its first true match. `None` between two readings.
    pub(super) fn read(
        &mut self,
        sequence: u32,
        scene: &Scene,
        pair: &SynthPair,
    ) -> Option<RangeReading<f32>> {
        if !sequence.is_multiple_of(INTERVAL) {
            return None;
        }
        let (at, _) = pair.inlier.iter().enumerate().find(|(_, is_true)| **is_true)?;
        let distance = scene.distance(pair.clean.get(at)?) * self.baseline_m;
        let [u, v] = pair.matches.get(at)?.correspondence::<f32>().left;
        let hit = if self.rng.random_bool(NEARER) { self.rng.random_range(0.2..0.8) } else { 1.0 };
        // The sum of twelve even numbers is normal to 3 deviations.
        let normal = (0..12).map(|_| self.rng.random::<f64>()).sum::<f64>() - 6.0;
        let read = hit * (1.0 + SD * normal) * distance;
        let range = Range::AlongRay(f32::lit(read));
        Some(RangeReading { pixel: [u, v], range, sd_m: f32::lit(SD * read) })
    }

    pub(super) fn note(&mut self, outcome: Result<Witnessed, RangeError>) {
        let [taken, waiting, refused] = &mut self.counts;
        *match outcome {
            Ok(Witnessed::Taken) => taken,
            Ok(Witnessed::Waiting) => waiting,
            Err(_) => refused,
        } += 1;
    }

    /// Readings taken, held back, refused.
    #[cfg(test)]
    pub(super) fn counts(&self) -> [u32; 3] {
        self.counts
    }
}

impl fmt::Display for Rangefinder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [taken, waiting, refused] = self.counts;
        write!(
            f,
            "rangefinder        {taken} readings taken, {waiting} held back, {refused} refused"
        )
    }
}
