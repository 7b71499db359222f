//! The paper's turned views: an image turned by a known rotation, as if its camera had been.
//!
//! Left: `p_l' = Rot p_l`, so `R' = R Rot^T` and `t` stays. Right: `p_r' = Rot p_r`, so `R' = Rot R` and
//! `t' = Rot t`: a turn across the baseline moves `t`, one about it does not. The paper does not say which
//! image of the public sets it turns; the script of its authors reads a turned right one. Points that leave
//! the image are dropped. A rectified data set (R = I) becomes evidence only when it is turned.

use anyhow::Result;
use nalgebra::{Matrix3, Vector2, Vector3};
use stereo_selfcal::{Camera, so3};

use crate::data::{Dataset, Match, Rows, matrix, rows};

/// Which way the left view is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TurnedView {
    /// About -x: the camera looks up, the scene moves down in the image.
    Top,
    /// About x: the camera looks down.
    Bottom,
    /// About y: the camera looks left.
    Left,
    /// About -y: the camera looks right.
    Right,
}

/// Which camera is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum TurnedCamera {
    /// The left one: `t` stays.
    #[default]
    Left,
    /// The right one: `t` moves, unless it is turned about the baseline.
    Right,
    /// The left one as the view says, the right one as the next of top, right, bottom, left.
    Both,
}

impl TurnedView {
    /// The next of top, right, bottom, left.
    fn next(self) -> Self {
        match self {
            Self::Top => Self::Right,
            Self::Right => Self::Bottom,
            Self::Bottom => Self::Left,
            Self::Left => Self::Top,
        }
    }

    /// Turns a view, or both, of a data set by an angle.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn turn_camera(self, set: &Dataset, degrees: f64, camera: TurnedCamera) -> Result<Dataset> {
        match camera {
            TurnedCamera::Left => self.turn(set, degrees),
            TurnedCamera::Right => self.turn_right(set, degrees),
            TurnedCamera::Both => self.next().turn_right(&self.turn(set, degrees)?, degrees),
        }
    }

    fn turn_right(self, set: &Dataset, degrees: f64) -> Result<Dataset> {
        let camera = set.cameras::<f64>()?.right;
        let rotation = self.rotation(degrees);
        let turned = |m: &Match| -> Option<Match> {
            let [ur, vr] = turned_pixel(&camera, &rotation, [m.ur, m.vr])?;
            Some(Match { ur, vr, ..*m })
        };
        let mut result = set.clone();
        result.name = format!("{} right {self:?} {degrees}", set.name).to_lowercase();
        let turn = |r: &mut Rows, t: &mut [f64; 3]| {
            *r = rows(&(rotation * matrix(r)));
            *t = (rotation * Vector3::from(*t)).into();
        };
        turn(&mut result.meta.r, &mut result.meta.t);
        result.rigs.iter_mut().for_each(|rig| turn(&mut rig.r, &mut rig.t));
        for pair in &mut result.pairs {
            *pair = pair.iter().filter_map(turned).collect();
        }
        Ok(result)
    }

    /// Turns the left view of a data set by an angle.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn turn(self, set: &Dataset, degrees: f64) -> Result<Dataset> {
        let camera = set.cameras::<f64>()?.left;
        let rotation = self.rotation(degrees);
        let turned = |m: &Match| -> Option<Match> {
            let [ul, vl] = turned_pixel(&camera, &rotation, [m.ul, m.vl])?;
            Some(Match { ul, vl, ..*m })
        };
        let mut result = set.clone();
        result.name = format!("{} {self:?} {degrees}", set.name).to_lowercase();
        let turn = |r: &mut Rows| *r = rows(&(matrix(r) * rotation.transpose()));
        turn(&mut result.meta.r);
        result.rigs.iter_mut().for_each(|rig| turn(&mut rig.r));
        for pair in &mut result.pairs {
            *pair = pair.iter().filter_map(turned).collect();
        }
        Ok(result)
    }

    /// `Rot`, old to new left camera frame.
    #[must_use]
    pub fn rotation(self, degrees: f64) -> Matrix3<f64> {
        let axis = match self {
            Self::Top => -Vector3::x(),
            Self::Bottom => Vector3::x(),
            Self::Left => Vector3::y(),
            Self::Right => -Vector3::y(),
        };
        let vector = axis * degrees.to_radians();
        so3::exp(&vector).map_or(Matrix3::identity(), |r| *r.matrix())
    }
}

fn turned_pixel(camera: &Camera<f64>, r: &Matrix3<f64>, pixel: [f64; 2]) -> Option<[f64; 2]> {
    let ray = camera.ray(pixel).ok()?;
    let p = r * Vector3::new(ray.x, ray.y, 1.0);
    if p.z <= 0.0 {
        return None;
    }
    let [u, v] = camera.pixel(Vector2::new(p.x / p.z, p.y / p.z)).ok()?;
    let [width, height] = camera.intrinsics().size.map(f64::from);
    let inside = (0.0..=width - 1.0).contains(&u) && (0.0..=height - 1.0).contains(&v);
    inside.then_some([u, v])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::rigs::Rig;
    use clap::ValueEnum;
    use stereo_selfcal::metrics::Deviation;
    use stereo_selfcal::{RayPair, RectifyingRotations, row_offset};

    fn median_row_offset_px(set: &Dataset) -> f64 {
        let cameras = set.cameras::<f64>().unwrap();
        let rotations = RectifyingRotations::from(&set.truth::<f64>().unwrap());
        let offset = |m: &Match| {
            let pair: RayPair<f64> = cameras.rays(&m.correspondence()).unwrap();
            row_offset(&rotations, &pair).unwrap().abs() * cameras.mean_focal()
        };
        let mut offsets: Vec<f64> = set.pairs.iter().flatten().map(offset).collect();
        offsets.sort_by(f64::total_cmp);
        offsets[offsets.len() / 2]
    }

    #[test]
    fn turned_data_fit_the_turned_extrinsics_and_not_the_plain_ones() {
        let set = Dataset::load(&Dataset::shipped().join("motorcycle_sift")).unwrap();
        for camera in TurnedCamera::value_variants() {
            for view in TurnedView::value_variants() {
                let turned = view.turn_camera(&set, 5.0, *camera).unwrap();
                assert!(turned.pairs[0].len() < set.pairs[0].len(), "{view:?}: none dropped");
                assert!(median_row_offset_px(&turned) < 0.3, "{camera:?} {view:?}");
                let wrong = Dataset { meta: set.meta.clone(), ..turned };
                assert!(median_row_offset_px(&wrong) > 1.0, "{camera:?} {view:?}");
            }
        }
    }

    #[test]
    fn the_baseline_moves_where_the_right_camera_turns_across_it_alone() {
        let set = Dataset::load(&Dataset::shipped().join("motorcycle_sift")).unwrap();
        let moved = |view: TurnedView, camera| {
            let turned = view.turn_camera(&set, 5.0, camera).unwrap();
            let [before, after] = [&set, &turned].map(|set| set.truth::<f64>().unwrap());
            Deviation::between(&before, &after).translation.to_degrees()
        };
        for view in TurnedView::value_variants() {
            assert!(moved(*view, TurnedCamera::Left) < 1e-9);
            let across = [TurnedView::Left, TurnedView::Right].contains(view);
            let expected = if across { 5.0 } else { 0.0 };
            assert!((moved(*view, TurnedCamera::Right) - expected).abs() < 1e-9, "{view:?}");
            let expected = 5.0 - expected;
            assert!((moved(*view, TurnedCamera::Both) - expected).abs() < 1e-9, "{view:?}");
        }
    }

    #[test]
    fn the_rig_of_each_pair_is_turned_as_that_of_the_set() {
        let mut set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
        set.rigs = vec![Rig::from(&set.truth().unwrap()); set.pairs.len()];
        let turned = TurnedView::Left.turn(&set, 5.0).unwrap();
        assert_ne!(turned.truth::<f64>().unwrap(), set.truth().unwrap());
        for truth in turned.truths().unwrap() {
            let off = Deviation::between(&truth, &turned.truth().unwrap());
            assert!(off.rotation < 1e-12 && off.translation < 1e-12, "{off:?}");
        }
    }

    #[test]
    fn the_scene_moves_opposite_to_the_camera() {
        let set = Dataset::load(&Dataset::shipped().join("motorcycle_sift")).unwrap();
        let camera = set.cameras::<f64>().unwrap().left;
        let moved = |view: TurnedView| {
            turned_pixel(&camera, &view.rotation(5.0), camera.intrinsics().principal).unwrap()
        };
        let [cx, cy] = camera.intrinsics().principal;
        assert!(moved(TurnedView::Top)[1] > cy + 50.0);
        assert!(moved(TurnedView::Bottom)[1] < cy - 50.0);
        assert!(moved(TurnedView::Left)[0] > cx + 50.0);
        assert!(moved(TurnedView::Right)[0] < cx - 50.0);
    }
}
