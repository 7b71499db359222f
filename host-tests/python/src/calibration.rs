//! `Calibration`: extrinsics with their cameras, and rectification with them.

#![allow(non_snake_case, reason = "the field's symbol")]

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use rigs::data::{in_f64, rows};
use stereo_selfcal::batch::row_offset;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::nalgebra::{Rotation3, Vector2, Vector3};
use stereo_selfcal::{Calibration as CoreCalibration, Camera as CoreCamera, Cameras};
use stereo_selfcal::{Correspondence, Extrinsics};

use crate::arguments::{Given, Matrix, Pose, Triple, Vector, points, pose, same_length};
use crate::camera::Camera;
use crate::errors::{raised, value};
use crate::outcome::data;
use crate::pool::install;
use crate::rig::Rig;

/// Coordinate of a rectified pixel that no camera sees: outside every image.
const OUTSIDE: f32 = -1e4;

/// Largest relative difference of the aspect ratios of rectified and captured images.
const SHAPE: f32 = 0.01;

/// `R1, R2, P1, P2, Q`.
type Rectified = (Matrix<3, 3>, Matrix<3, 3>, Matrix<3, 4>, Matrix<3, 4>, Matrix<4, 4>);
type Map<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>);

/// Width and height of an image, px; `None`: the size of the left image.
type Size = Option<(u16, u16)>;

/// A common camera for both rectified views, and the rotations to it.
struct Rectification {
    cameras: Cameras<f32>,
    rotations: RectifyingRotations<f32>,
    camera: RectifiedCamera<f32>,
    size: [u16; 2],
}

data! {
    /// Extrinsics, and the cameras that they belong to.
    #[pyclass(frozen, get_all, module = "stereo_selfcal")]
    #[derive(PartialEq)]
    Calibration(rig: &Rig, of: &CoreCalibration<f32>, (R, t): Pose) {
        R: Matrix<3, 3> = R,
        t: Triple = t,
        baseline_m: Option<f64> = rig.baseline_m,
        left: Camera = camera(&of.cameras.left, &rig.left)?,
        right: Camera = camera(&of.cameras.right, &rig.right)?,
    } {
        #[pyo3(signature = (alpha=0.0, size=None))]
        fn homographies(&self, alpha: f64, size: Size) -> PyResult<(Matrix<3, 3>, Matrix<3, 3>)> {
            let Rectification { cameras, rotations, camera, .. } = self.rectified(alpha, size)?;
            let both = camera.homographies(&cameras, &rotations);
            Ok(both.map(|h| Matrix(rows(&h.map(f64::from)))).into())
        }

        #[pyo3(signature = (size=None, alpha=0.0))]
        fn rectify_maps<'py>(
            &self, py: Python<'py>, size: Size, alpha: f64,
        ) -> PyResult<(Map<'py>, Map<'py>)> {
            let rectified = self.rectified(alpha, size)?;
            let Rectification { cameras: Cameras { left, right }, rotations, .. } = &rectified;
            let maps = install(py, || {
                [(left, rotations.left()), (right, rotations.right())].map(|of| rectified.map(of))
            })?;
            let [width, height] = rectified.size.map(usize::from);
            let array = |numbers| PyArray1::from_vec(py, numbers).reshape([height, width]);
            let [left, right] = maps.map(|[x, y]| Ok::<_, PyErr>((array(x)?, array(y)?)));
            Ok((left?, right?))
        }

        #[pyo3(signature = (alpha=0.0, size=None))]
        fn stereo_rectify(&self, alpha: f64, size: Size) -> PyResult<Rectified> {
            let Rectification { rotations, camera, .. } = self.rectified(alpha, size)?;
            let (f, [cx, cy]) = (f64::from(camera.focal), camera.principal.map(f64::from));
            let baseline = self.baseline_m.unwrap_or(1.0);
            let p = |shift| [[f, 0.0, cx, shift], [0.0, f, cy, 0.0], [0.0, 0.0, 1.0, 0.0]];
            let [x, y] = [[1.0, 0.0, 0.0, -cx], [0.0, 1.0, 0.0, -cy]];
            let q = [x, y, [0.0, 0.0, 0.0, f], [0.0, 0.0, 1.0 / baseline, 0.0]];
            let rotation = |r: &Rotation3<f32>| Matrix(rows(&r.matrix().map(f64::from)));
            let [r1, r2] = [rotations.left(), rotations.right()].map(rotation);
            Ok((r1, r2, Matrix(p(0.0)), Matrix(p(-f * baseline)), Matrix(q)))
        }

        fn row_offsets(&self, uv_left: &Given<'_>, uv_right: &Given<'_>) -> PyResult<Vector> {
            let (left, right) = (points("uv_left", uv_left)?, points("uv_right", uv_right)?);
            same_length("uv_right", right.len(), left.len())?;
            let CoreCalibration { cameras, extrinsics, .. } = self.core()?;
            let rotations = RectifyingRotations::from(&extrinsics);
            let offset = |(left, right): ([f64; 2], [f64; 2])| {
                let [left, right] = [left, right].map(|pixel| pixel.map(|x| x as f32));
                let pair = Correspondence { left, right, score: 1.0, grid_step: 0.0 };
                Some(row_offset(&rotations, &cameras.rays(&pair).ok()?)? * cameras.mean_focal())
            };
            let offsets = left.into_iter().zip(right).map(offset);
            Ok(Vector(offsets.map(|px| px.map_or(f64::NAN, f64::from)).collect()))
        }

        fn __eq__(&self, other: &Self) -> bool {
            self == other
        }

        fn __repr__(&self) -> PyResult<String> {
            Ok(format!("<Calibration {}>", self.core()?))
        }
    }
}

impl Calibration {
    pub(crate) fn of(rig: &Rig, of: &CoreCalibration<f32>) -> PyResult<Self> {
        Self::new(rig, of, pose(&in_f64(&of.extrinsics)))
    }

    fn core(&self) -> PyResult<CoreCalibration<f32>> {
        let cameras = Cameras { left: self.left.core()?, right: self.right.core()? };
        let r = std::array::from_fn(|i| self.R.0.as_flattened()[i] as f32);
        let extrinsics = Extrinsics::from_row_major(r, self.t.0.map(|x| x as f32));
        Ok(CoreCalibration {
            cameras,
            extrinsics: extrinsics.map_err(raised("R, t"))?,
            generation: 0,
        })
    }

    /// The rotations to both rectified views, and their common camera.
    ///
    /// * `alpha`: zoom, as in [`RectifiedCamera::try_choose`].
    /// * `size`: width and height of the rectified images, px, with the aspect ratio of the left image to within 1 %;
    ///   by default the size of the left image.
    fn rectified(&self, alpha: f64, size: Size) -> PyResult<Rectification> {
        let CoreCalibration { cameras, extrinsics, .. } = self.core()?;
        let rotations = RectifyingRotations::from(&extrinsics);
        let chosen = RectifiedCamera::try_choose(&cameras, &rotations, alpha as f32);
        let mut camera = chosen.map_err(raised("alpha"))?;
        let own = cameras.left.intrinsics().size;
        let size = size.map_or(own, Into::into);
        let [x, y] = std::array::from_fn(|i| f32::from(size[i]) / f32::from(own[i]));
        let is_shape = (x / y - 1.0).abs() <= SHAPE;
        if !is_shape {
            let not = format!("{size:?} px is not of the shape of the left image, {own:?} px");
            return Err(value(format!("size: {not}")));
        }
        if size != own {
            // The centre of the first pixel is at 0, so the border is half a pixel away.
            camera.focal *= x;
            camera.principal = camera.principal.map(|c| (c + 0.5) * x - 0.5);
        }
        Ok(Rectification { cameras, rotations, camera, size })
    }
}

/// The camera as given, unless the core has corrected it.
fn camera(used: &CoreCamera<f32>, given: &Camera) -> PyResult<Camera> {
    Ok(if given.core::<f32>()? == *used { given.clone() } else { Camera::of(used) })
}

impl Rectification {
    /// Columns and rows of the captured image, for each rectified pixel row by row.
    fn map(&self, (camera, rotation): (&CoreCamera<f32>, &Rotation3<f32>)) -> [Vec<f32>; 2] {
        let [width, height] = self.size;
        let (f, [cx, cy]) = (self.camera.focal, self.camera.principal);
        let back = rotation.inverse();
        let seen = |(u, v): (u16, u16)| -> Option<[f32; 2]> {
            let rectified = Vector3::new((f32::from(u) - cx) / f, (f32::from(v) - cy) / f, 1.0);
            let ray = back * rectified;
            let in_front = ray.z > 0.0;
            in_front.then(|| camera.pixel(Vector2::new(ray.x, ray.y) / ray.z).ok()).flatten()
        };
        let pixels = (0..height).into_par_iter().flat_map_iter(|v| (0..width).map(move |u| (u, v)));
        let (x, y) = pixels.map(|pixel| seen(pixel).unwrap_or([OUTSIDE; 2]).into()).unzip();
        [x, y]
    }
}
