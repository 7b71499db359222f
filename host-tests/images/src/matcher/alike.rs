//! Makes pictures of unlike cameras alike: the descriptors and windows of the matcher agree only if the cameras have
//! about the same roll and focal length.
//!
//! The right picture is turned by quarters until its roll against the left one is least. The picture of the longer
//! focal length is resampled to the shorter focal length. Matches are mapped back to the original pictures.

use anyhow::Result;
use image::metadata::Orientation;
use rigs::data::{Match, Meta, QuarterTurns};

use crate::picture::Picture;
use crate::resized::{self, Change};

/// Ratio of two focal lengths below which they are alike.
const ALIKE: f64 = 1.15;

/// Changes that make the pictures of unlike cameras alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Alike {
    turns: QuarterTurns,
    /// Sizes before any change, px.
    from: [[u16; 2]; 2],
    /// Sizes after the turn and the resampling, px.
    to: [[u16; 2]; 2],
}

impl Alike {
    /// `None` if nothing has to change.
    pub(super) fn of(meta: &Meta) -> Option<Self> {
        let turns = QuarterTurns([0, QuarterTurns::of_right(meta)]);
        let focal = [meta.k_l, meta.k_r].map(|k| k[0][0]);
        let [l, r] = focal;
        let shrunk = |side: usize| {
            let ratio = l.min(r) / focal[side];
            if ratio * ALIKE > 1.0 { 1.0 } else { ratio }
        };
        let from = meta.sizes();
        let scaled = |side: usize| {
            turns
                .size(side, from[side])
                .map(|n| (f64::from(n) * shrunk(side)).round().max(2.0) as u16)
        };
        let alike = Self { turns, from, to: [scaled(0), scaled(1)] };
        (!turns.is_none() || alike.to != from).then_some(alike)
    }

    /// Both pictures after the changes.
    pub(super) fn pictures(&self, [left, right]: [&Picture; 2]) -> Result<[Picture; 2]> {
        let turn = match self.turns.0[1] {
            1 => Orientation::Rotate90,
            2 => Orientation::Rotate180,
            3 => Orientation::Rotate270,
            _ => Orientation::NoTransforms,
        };
        let sized = |picture: Picture, size: [u16; 2]| {
            if picture.size() == size { Ok(picture) } else { picture.resized(size) }
        };
        Ok([sized(left.clone(), self.to[0])?, sized(right.clone().turned(turn), self.to[1])?])
    }

    /// Maps a match of the changed pictures back to the original pictures.
    pub(super) fn back(&self, m: &Match) -> Match {
        let back = |side: usize, pixel: [f64; 2]| {
            let whole = self.turns.size(side, self.from[side]).map(f64::from);
            let at = |i: usize| (pixel[i] + 0.5) * whole[i] / f64::from(self.to[side][i]) - 0.5;
            self.turns.pixel_back(side, self.from[side], [at(0), at(1)])
        };
        let ([ul, vl], [ur, vr]) = (back(0, [m.ul, m.vl]), back(1, [m.ur, m.vr]));
        Match { ul, vl, ur, vr, ..*m }
    }

    /// The rig of the changed pictures.
    pub(super) fn meta(&self, meta: &Meta) -> Meta {
        let turned = self.turns.meta(meta);
        let from = turned.sizes();
        let change = |side: usize| Change::scaled(from[side], self.to[side]);
        resized::changed(&turned, [change(0), change(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use rigs::data::{Dataset, matrix, rows};

    fn rolled(degrees: f64) -> Meta {
        let mut meta = Dataset::find_meta("opencv_chess_sift".as_ref()).unwrap();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        meta.r = rows(&(turn * matrix(&meta.r)));
        meta.t = (turn * Vector3::from(meta.t)).into();
        meta.k_r[0][0] *= 2.0;
        meta.k_r[1][1] *= 2.2;
        meta
    }

    #[test]
    fn a_match_of_the_alike_pictures_has_the_rays_of_the_cameras() {
        for degrees in [0.0, 90.0, 180.0, -90.0, 171.0] {
            let meta = rolled(degrees);
            let alike = Alike::of(&meta).unwrap();
            let rig = alike.meta(&meta);
            let (inner, outer) = (rig.cameras::<f64>().unwrap(), meta.cameras::<f64>().unwrap());
            let r = [&rig, &meta].map(|meta| matrix(&meta.r));
            for [u, v] in [[20.0, 30.0], [100.0, 40.0], [61.0, 90.0]] {
                let back = alike.back(&Match { ul: u, vl: v, ur: u, vr: v, score: 1.0, step: 0.0 });
                let left =
                    inner.left.ray([u, v]).unwrap() - outer.left.ray([back.ul, back.vl]).unwrap();
                // Both rays are rotated to the left frame, so that the turn of the right camera cancels.
                let right = r[0].transpose() * inner.right.ray([u, v]).unwrap().push(1.0)
                    - r[1].transpose() * outer.right.ray([back.ur, back.vr]).unwrap().push(1.0);
                assert!(left.norm() < 1e-9 && right.norm() < 1e-9, "{degrees}: {left} {right}");
            }
            // The remaining roll is within 45 degrees.
            assert!(r[0][(0, 0)] > 0.7, "{degrees}: {}", r[0]);
        }
    }

    #[test]
    fn cameras_that_are_alike_are_left_alone() {
        let meta = Dataset::find_meta("opencv_chess_sift".as_ref()).unwrap();
        assert_eq!(Alike::of(&meta), None);
    }
}
