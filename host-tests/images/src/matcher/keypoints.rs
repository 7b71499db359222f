//! Corners spread over an image on a pyramid, each with a binary descriptor.

use anyhow::Result;
use kornia_imgproc::features::{OrbDetector, hamming_distance};

use crate::picture::Picture;

/// Scale between neighbouring levels of the pyramid.
pub(super) const STEP: f64 = 1.2;

/// Least difference of a corner from its ring, as a share of full scale.
const THRESHOLD: f32 = 12.0 / 255.0;

/// Corners of one image, in px of the unscaled image.
#[derive(Debug, Clone)]
pub(super) struct Keypoints {
    /// `[u, v]`.
    pub(super) places: Vec<[f64; 2]>,
    /// Level of the pyramid of each corner; 0 is the image itself.
    pub(super) levels: Vec<u8>,
    /// Size of a pixel of each level, px of the unscaled image.
    pixels: Vec<f64>,
    /// Descriptor of each corner, 256 bits.
    pub(super) descriptors: Vec<[u8; 32]>,
}

impl Keypoints {
    /// Corners of an image: FAST with a Harris score, spread by a quadtree, described by rotated BRIEF (ORB).
    ///
    /// * `scale`: size of a pixel of `picture`, px of the unscaled image.
    pub(super) fn of(picture: &Picture, count: usize, levels: usize, scale: f64) -> Result<Self> {
        let detector = OrbDetector {
            n_keypoints: count,
            n_scales: levels,
            ini_fast_threshold: THRESHOLD,
            ..OrbDetector::default()
        };
        let found = detector.detect_and_extract_u8(picture.image())?;
        let places = found.keypoints_xy.iter().map(|xy| xy.map(|x| f64::from(x) * scale)).collect();
        let pixels = (0..=u8::MAX).take(levels).map(|i| scale * STEP.powi(i.into())).collect();
        Ok(Self { places, levels: found.octaves, descriptors: found.descriptors, pixels })
    }

    /// Size of a pixel of the level that a corner was found in, px of the unscaled image.
    pub(super) fn pixel(&self, corner: usize) -> f64 {
        self.pixels[usize::from(self.levels[corner])]
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }
}

/// Number of bits that differ, 0 to 256.
pub(super) fn distance(a: &[u8; 32], b: &[u8; 32]) -> u32 {
    hamming_distance(a, b)
}
