//! Matches of a near scene, the same bits wherever they are made: integers at random, products, and
//! rounding to the 1/256 px of the wire.
//!
//! 3 to 80 baselines away, 0.3 px of noise a coordinate, of ten matches so many wrong.

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::link::{FrameHeader, MatchRecord};
use stereo_selfcal::{Correspondence, so3};

use crate::lens::{FOCAL_PX, SIZE};

/// Of a frame of these matches, but for their number.
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

/// Inverse distances, in 1/baseline.
const NEARNESS: [f32; 2] = [1.0 / 80.0, 1.0 / 3.0];

/// Turns the sum of four numbers within -1 to 1 into noise of 0.3 px.
const NOISE: f32 = 0.3 * 0.866;

/// `R`, `t` of the rig.
#[derive(Clone, Copy)]
pub(crate) struct Rig {
    rotation: Rotation3<f32>,
    translation: Vector3<f32>,
}

impl Rig {
    /// Off the plain side-by-side rig by so many degrees about each axis, and `t` by as many.
    pub(crate) fn off(degrees: f32) -> Self {
        let angle = degrees.to_radians();
        let turn = so3::exp(&Vector3::new(angle, -angle, angle)).expect("finite");
        let aslant = so3::exp(&(Vector3::new(0.0, 0.6, 0.8) * angle)).expect("finite");
        Self { rotation: turn, translation: aslant * -Vector3::x() }
    }
}

/// Where matches come from.
pub(crate) struct Scene {
    random: ChaCha8Rng,
    pub(crate) rig: Rig,
    /// Of each ten matches.
    pub(crate) wrong: usize,
}

impl Scene {
    pub(crate) fn new(rig: Rig) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(0x5E1F_CA11), rig, wrong: 3 }
    }

    /// Matches of one more pair.
    pub(crate) fn fill(&mut self, records: &mut [MatchRecord]) {
        for (i, record) in records.iter_mut().enumerate() {
            *record = self.record(i % 10 < self.wrong);
        }
    }

    /// One match, inside both images.
    fn record(&mut self, wrong: bool) -> MatchRecord {
        loop {
            let left = self.pixel();
            let right = if wrong { self.pixel() } else { self.seen_right(left) };
            let [left, right] = [left, right].map(|pixel| pixel.map(|x| x + self.noise()));
            let inside = |[u, v]: [f32; 2]| {
                let [width, height] = SIZE.map(f32::from);
                (0.0..width).contains(&u) && (0.0..height).contains(&v)
            };
            let score = 0.5 + 0.5 * self.share();
            let c = Correspondence { left, right, score, grid_step: 0.0 };
            if let Some(record) =
                MatchRecord::encode(&c, &HEADER).ok().filter(|_| inside(left) && inside(right))
            {
                return record;
            }
        }
    }

    fn pixel(&mut self) -> [f32; 2] {
        SIZE.map(|n| f32::from(n) * self.share())
    }

    /// Where the right camera sees what the left one sees, at a distance of chance.
    fn seen_right(&mut self, left: [f32; 2]) -> [f32; 2] {
        let centre = SIZE.map(|n| f32::from(n) * 0.5);
        let [x, y] = [0, 1].map(|i| (left[i] - centre[i]) / FOCAL_PX);
        let [far, near] = NEARNESS;
        let nearness = far + (near - far) * self.share();
        let p = self.rig.rotation * Vector3::new(x, y, 1.0) + self.rig.translation * nearness;
        [centre[0] + FOCAL_PX * p.x / p.z, centre[1] + FOCAL_PX * p.y / p.z]
    }

    fn noise(&mut self) -> f32 {
        let sum: f32 = (0..4).map(|_| self.share() * 2.0 - 1.0).sum();
        sum * NOISE
    }

    /// At random within 0 to 1, in steps of 1/65536.
    fn share(&mut self) -> f32 {
        f32::from(self.random.random::<u16>()) / 65_536.0
    }
}
