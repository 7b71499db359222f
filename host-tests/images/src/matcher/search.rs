//! Search along the expected rows for corresponding corners of both images.

use std::f64::consts::FRAC_PI_4;

use nalgebra::Vector3;
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::{Camera, Cameras, Extrinsics};

use super::MatcherConfig;
use super::keypoints::{Keypoints, distance};

/// Largest number of differing bits of the descriptors of a match.
const MOST_BITS: u32 = 70;

/// Largest difference of the pyramid levels of two corners.
const MOST_LEVELS: u8 = 2;

/// Two candidates closer than this are the same corner, px of the pyramid level.
const SAME_PX: f64 = 3.0;

/// A disparity of a larger magnitude has a clear sign, px of the pyramid level.
const CLEAR_PX: f64 = 2.0;

/// Two corners that look alike.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tentative {
    pub(super) left: usize,
    pub(super) right: usize,
    /// 1 less the ratio of the best descriptor distance to the second best.
    pub(super) margin: f64,
}

/// Half of the band around a row: the sum of both parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Band {
    /// Largest turn of the cameras.
    pub(super) rad: f64,
    /// Addition to the effect of the turn, px.
    pub(super) px: f64,
}

/// Result of a search.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) matches: Vec<Tentative>,
    /// Number of mutual matches with clearly positive and with clearly negative disparity. A match with a negative
    /// disparity beyond the band of the prior is not in `matches`.
    pub(super) signs: [usize; 2],
}

/// Rectification that the search follows, and its limits.
#[derive(Debug, Clone)]
pub(super) struct Search {
    cameras: Cameras<f64>,
    rotations: RectifyingRotations<f64>,
    focal: f64,
    band: Band,
    /// Largest disparity, px.
    most_disparity: f64,
    ratio: f64,
}

/// A corner in the rectified image, px from its principal point.
#[derive(Debug, Clone, Copy)]
struct Rectified {
    index: usize,
    x: f64,
    y: f64,
    level: u8,
}

/// The best corner of a search, and the descriptor distances of the best and the second best, bits.
#[derive(Debug, Clone, Copy)]
struct Best {
    index: usize,
    bits: u32,
    second: u32,
    disparity: f64,
}

impl Search {
    pub(super) fn new(
        cameras: Cameras<f64>,
        extrinsics: &Extrinsics<f64>,
        band: Band,
        config: &MatcherConfig,
    ) -> Self {
        let [width, _] = cameras.left.intrinsics().size;
        Self {
            rotations: RectifyingRotations::from(extrinsics),
            focal: cameras.mean_focal(),
            cameras,
            band,
            most_disparity: f64::from(width) * config.range,
            ratio: config.ratio,
        }
    }

    /// Pairs of corners each of which is the best match of the other.
    pub(super) fn tentative(&self, [left, right]: [&Keypoints; 2]) -> Found {
        let l = self.rectified(&self.cameras.left, self.rotations.left().matrix(), left);
        let r = self.rectified(&self.cameras.right, self.rotations.right().matrix(), right);
        let to_right = self.best_of_all([&l, &r], [left, right], 1.0);
        let to_left = self.best_of_all([&r, &l], [right, left], -1.0);
        let mut found = Found { matches: Vec::new(), signs: [0; 2] };
        for (i, best) in to_right.iter().enumerate() {
            let Some(best) = best else { continue };
            let mutual = to_left[best.index].is_some_and(|back| back.index == i);
            let margin = 1.0 - f64::from(best.bits) / f64::from(best.second.max(1));
            if !mutual || best.bits > MOST_BITS || margin < 1.0 - self.ratio {
                continue;
            }
            let clear = CLEAR_PX * left.pixel(i).max(right.pixel(best.index));
            if best.disparity.abs() > clear {
                found.signs[usize::from(best.disparity < 0.0)] += 1;
            }
            if best.disparity >= -self.slack() {
                found.matches.push(Tentative { left: i, right: best.index, margin });
            }
        }
        found
    }

    /// Half of the band in the middle of the image, px. A turn of the cameras within the prior can make the disparity
    /// of a far point negative by as much.
    fn slack(&self) -> f64 {
        self.focal * self.band.rad.tan() + self.band.px
    }

    fn rectified(
        &self,
        camera: &Camera<f64>,
        rotation: &nalgebra::Matrix3<f64>,
        keypoints: &Keypoints,
    ) -> Vec<Rectified> {
        let places = keypoints.places.iter().zip(&keypoints.levels).enumerate();
        let mut all: Vec<Rectified> = places
            .filter_map(|(index, (place, level))| {
                let ray: Vector3<f64> = rotation * camera.ray(*place).ok()?.push(1.0);
                let seen = ray.z > FRAC_PI_4.cos() * 0.5 * ray.norm();
                let [x, y] = [ray.x, ray.y].map(|x| self.focal * x / ray.z);
                seen.then_some(Rectified { index, x, y, level: *level })
            })
            .collect();
        all.sort_by(|a, b| a.y.total_cmp(&b.y));
        all
    }

    /// The best match in `to` for each corner of `from`.
    ///
    /// * `sign`: 1 if `from` is the left image, -1 if it is the right one.
    fn best_of_all(
        &self,
        [from, to]: [&[Rectified]; 2],
        [ours, others]: [&Keypoints; 2],
        sign: f64,
    ) -> Vec<Option<Best>> {
        let mut all = vec![None; ours.len()];
        for corner in from {
            let place = [corner.x, corner.y].map(|x| x / self.focal);
            // A turn of a camera moves the border of an image more than its middle.
            let widening = 1.0 + place[0] * place[0] + place[1] * place[1];
            let band = self.slack() * widening;
            let begin = to.partition_point(|other| other.y < corner.y - band);
            let near = to[begin..].iter().take_while(|other| other.y <= corner.y + band);
            let descriptor = &ours.descriptors[corner.index];
            let mut best: Option<Best> = None;
            for other in near {
                let disparity = sign * (corner.x - other.x);
                if disparity.abs() > self.most_disparity
                    || other.level.abs_diff(corner.level) > MOST_LEVELS
                {
                    continue;
                }
                let bits = distance(descriptor, &others.descriptors[other.index]);
                best = Some(better(best, bits, other, disparity, others));
            }
            all[corner.index] = best;
        }
        all
    }
}

/// The best so far, updated with one more candidate.
fn better(
    best: Option<Best>,
    bits: u32,
    seen: &Rectified,
    disparity: f64,
    all: &Keypoints,
) -> Best {
    let new = Best { index: seen.index, bits, second: 256, disparity };
    let Some(old) = best else { return new };
    if bits >= old.second {
        return old;
    }
    let [[u, v], [s, t]] = [all.places[old.index], all.places[seen.index]];
    let apart = SAME_PX * all.pixel(seen.index);
    let same = (u - s) * (u - s) + (v - t) * (v - t) < apart * apart;
    match (bits < old.bits, same) {
        (true, true) => Best { second: old.second, ..new },
        (true, false) => Best { second: old.bits, ..new },
        (false, true) => old,
        (false, false) => Best { second: bits, ..old },
    }
}
