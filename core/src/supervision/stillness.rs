//! Whether a pair shows the scene of the pair before it again.
//!
//! A vehicle that stands sends the same matches for minutes, mismatches and all: as evidence they are
//! one pair, however often they come.

use crate::correspondence::RayPair;
use crate::scalar::Scalar;

/// Correspondences remembered of a pair.
const REMEMBERED: usize = 32;

/// A correspondence is seen again if no coordinate has moved further, px.
const SAME_PX: f64 = 1.5;

/// Share of the remembered correspondences that makes it the same scene: 0.6 to 0.8 in recordings of
/// standing cameras, up to 0.13 in those of moving ones.
const SAME_SHARE: f64 = 0.3;

/// Steps that coordinates are remembered in, of a pixel.
const STEPS: f64 = 4.0;

/// Some correspondences of the last pair. RAM: 8 bytes each.
#[derive(Debug, Clone)]
pub(crate) struct Stillness {
    remembered: heapless::Vec<[u16; 4], REMEMBERED>,
}

impl Stillness {
    pub(crate) const fn new() -> Self {
        Self { remembered: heapless::Vec::new() }
    }

    /// Whether the batch shows the scene of the last one; remembers it in its place.
    pub(crate) fn note<T: Scalar>(&mut self, pairs: &[RayPair<T>], focal: T) -> bool {
        let same = (T::lit(SAME_PX * STEPS)).to_u16();
        let again = self.remembered.iter().filter(|old| {
            pairs.iter().any(|new| {
                coordinates(new, focal).iter().zip(*old).all(|(a, b)| a.abs_diff(*b) <= same)
            })
        });
        let again = again.count();
        let count = |n: usize| T::count(u32::try_from(n).unwrap_or(u32::MAX));
        let known = count(self.remembered.len());
        let repeated = known > T::ZERO && count(again) > T::lit(SAME_SHARE) * known;
        self.remembered.clear();
        let stride = pairs.len().div_ceil(REMEMBERED).max(1);
        for pair in pairs.iter().step_by(stride) {
            // Never full: the stride sees to it.
            let _ = self.remembered.push(coordinates(pair, focal));
        }
        repeated
    }

    pub(crate) fn forget(&mut self) {
        self.remembered.clear();
    }
}

/// In steps from a corner that no image reaches.
fn coordinates<T: Scalar>(pair: &RayPair<T>, focal: T) -> [u16; 4] {
    let ([a, b], [c, d]) = (pair.left(), pair.right());
    [a, b, c, d].map(|x| (x * focal * T::lit(STEPS) + T::lit(32_768.0)).to_u16())
}
