//! The paper's turned views: an image turned by a known rotation, as if its camera had turned.
//!
//! Left: `p_l' = Rot p_l`, so `R' = R Rot^T` and `t` stays. Right: `p_r' = Rot p_r`, so `R' = Rot R` and `t' = Rot t`:
//! a turn across the baseline moves `t`; a turn about the baseline does not. The paper does not say which image of the
//! public sets it turns; its authors' script reads a turned right image. Points that leave the image are dropped. A
//! rectified data set (`R = I`) is evidence only when it is turned, because a run that starts from `R = I` would start
//! at the truth.

use anyhow::Result;
use nalgebra::{Matrix3, Vector2, Vector3};
use stereo_selfcal::geometry::so3;
use stereo_selfcal::{Camera, Cameras};
use strum::{Display, EnumMessage, EnumString, VariantArray};

use crate::data::{Dataset, Match, Meta, Rows, matrix, rows};

/// Direction in which a camera is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display, EnumMessage, EnumString, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum TurnedView {
    /// `Rot` is about -x: the camera looks up, and the scene moves down in the image.
    Top,
    /// `Rot` is about x: the camera looks down.
    Bottom,
    /// `Rot` is about y: the camera looks left.
    Left,
    /// `Rot` is about -y: the camera looks right.
    Right,
}

/// The turned camera.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Display, EnumMessage, EnumString, VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
pub enum TurnedCamera {
    /// The left one: `t` stays.
    #[default]
    Left,
    /// The right one: `t` moves, unless it is turned about the baseline.
    Right,
    /// The left one in the given direction, the right one in the next direction of the cycle top, right, bottom, left.
    Both,
}

impl TurnedView {
    /// The next direction of the cycle top, right, bottom, left.
    fn next(self) -> Self {
        match self {
            Self::Top => Self::Right,
            Self::Right => Self::Bottom,
            Self::Bottom => Self::Left,
            Self::Left => Self::Top,
        }
    }

    /// Turns one view or both of a data set by an angle.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn turn_camera(self, set: &Dataset, degrees: f64, camera: TurnedCamera) -> Result<Dataset> {
        Ok(Turn::new(&set.meta, self, degrees, camera)?.set(set))
    }

    /// Turns the left view of a data set by an angle.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn turn(self, set: &Dataset, degrees: f64) -> Result<Dataset> {
        self.turn_camera(set, degrees, TurnedCamera::Left)
    }

    /// `Rot`, from the old to the new frame of the turned camera.
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

/// Turn of one view or both, for a rig, for single pairs, and for a whole data set.
#[derive(Debug, Clone)]
pub struct Turn {
    cameras: Cameras<f64>,
    degrees: f64,
    /// Directions of the left and the right camera; `None` for a camera that is not turned.
    views: [Option<TurnedView>; 2],
}

impl Turn {
    /// A turn of the cameras of a rig.
    ///
    /// * `view`: direction of the turned camera; of the left one if both are turned.
    ///
    /// # Errors
    /// If the cameras of the rig are not valid.
    pub fn new(rig: &Meta, view: TurnedView, degrees: f64, camera: TurnedCamera) -> Result<Self> {
        let views = match camera {
            TurnedCamera::Left => [Some(view), None],
            TurnedCamera::Right => [None, Some(view)],
            TurnedCamera::Both => [Some(view), Some(view.next())],
        };
        Ok(Self { cameras: rig.cameras()?, degrees, views })
    }

    /// The turned data set.
    pub fn set(&self, set: &Dataset) -> Dataset {
        let mut rigs = set.rigs.clone();
        for rig in &mut rigs {
            self.extrinsics(&mut rig.r, &mut rig.t);
        }
        Dataset {
            name: self.name(&set.name),
            meta: self.meta(&set.meta),
            pairs: set.pairs.iter().map(|pair| self.pair(pair)).collect(),
            rigs,
        }
    }

    /// Name of the turned data set or rig.
    pub fn name(&self, name: &str) -> String {
        let said = |side: &str, view: Option<TurnedView>| {
            view.map_or(String::new(), |view| format!("{side} {view:?} {}", self.degrees))
        };
        let [left, right] = self.views;
        format!("{name}{}{}", said("", left), said(" right", right)).to_lowercase()
    }

    /// The turned rig. No calibration has measured it, and its yaw counts as a guess ([`Meta::FACTORY_YAW_SD`]).
    pub fn meta(&self, rig: &Meta) -> Meta {
        let mut turned = rig.clone();
        turned.other.insert(Meta::FACTORY_YAW_SD.into(), serde_json::Value::Null);
        turned.other.remove(Meta::CALIBRATED);
        self.extrinsics(&mut turned.r, &mut turned.t);
        turned
    }

    fn extrinsics(&self, r: &mut Rows, t: &mut [f64; 3]) {
        let [left, right] = self.rotations();
        if let Some(rotation) = left {
            *r = rows(&(matrix(r) * rotation.transpose()));
        }
        if let Some(rotation) = right {
            *r = rows(&(rotation * matrix(r)));
            *t = (rotation * Vector3::from(*t)).into();
        }
    }

    fn rotations(&self) -> [Option<Matrix3<f64>>; 2] {
        self.views.map(|view| view.map(|view| view.rotation(self.degrees)))
    }

    /// The turned matches of a pair, without those that leave an image or have no ray in their camera.
    pub fn pair(&self, pair: &[Match]) -> Vec<Match> {
        let [left, right] = self.rotations();
        let turned = |camera, rotation: &Option<Matrix3<f64>>, pixel| match rotation {
            Some(rotation) => turned_pixel(camera, rotation, pixel),
            None => Some(pixel),
        };
        let turned = |m: &Match| -> Option<Match> {
            let [ul, vl] = turned(&self.cameras.left, &left, [m.ul, m.vl])?;
            let [ur, vr] = turned(&self.cameras.right, &right, [m.ur, m.vr])?;
            Some(Match { ul, vl, ur, vr, ..*m })
        };
        pair.iter().filter_map(turned).collect()
    }
}

/// Pixel of the same point after the turn `r` of the camera; `None` if it leaves the image, or the pixel has no ray.
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
    use stereo_selfcal::batch::{RayPair, row_offset};
    use stereo_selfcal::geometry::RectifyingRotations;
    use stereo_selfcal::geometry::metrics::Deviation;

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
        for camera in TurnedCamera::VARIANTS {
            for view in TurnedView::VARIANTS {
                let turned = view.turn_camera(&set, 5.0, *camera).unwrap();
                assert!(turned.pairs[0].len() < set.pairs[0].len(), "{view:?}: none dropped");
                assert!(median_row_offset_px(&turned) < 0.3, "{camera:?} {view:?}");
                let wrong = Dataset { meta: set.meta.clone(), ..turned };
                assert!(median_row_offset_px(&wrong) > 1.0, "{camera:?} {view:?}");
            }
        }
    }

    #[test]
    fn the_baseline_moves_only_if_the_right_camera_turns_across_it() {
        let set = Dataset::load(&Dataset::shipped().join("motorcycle_sift")).unwrap();
        let moved = |view: TurnedView, camera| {
            let turned = view.turn_camera(&set, 5.0, camera).unwrap();
            let [before, after] = [&set, &turned].map(|set| set.truth::<f64>().unwrap());
            Deviation::between(&before, &after).translation.to_degrees()
        };
        for view in TurnedView::VARIANTS {
            assert!(moved(*view, TurnedCamera::Left) < 1e-9);
            let across = [TurnedView::Left, TurnedView::Right].contains(view);
            let expected = if across { 5.0 } else { 0.0 };
            assert!((moved(*view, TurnedCamera::Right) - expected).abs() < 1e-9, "{view:?}");
            let expected = 5.0 - expected;
            assert!((moved(*view, TurnedCamera::Both) - expected).abs() < 1e-9, "{view:?}");
        }
    }

    #[test]
    fn the_rig_of_each_pair_is_turned_like_the_rig_of_the_set() {
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
