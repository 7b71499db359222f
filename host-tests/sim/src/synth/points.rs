//! Points of successive pairs: new points, repeated points, or landmarks that keep their matching errors.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::normal::normal;
use super::scene::{Scene, SynthPair};

/// Largest number of points drawn in search of one that has just come into view.
const TRIES: usize = 10_000;

/// Relation of the points of a pair to those of the previous pair.
#[derive(Debug, Clone)]
pub(super) enum Points {
    /// New points in every pair.
    New,
    /// The points of the first of these pairs, with its outliers; new points in every other pair.
    Again(Range<usize>, Option<SynthPair>),
    /// Landmarks.
    Landmarks(Landmarks),
}

/// Landmarks that creep through the images. A landmark that leaves them is replaced by a new one.
#[derive(Debug, Clone)]
pub(super) struct Landmarks {
    /// Standard deviation of the matching error of each coordinate, px. A landmark keeps its error.
    pub(super) error_px: f64,
    /// Motion of each landmark in the left image from pair to pair, px, to the right.
    pub(super) creep_px: f64,
    /// Number of the first pair from which on all landmarks are new in every pair.
    pub(super) new_from: usize,
    /// Landmarks in view.
    pub(super) seen: Vec<Landmark>,
}

/// One landmark.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Landmark {
    /// Noise-free pixels `ul vl ur vr`.
    clean: [f64; 4],
    /// Depth along the left optical axis, baselines.
    depth: f64,
    /// Offset from the true right pixel to the one that is matched, px; `None` for a true match.
    wrong: Option<[f64; 2]>,
    /// Matching error of each coordinate, px.
    error: [f64; 4],
    /// Grid step, px.
    step: f64,
}

impl Points {
    /// The next pair.
    ///
    /// * `at`: number of the pair, from 0.
    pub(super) fn pair(&mut self, at: usize, scene: &Scene, rng: &mut ChaCha8Rng) -> SynthPair {
        match self {
            Self::New => scene.pair(rng),
            Self::Again(pairs, _) if !pairs.contains(&at) => scene.pair(rng),
            Self::Again(_, Some(first)) => scene.pair_again(first, rng),
            Self::Again(_, first @ None) => first.insert(scene.pair(rng)).clone(),
            Self::Landmarks(landmarks) => {
                landmarks.advance(at, scene, rng);
                landmarks.pair(scene, rng)
            }
        }
    }
}

impl Landmarks {
    /// Moves the landmarks to the pair of this number, and replaces those that leave the images.
    fn advance(&mut self, at: usize, scene: &Scene, rng: &mut ChaCha8Rng) {
        if self.seen.is_empty() || at >= self.new_from {
            let new = |_| Landmark::new(scene, scene.seen_point(rng), self.error_px, rng);
            self.seen = (0..scene.matches).map(new).collect();
            return;
        }
        for landmark in &mut self.seen {
            let [ul, vl, ..] = landmark.clean;
            let seen = scene.seen_from([ul + self.creep_px, vl], landmark.depth);
            if let Some(clean) = seen {
                landmark.clean = clean;
            } else {
                let entered = entered(scene, self.creep_px, rng);
                *landmark = Landmark::new(scene, entered, self.error_px, rng);
            }
        }
    }

    /// The matches of the landmarks in view, with new noise.
    fn pair(&self, scene: &Scene, rng: &mut ChaCha8Rng) -> SynthPair {
        let matched: Vec<[f64; 4]> = self.seen.iter().map(Landmark::matched).collect();
        let both = self.seen.iter().zip(&matched);
        SynthPair {
            matches: both.map(|(l, &pixels)| scene.observed(pixels, l.step, rng)).collect(),
            inlier: self.seen.iter().map(|landmark| landmark.wrong.is_none()).collect(),
            clean: self.seen.iter().map(|landmark| landmark.clean).collect(),
            matched,
        }
    }
}

impl Landmark {
    fn new(
        scene: &Scene,
        (clean, depth): ([f64; 4], f64),
        error_px: f64,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let wrong = rng.random_bool(scene.outliers.clamp(0.0, 1.0)).then(|| {
            let [.., u, v] = scene.outlier(clean, rng);
            [u - clean[2], v - clean[3]]
        });
        let error = [(); 4].map(|()| error_px * normal(rng));
        Self { clean, depth, wrong, error, step: scene.grid.step(rng) }
    }

    /// Pixels `ul vl ur vr` that are matched, with the landmark's own error, without the noise of the pair.
    fn matched(&self) -> [f64; 4] {
        let [du, dv] = self.wrong.unwrap_or_default();
        let off = [0.0, 0.0, du, dv];
        std::array::from_fn(|i| self.clean[i] + off[i] + self.error[i])
    }
}

/// A point that was not in view in the previous pair; any point in view if such points are too rare.
fn entered(scene: &Scene, creep_px: f64, rng: &mut ChaCha8Rng) -> ([f64; 4], f64) {
    let mut point = scene.seen_point(rng);
    for _ in 0..TRIES {
        let ([ul, vl, ..], depth) = point;
        if scene.seen_from([ul - creep_px, vl], depth).is_none() {
            break;
        }
        point = scene.seen_point(rng);
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{mean, rms};
    use rand::SeedableRng;

    /// Landmarks over some pairs, and their matches.
    fn followed(creep_px: f64, new_from: usize) -> Vec<(Vec<Landmark>, SynthPair)> {
        let scene = Scene { noise_px: 0.1, outliers: 0.2, ..Scene::default() };
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut landmarks = Landmarks { error_px: 0.3, creep_px, new_from, seen: Vec::new() };
        (0..60)
            .map(|at| {
                landmarks.advance(at, &scene, &mut rng);
                (landmarks.seen.clone(), landmarks.pair(&scene, &mut rng))
            })
            .collect()
    }

    #[test]
    fn errors_of_landmarks_stay_while_the_noise_is_new() {
        let pairs = followed(0.0, 40);
        assert!(pairs[..40].iter().all(|(seen, _)| *seen == pairs[0].0));
        assert!(pairs[40..].iter().all(|(seen, _)| seen[7] != pairs[0].0[7]));
        let (seen, pair) = &pairs[0];
        let mean = |i: usize| mean(pairs[..40].iter().map(|(_, p)| p.matches[i].vl)).unwrap();
        let off = |i: usize| mean(i) - pair.clean[i][1];
        let rms = rms((0..256).map(off)).unwrap();
        // The errors of the landmarks are 0.3 px RMS; the mean of 0.1 px of noise over 40 pairs adds little.
        assert!((0.26..0.34).contains(&rms), "{rms}");
        assert!((0..256).all(|i| (off(i) - seen[i].error[1]).abs() < 0.08));
        let wrong = pair.inlier.iter().filter(|inlier| !**inlier).count();
        assert!((30..75).contains(&wrong), "{wrong}");
    }

    #[test]
    fn landmarks_creep_until_they_leave_and_others_come_in_at_the_other_side() {
        let pairs = followed(10.0, usize::MAX);
        let mut replaced = 0;
        for two in pairs.windows(2) {
            for (before, after) in two[0].0.iter().zip(&two[1].0) {
                let way = after.clean[0] - before.clean[0];
                if after.error.map(f64::to_bits) == before.error.map(f64::to_bits) {
                    assert!((way - 10.0).abs() < 1e-9);
                    assert_eq!(after.depth.to_bits(), before.depth.to_bits());
                } else {
                    replaced += 1;
                    assert!(before.clean[0] > 1000.0, "{before:?}");
                    // The point has just come into view of both cameras, at the left border of the right one.
                    assert!(after.clean[0].min(after.clean[2]) < 10.5, "{after:?}");
                }
            }
        }
        // Each of the 59 steps moves 256 landmarks by 10 of 1919 px: 79 leave. Near ones have a shorter path.
        assert!((60..130).contains(&replaced), "{replaced}");
    }
}
