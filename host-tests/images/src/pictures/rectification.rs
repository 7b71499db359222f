//! A stereo pair before and after a calibration: rectified images, dense disparities, row offsets of its matches.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use rigs::data::Match;
use sim::run::SCREEN_PX;
use sim::stats::{median, quantile};
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::{Cameras, Extrinsics};

use super::grey::Grey;
use super::sgm::Disparities;
use super::warp::rectified;

/// A stereo pair with its cameras and matches.
#[derive(Debug, Clone)]
pub struct StereoImages {
    /// Left and right image.
    pub images: [Grey; 2],
    /// Their cameras.
    pub cameras: Cameras<f64>,
    /// Matches between them, px.
    pub matches: Vec<Match>,
    /// Px of the camera's image in a pixel of these images: 1 unless they are smaller.
    pub scale: f64,
}

/// A pair, rectified by one set of extrinsics.
#[derive(Debug, Clone)]
pub struct Rectification {
    /// Rectified left and right image.
    pub images: [Grey; 2],
    /// Rotations into the rectified camera.
    pub rotations: RectifyingRotations<f64>,
    /// The rectified camera, the same for both images.
    pub camera: RectifiedCamera<f64>,
    /// Disparities of the left image.
    pub disparities: Disparities,
    /// Searched range, px.
    pub range: u16,
    /// Ends of matches in the rectified images, px.
    pub matches: Vec<[[f64; 2]; 2]>,
}

impl StereoImages {
    /// Row offset of a match, px of the camera's image; `None` if it has no ray, or no row.
    pub fn offset_px(&self, extrinsics: &Extrinsics<f64>, m: &Match) -> Option<f64> {
        let rays: RayPair<f64> = self.cameras.rays(&m.correspondence()).ok()?;
        let offset = row_offset(&RectifyingRotations::from(extrinsics), &rays)?;
        Some(offset * self.cameras.mean_focal() * self.scale)
    }

    /// Indices of the matches within [`SCREEN_PX`] of their rows.
    pub fn in_row(&self, extrinsics: &Extrinsics<f64>) -> Vec<usize> {
        let fits = |i: &usize| {
            let offset = self.offset_px(extrinsics, &self.matches[*i]);
            offset.is_some_and(|px| px.abs() <= SCREEN_PX)
        };
        (0..self.matches.len()).filter(fits).collect()
    }

    /// Median row offset of some matches, px of the camera's image; `None` if none has a row.
    pub fn median_px(&self, extrinsics: &Extrinsics<f64>, kept: &[usize]) -> Option<f64> {
        let offset = |&i: &usize| self.offset_px(extrinsics, &self.matches[i]).map(f64::abs);
        median(kept.iter().filter_map(offset))
    }

    /// Range of disparities that contains 95 % of some matches plus a margin of an eighth: a multiple of 16, at most
    /// `most`, px. `None` without a match or without a common view.
    pub fn range(&self, extrinsics: &Extrinsics<f64>, kept: &[usize], most: u16) -> Option<u16> {
        let rotations = RectifyingRotations::from(extrinsics);
        let camera = RectifiedCamera::try_choose(&self.cameras, &rotations, 0.0).ok()?;
        let ends = self.ends(&rotations, &camera, kept);
        let high = quantile(ends.map(|[l, r]| l[0] - r[0]), 0.95)?;
        (16..=most).step_by(16).find(|&n| f64::from(n) > high * 1.125 || n > most - 16)
    }

    /// The pair in the camera in which both cameras see every rectified pixel (alpha 0).
    ///
    /// * `kept`: indices of the matches whose ends are computed.
    /// * `range`: disparities searched, px.
    ///
    /// # Errors
    /// If the rectified views have nothing in common.
    pub fn rectification(
        &self,
        extrinsics: &Extrinsics<f64>,
        kept: &[usize],
        range: u16,
    ) -> Result<Rectification> {
        let rotations = RectifyingRotations::from(extrinsics);
        let camera = RectifiedCamera::try_choose(&self.cameras, &rotations, 0.0)
            .context("no rectified camera sees the view of both cameras")?;
        let [left, right] = &self.images;
        let images = [
            rectified(left, &self.cameras.left, rotations.left(), &camera, left.size()),
            rectified(right, &self.cameras.right, rotations.right(), &camera, left.size()),
        ];
        let disparities = Disparities::of(&images[0], &images[1], range);
        let matches = self.ends(&rotations, &camera, kept).collect();
        Ok(Rectification { images, rotations, camera, disparities, range, matches })
    }

    /// Ends of matches in the rectified images, px; points behind a camera are left out.
    fn ends(
        &self,
        rotations: &RectifyingRotations<f64>,
        camera: &RectifiedCamera<f64>,
        kept: &[usize],
    ) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let [cx, cy] = camera.principal;
        let pixel = move |p: Vector3<f64>| {
            (p.z > 0.0).then(|| [cx + camera.focal * p.x / p.z, cy + camera.focal * p.y / p.z])
        };
        kept.iter().filter_map(move |&i| {
            let m = &self.matches[i];
            let left = self.cameras.left.ray([m.ul, m.vl]).ok()?.push(1.0);
            let right = self.cameras.right.ray([m.ur, m.vr]).ok()?.push(1.0);
            Some([pixel(rotations.left() * left)?, pixel(rotations.right() * right)?])
        })
    }
}

impl Rectification {
    /// Share of the left pixels whose disparity from the left image agrees with that from the right.
    pub fn found(&self) -> f64 {
        self.disparities.valid_share(&self.images[0])
    }
}
