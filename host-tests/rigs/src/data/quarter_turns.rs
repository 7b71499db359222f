//! Cameras turned by quarters about their optical axes, together with their images.

use nalgebra::{Matrix3, Vector3};

use super::geometry::{Rows, matrix, rows};
use super::matches::Match;
use super::meta::{LensModel, Meta};

/// Clockwise quarter turns of the left and the right image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuarterTurns(pub [u8; 2]);

impl QuarterTurns {
    /// The turns after which the right camera stands to the right of the left one, and both images have about the same
    /// roll; zero for a side-by-side rig.
    pub fn upright(meta: &Meta) -> Self {
        let centre = -(matrix(&meta.r).transpose() * Vector3::from(meta.t));
        let left = quarters(-centre.y.atan2(centre.x));
        Self([left, (left + Self::of_right(meta)) % 4])
    }

    /// Number of clockwise quarter turns of the right image that bring its roll closest to the roll of the left one.
    pub fn of_right(meta: &Meta) -> u8 {
        let r = matrix(&meta.r);
        quarters(-r[(1, 0)].atan2(r[(0, 0)]))
    }

    /// Whether both turns are zero.
    pub fn is_none(self) -> bool {
        self.0 == [0; 2]
    }

    /// Rotation of rays from the camera frame before the turn to the frame after it. A quarter turn takes x (right) to
    /// y (down).
    ///
    /// * `side`: 0 for the left camera, 1 for the right one.
    pub fn rotation(self, side: usize) -> Matrix3<f64> {
        let (sin, cos) =
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][usize::from(self.0[side] % 4)];
        Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
    }

    /// Maps a pixel of a turned image to the image before its turn.
    ///
    /// * `side`: 0 for the left image, 1 for the right one.
    /// * `size`: width and height of the image before its turn, px.
    pub fn pixel_back(self, side: usize, size: [u16; 2], [u, v]: [f64; 2]) -> [f64; 2] {
        let [right, bottom] = size.map(|n| f64::from(n) - 1.0);
        match self.0[side] % 4 {
            1 => [v, bottom - u],
            2 => [right - u, bottom - v],
            3 => [right - v, u],
            _ => [u, v],
        }
    }

    /// Maps a match of the original images to the turned images.
    pub fn of_match(self, meta: &Meta, m: &Match) -> Match {
        let back = Self(self.0.map(|quarters| (4 - quarters % 4) % 4));
        let at = |side: usize, pixel: [f64; 2]| {
            back.pixel_back(side, self.size(side, meta.sizes()[side]), pixel)
        };
        let ([ul, vl], [ur, vr]) = (at(0, [m.ul, m.vl]), at(1, [m.ur, m.vr]));
        Match { ul, vl, ur, vr, ..*m }
    }

    /// The rig of the turned images.
    pub fn meta(self, meta: &Meta) -> Meta {
        let [left, right] = [self.rotation(0), self.rotation(1)];
        let mut turned = meta.clone();
        turned.r = rows(&(right * matrix(&meta.r) * left.transpose()));
        turned.t = (right * Vector3::from(meta.t)).into();
        let ([size_l, size_r], [lens_l, lens_r]) = (meta.sizes(), meta.lenses());
        turned.k_l = self.camera_matrix(0, size_l, &meta.k_l);
        turned.k_r = self.camera_matrix(1, size_r, &meta.k_r);
        self.turn_lens(0, lens_l, &mut turned.dist_l);
        self.turn_lens(1, lens_r, &mut turned.dist_r);
        [turned.width, turned.height] = self.size(0, size_l);
        turned.set_right(lens_r, self.size(1, size_r));
        turned
    }

    /// Size of an image after its turn, px.
    pub fn size(self, side: usize, [width, height]: [u16; 2]) -> [u16; 2] {
        if self.0[side] % 2 == 1 { [height, width] } else { [width, height] }
    }

    fn camera_matrix(self, side: usize, size: [u16; 2], k: &Rows) -> Rows {
        let [[fx, _, cx], [_, fy, cy], bottom] = *k;
        let [right, below] = size.map(|n| f64::from(n) - 1.0);
        let ([fx, fy], [cx, cy]) = match self.0[side] % 4 {
            1 => ([fy, fx], [below - cy, cx]),
            2 => ([fx, fy], [right - cx, below - cy]),
            3 => ([fy, fx], [cy, right - cx]),
            _ => ([fx, fy], [cx, cy]),
        };
        [[fx, 0.0, cx], [0.0, fy, cy], bottom]
    }

    /// Turns the tangential coefficients of a lens: they are a vector, `(p2, p1)` along x and y.
    fn turn_lens(self, side: usize, lens: LensModel, dist: &mut [f64]) {
        if lens == LensModel::Fisheye {
            return;
        }
        if let [_, _, p1, p2, ..] = dist {
            let turned = self.rotation(side) * Vector3::new(*p2, *p1, 0.0);
            (*p1, *p2) = (turned.y, turned.x);
        }
    }
}

/// Number of quarter turns, 0 to 3, that is nearest to an angle, rad.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 3")]
fn quarters(angle: f64) -> u8 {
    (angle / std::f64::consts::FRAC_PI_2).round().rem_euclid(4.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;

    /// The chessboard's rig, with the left and the right camera rolled by these angles.
    fn rig(degrees: [f64; 2]) -> Meta {
        let mut meta = Dataset::find_meta("opencv_chess_sift".as_ref()).unwrap();
        let [l, r] = degrees.map(|degrees| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
        });
        meta.r = rows(&(r * matrix(&meta.r) * l.transpose()));
        meta.t = (r * Vector3::from(meta.t)).into();
        meta
    }

    #[test]
    fn a_turned_image_sees_the_rays_of_the_camera_in_its_turned_frame() {
        for turns in [[0, 0], [1, 3], [2, 2], [3, 1]].map(QuarterTurns) {
            let meta = rig([0.0; 2]);
            let turned = turns.meta(&meta);
            let [before, after] = [&meta, &turned].map(|meta| meta.cameras::<f64>().unwrap());
            for at in [[20.0, 30.0], [300.0, 100.0]] {
                for (side, before, after) in
                    [(0, before.left, after.left), (1, before.right, after.right)]
                {
                    let there = turns.pixel_back(side, [640, 480], at);
                    let ray = turns.rotation(side) * before.ray(there).unwrap().push(1.0);
                    assert!((ray - after.ray(at).unwrap().push(1.0)).norm() < 1e-9, "{turns:?}");
                }
            }
        }
    }

    #[test]
    fn a_match_mapped_to_the_turned_images_maps_back() {
        let meta = rig([0.0; 2]);
        for turns in [[0, 0], [1, 3], [2, 2], [3, 1]].map(QuarterTurns) {
            let m = Match { ul: 20.0, vl: 30.0, ur: 300.0, vr: 100.0, score: 1.0, step: 0.0 };
            let there = turns.of_match(&meta, &m);
            let [size_l, size_r] = meta.sizes();
            let left = turns.pixel_back(0, size_l, [there.ul, there.vl]);
            let right = turns.pixel_back(1, size_r, [there.ur, there.vr]);
            let off = [left[0] - m.ul, left[1] - m.vl, right[0] - m.ur, right[1] - m.vr];
            assert!(off.iter().all(|px| px.abs() < 1e-12), "{turns:?}: {off:?}");
        }
    }

    #[test]
    fn any_rig_is_turned_until_its_right_camera_stands_to_the_right() {
        for left in [0.0, 90.0, -90.0, 30.0] {
            for right in [0.0, 90.0, 180.0, -90.0, 171.0] {
                let meta = rig([left, right]);
                let turned = QuarterTurns::upright(&meta).meta(&meta);
                let r = matrix(&turned.r);
                let centre = -(r.transpose() * Vector3::from(turned.t));
                assert!(r[(0, 0)] > 0.7 && centre.x > 0.7, "{left} {right}: {r} {centre}");
            }
        }
        assert!(QuarterTurns::upright(&rig([0.0; 2])).is_none());
    }
}
