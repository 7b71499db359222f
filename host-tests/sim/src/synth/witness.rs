//! Measurements that a vehicle makes in addition to the pairs: ranges, and matches tracked over its motion. They
//! separate the yaw of the mount from the apparent yaw of the lenses.

use anyhow::{Result, ensure};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use stereo_selfcal::depth::{Range, RangeReading};

use super::normal::normal;
use super::scene::{Scene, SynthPair};
use rigs::data::tracked::Track;

/// Number of pairs from one measurement to the next.
const INTERVAL: usize = 10;

/// Stream of the random numbers for the measurements, so that the pairs are the same without them.
const STREAM: u64 = 2;

/// A laser rangefinder at the left camera, aimed at a point that the matcher sees. It gives a reading at every tenth
/// pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rangefinder {
    /// Length of the baseline, m.
    pub baseline_m: f64,
    /// Standard deviation of a reading, relative to the reading.
    pub sd: f64,
    /// Share of the readings that hit something nearer, such as a window, 0 to 1.
    pub nearer: f64,
}

/// Motion of the vehicle before every tenth pair, over which the matches are tracked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Distance along the left optical axis, in baselines.
    pub travel: f64,
    /// Turn about the vertical axis, degrees.
    pub turn_deg: f64,
}

/// The witnesses of a scenario: sensors whose measurements separate the yaw of the mount from that of the lenses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Witnesses {
    /// Ranges.
    pub rangefinder: Option<Rangefinder>,
    /// Tracked matches.
    pub motion: Option<Motion>,
}

impl Witnesses {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the witness that is out of range.
    pub(super) fn check(&self) -> Result<()> {
        if let Some(Rangefinder { baseline_m, sd, nearer }) = self.rangefinder {
            let baseline = baseline_m > 0.0 && baseline_m.is_finite();
            ensure!(baseline, "rangefinder: baseline_m must be above 0");
            ensure!((0.001..=0.3).contains(&sd), "rangefinder: sd must be from 0.001 to 0.3");
            ensure!((0.0..=1.0).contains(&nearer), "rangefinder: nearer must be from 0 to 1");
        }
        if let Some(Motion { travel, turn_deg }) = self.motion {
            ensure!(travel.abs() <= 1000.0, "motion: travel must be at most 1000 baselines");
            ensure!(turn_deg.abs() <= 180.0, "motion: turn_deg must be at most 180 degrees");
        }
        Ok(())
    }
}

/// Measurements of the witnesses after one pair.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Witnessed {
    /// Points of known distance.
    pub readings: Vec<RangeReading<f64>>,
    /// Matches in an earlier pair and in this one.
    pub tracks: Vec<Track>,
}

/// The witnesses of a run, with their random numbers.
pub(super) struct Witnessing {
    of: Witnesses,
    rng: ChaCha8Rng,
}

impl Witnessing {
    pub(super) fn new(of: Witnesses, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        Self { of, rng }
    }

    /// The measurements after a pair.
    ///
    /// * `at`: number of the pair, from 0.
    pub(super) fn after(&mut self, at: usize, scene: &Scene, pair: &SynthPair) -> Witnessed {
        if !at.is_multiple_of(INTERVAL) {
            return Witnessed::default();
        }
        let Witnesses { rangefinder, motion } = self.of;
        let reading = rangefinder.and_then(|range| range.read(scene, pair, &mut self.rng));
        let tracks = motion.map(|motion| motion.track(scene, pair, &mut self.rng));
        Witnessed { readings: Vec::from_iter(reading), tracks: tracks.unwrap_or_default() }
    }
}

impl Rangefinder {
    /// A reading of the distance to the first true match, along its ray; `None` without a true match, or if noise makes
    /// the distance 0 or less.
    fn read(
        &self,
        scene: &Scene,
        pair: &SynthPair,
        rng: &mut ChaCha8Rng,
    ) -> Option<RangeReading<f64>> {
        let at = pair.inlier.iter().position(|is_true| *is_true)?;
        let distance = scene.point_of(pair.clean.get(at)?).norm() * self.baseline_m;
        let hit = if rng.random_bool(self.nearer) { rng.random_range(0.2..0.8) } else { 1.0 };
        let read = (1.0 + self.sd * normal(rng)) * hit * distance;
        let m = pair.matches.get(at)?;
        (read > 0.0).then_some(RangeReading {
            pixel: [m.ul, m.vl],
            right: None,
            range: Range::AlongRay(read),
            sd_m: self.sd * read,
        })
    }
}

impl Motion {
    /// Tracks: matches of the points before the vehicle moved, and the matches of the pair. A point that was out of
    /// view before has no track.
    fn track(&self, scene: &Scene, pair: &SynthPair, rng: &mut ChaCha8Rng) -> Vec<Track> {
        let turn = Rotation3::new(Vector3::y() * self.turn_deg.to_radians());
        let before = |clean: &[f64; 4]| {
            scene.seen_at(&(turn * scene.point_of(clean) + Vector3::z() * self.travel))
        };
        let both = pair.clean.iter().zip(&pair.matches);
        both.filter_map(|(clean, now)| Some([scene.observed(before(clean)?, now.step, rng), *now]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{LensErrors, Scenario, ScenarioKind, five_degrees_off};

    fn scenario(witnesses: Witnesses) -> Scenario {
        let errors: LensErrors = "a_r=0.003,k1_l=0.01,cx_l=2".parse().unwrap();
        let mut scenario = Scenario { witnesses, ..Scenario::new(ScenarioKind::Near, 21) };
        scenario.scene.lens_errors = errors.given;
        scenario.scene.rig = five_degrees_off();
        scenario
    }

    #[test]
    fn a_point_projects_to_the_pixels_that_it_was_computed_from() {
        for frame in scenario(Witnesses::default()).frames(1).unwrap() {
            for clean in &frame.pair.clean {
                let seen = frame.scene.seen_at(&frame.scene.point_of(clean)).unwrap();
                let off = seen.iter().zip(clean).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-6, "{seen:?} {clean:?}");
            }
        }
    }

    #[test]
    fn every_tenth_pair_has_measurements_and_they_leave_the_pairs_unchanged() {
        let rangefinder = Rangefinder { baseline_m: 0.12, sd: 0.01, nearer: 0.0 };
        let motion = Motion { travel: 4.0, turn_deg: 3.0 };
        let both = Witnesses { rangefinder: Some(rangefinder), motion: Some(motion) };
        let [with, without] = [both, Witnesses::default()].map(|w| scenario(w).frames(2).unwrap());
        for (at, (with, without)) in with.zip(without).enumerate() {
            assert_eq!(with.pair, without.pair);
            assert_eq!(without.witnessed, Witnessed::default());
            let Witnessed { readings, tracks } = &with.witnessed;
            assert_eq!(
                (readings.len(), tracks.is_empty()),
                (usize::from(at % 10 == 0), at % 10 != 0)
            );
            for reading in readings {
                let Range::AlongRay(range) = reading.range else { panic!("{reading:?}") };
                let at = with
                    .pair
                    .matches
                    .iter()
                    .position(|m| [m.ul, m.vl].map(f64::to_bits) == reading.pixel.map(f64::to_bits))
                    .unwrap();
                let truth = 0.12 * with.scene.point_of(&with.pair.clean[at]).norm();
                assert!((range / truth - 1.0).abs() < 0.05, "{range} {truth}");
            }
        }
    }
}
