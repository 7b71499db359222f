//! Generates matches of a near scene, bit-identical on every machine: from random integers, products, and
//! rounding to the 1/256 px of the wire.
//!
//! Points are 3 to 80 baselines away, with 0.3 px of noise per coordinate and a share of outliers.

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Correspondence;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::link::{FrameHeader, MatchRecord};

use crate::lens::{FOCAL_PX, SIZE};

/// Header of a frame of these matches, without their number.
pub(crate) const HEADER: FrameHeader = FrameHeader {
    timestamp_us: 0,
    sequence: 0,
    count: 0,
    image_size: SIZE,
    grid_step: 0,
    fraction_bits: 8,
    pyramid_ratio: 64,
    dropped_before: false,
    more_found: false,
};

/// Ranges of inverse distances, 1/baseline: of a near scene, and of one too far to observe the baseline.
const NEAR: [f32; 2] = [1.0 / 80.0, 1.0 / 3.0];
pub(crate) const FAR: [f32; 2] = [1.0 / 3000.0, 1.0 / 300.0];

/// Scales the sum of four uniform numbers in -1 to 1 to noise of 0.3 px.
const NOISE: f32 = 0.3 * 0.866;

/// Motion of a creeping scene from pair to pair, px. A pair counts fully from 8 px on.
const CREEP_PX: f32 = 3.0;

/// `R`, `t` of the rig.
#[derive(Clone, Copy)]
pub(crate) struct Rig {
    rotation: Rotation3<f32>,
    translation: Vector3<f32>,
}

impl Rig {
    /// A rig that deviates from the side-by-side rig: `R` by `degrees` about each axis, and `t` by `degrees`.
    pub(crate) fn off(degrees: f32) -> Self {
        let angle = degrees.to_radians();
        let rotation = so3::exp(&Vector3::new(angle, -angle, angle)).expect("finite");
        let tilt = so3::exp(&(Vector3::new(0.0, 0.6, 0.8) * angle)).expect("finite");
        Self { rotation, translation: tilt * -Vector3::x() }
    }
}

/// Generator of matches.
pub(crate) struct Scene {
    random: ChaCha8Rng,
    pub(crate) rig: Rig,
    /// Range of inverse distances, 1/baseline.
    pub(crate) inverse_distances: [f32; 2],
    /// Focal length of the right camera over the given one.
    pub(crate) focal: f32,
    /// Outliers per ten matches.
    pub(crate) outliers: usize,
}

impl Scene {
    pub(crate) fn new(rig: Rig) -> Self {
        let random = ChaCha8Rng::seed_from_u64(0x5E1F_CA11);
        Self { random, rig, inverse_distances: NEAR, focal: 1.0, outliers: 3 }
    }

    /// Generates the matches of the next pair.
    pub(crate) fn fill(&mut self, records: &mut [MatchRecord]) {
        for (i, record) in records.iter_mut().enumerate() {
            *record = self.record(i % 10 < self.outliers);
        }
    }

    /// Moves the matches by a few columns, as the scene of a slow vehicle does. A match at the border stays.
    pub(crate) fn creep(&mut self, records: &mut [MatchRecord]) {
        for record in records {
            let c = record.decode(&HEADER);
            let [left, right] = [c.left, c.right].map(|[u, v]| [u + CREEP_PX + self.noise(), v]);
            *record = MatchRecord::encode(&Correspondence { left, right, ..c }, &HEADER)
                .ok()
                .filter(|_| left[0].max(right[0]) < f32::from(SIZE[0]))
                .unwrap_or(*record);
        }
    }

    /// Generates one match inside both images.
    fn record(&mut self, outlier: bool) -> MatchRecord {
        loop {
            let left = self.pixel();
            let right = if outlier { self.pixel() } else { self.project_right(left) };
            let [left, right] = [left, right].map(|pixel| pixel.map(|x| x + self.noise()));
            let inside = |[u, v]: [f32; 2]| {
                let [width, height] = SIZE.map(f32::from);
                (0.0..width).contains(&u) && (0.0..height).contains(&v)
            };
            let score = 0.5 + 0.5 * self.uniform();
            let c = Correspondence { left, right, score, grid_step: 0.0 };
            if let Some(record) =
                MatchRecord::encode(&c, &HEADER).ok().filter(|_| inside(left) && inside(right))
            {
                return record;
            }
        }
    }

    fn pixel(&mut self) -> [f32; 2] {
        SIZE.map(|n| f32::from(n) * self.uniform())
    }

    /// Projects a pixel of the left camera to the right one, at a random distance.
    fn project_right(&mut self, left: [f32; 2]) -> [f32; 2] {
        let centre = SIZE.map(|n| f32::from(n) * 0.5);
        let [x, y] = [0, 1].map(|i| (left[i] - centre[i]) / FOCAL_PX);
        let [far, near] = self.inverse_distances;
        let inverse_distance = far + (near - far) * self.uniform();
        let p =
            self.rig.rotation * Vector3::new(x, y, 1.0) + self.rig.translation * inverse_distance;
        let focal = FOCAL_PX * self.focal;
        [centre[0] + focal * p.x / p.z, centre[1] + focal * p.y / p.z]
    }

    fn noise(&mut self) -> f32 {
        let sum: f32 = (0..4).map(|_| self.uniform() * 2.0 - 1.0).sum();
        sum * NOISE
    }

    /// Uniform in 0 to 1, in steps of 1/65536.
    fn uniform(&mut self) -> f32 {
        f32::from(self.random.random::<u16>()) / 65_536.0
    }
}
