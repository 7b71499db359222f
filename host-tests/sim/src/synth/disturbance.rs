//! Disturbances that move the views of a pair against each other without changing the rig: vibration, trigger skew in a
//! turn, unsynchronised rolling shutters.

use anyhow::{Result, ensure};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitSphere};
use stereo_selfcal::Extrinsics;

use super::normal::normal;
use super::rig::turned;
use super::scene::{Scene, SynthPair};

/// Stream of the random numbers. Points and scenes have other streams, so a disturbance does not change them.
const STREAM: u64 = 2;

/// Disturbances of a scenario; all 0 by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Disturbance {
    /// Turn of the right camera about each axis, drawn anew for every pair, degrees RMS.
    pub vibration_deg: f64,
    /// Turn of the vehicle between the two exposures of each pair in the second half of the run, degrees: the rate of
    /// turn times the trigger skew. The axis is random, and the same in the whole run.
    pub skew_deg: f64,
    /// Turn about the same axis with a sign that alternates from pair to pair, in the whole run, degrees.
    pub alternating_skew_deg: f64,
    /// Shift of the lower border of the right image against its middle row, px RMS in u and in v, drawn anew for every
    /// pair. The upper border shifts by as much in the opposite direction.
    pub rolling_px: f64,
}

/// Draws the disturbance of one pair after the other.
pub(super) struct Disturber {
    kind: Disturbance,
    pairs: usize,
    axis: Vector3<f64>,
    rng: ChaCha8Rng,
}

impl Disturbance {
    /// Whether there is any disturbance.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn over(self, pairs: usize, seed: u64) -> Result<Disturber> {
        let Self { vibration_deg, skew_deg, alternating_skew_deg, rolling_px } = self;
        ensure!(vibration_deg.is_finite(), "vibration must be finite");
        let turns = [skew_deg, alternating_skew_deg];
        ensure!(turns.iter().all(|deg| deg.is_finite()), "a turn must be finite");
        ensure!(rolling_px.is_finite(), "a rolling shutter's shift must be finite");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        let axis = Vector3::from(UnitSphere.sample(&mut rng));
        Ok(Disturber { kind: self, pairs, axis, rng })
    }
}

impl Disturber {
    fn normal<const K: usize>(&mut self) -> [f64; K] {
        std::array::from_fn(|_| normal(&mut self.rng))
    }

    /// The disturbed rig of a pair.
    ///
    /// * `pair`: number of the pair, from 0.
    pub(super) fn rig(&mut self, pair: usize, rig: &Extrinsics<f64>) -> Result<Extrinsics<f64>> {
        if (Disturbance { rolling_px: 0.0, ..self.kind }).is_none() {
            return Ok(*rig);
        }
        let Disturbance { vibration_deg, skew_deg, alternating_skew_deg, .. } = self.kind;
        let sign = if pair.is_multiple_of(2) { 1.0 } else { -1.0 };
        let late = if pair < self.pairs / 2 { 0.0 } else { skew_deg };
        let shake = Vector3::from(self.normal()) * vibration_deg;
        turned(rig, &(shake + self.axis * (late + sign * alternating_skew_deg)), 1.0)
    }

    /// Shifts right pixels in proportion to their signed distance from the middle row; they stay within the image.
    pub(super) fn roll(&mut self, scene: &Scene, pair: &mut SynthPair) {
        let shift = self.normal::<2>().map(|n| n * self.kind.rolling_px);
        if self.kind.rolling_px == 0.0 {
            return;
        }
        let last = scene.size.map(|n| f64::from(n - 1));
        for m in &mut pair.matches {
            let from_middle = 2.0 * m.vr / last[1] - 1.0;
            m.ur = (m.ur + shift[0] * from_middle).clamp(0.0, last[0]);
            m.vr = (m.vr + shift[1] * from_middle).clamp(0.0, last[1]);
        }
    }
}
