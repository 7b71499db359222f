//! `Calibration`: extrinsics with their cameras, and rectification with them.

use host_tests::data::{in_f64, rows};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use stereo_selfcal::batch::row_offset;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::nalgebra::{Rotation3, Vector2, Vector3};
use stereo_selfcal::{
    Calibration as CoreCalibration, Camera as CoreCamera, Correspondence, FactoryCalibration,
};

use crate::arguments::{Matrix, Vector, points, pose, same_length};
use crate::camera::{Camera, converted};
use crate::errors::{raised, value};
use crate::pool::install;
use crate::rig::Rig;

/// Coordinate of a rectified pixel that no camera sees: outside every image.
const OUTSIDE: f32 = -1e4;

/// Largest relative difference of the shapes of rectified and captured images.
const SHAPE: f32 = 0.01;

/// Extrinsics, and the cameras that they belong to.
#[pyclass(frozen, eq, module = "stereo_selfcal")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Calibration {
    rig: Rig,
    of: CoreCalibration<f32>,
}

/// `R1, R2, P1, P2, Q`.
type Rectified = (Matrix<3, 3>, Matrix<3, 3>, Matrix<3, 4>, Matrix<3, 4>, Matrix<4, 4>);
type Map<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>);

/// A common camera for both rectified views, and the rotations to it.
struct Rectification {
    rotations: RectifyingRotations<f32>,
    camera: RectifiedCamera<f32>,
    size: [u16; 2],
}

#[pymethods]
impl Calibration {
    #[getter(R)]
    fn r(&self) -> Matrix<3, 3> {
        pose(&in_f64(&self.of.extrinsics)).0
    }

    #[getter]
    fn t(&self) -> Vector {
        pose(&in_f64(&self.of.extrinsics)).1
    }

    #[getter]
    fn baseline_m(&self) -> Option<f64> {
        self.rig.baseline_m
    }

    #[getter]
    fn left(&self) -> PyResult<Camera> {
        camera(&self.of.cameras.left, &self.rig.left)
    }

    #[getter]
    fn right(&self) -> PyResult<Camera> {
        camera(&self.of.cameras.right, &self.rig.right)
    }

    #[pyo3(signature = (alpha=0.0, size=None))]
    fn homographies(
        &self,
        alpha: f64,
        size: Option<(u16, u16)>,
    ) -> PyResult<(Matrix<3, 3>, Matrix<3, 3>)> {
        let rectified = self.rectified(alpha, size)?;
        let both = rectified.camera.homographies(&self.of.cameras, &rectified.rotations);
        Ok(both.map(|h| Matrix(rows(&h.map(f64::from)))).into())
    }

    #[pyo3(signature = (size=None, alpha=0.0))]
    fn rectify_maps<'py>(
        &self,
        py: Python<'py>,
        size: Option<(u16, u16)>,
        alpha: f64,
    ) -> PyResult<(Map<'py>, Map<'py>)> {
        let rectified = self.rectified(alpha, size)?;
        let (left, right) = (&self.of.cameras.left, &self.of.cameras.right);
        let maps = install(py, || {
            [(left, rectified.rotations.left()), (right, rectified.rotations.right())]
                .map(|(camera, rotation)| rectified.map(camera, rotation))
        })?;
        let [width, height] = rectified.size.map(usize::from);
        let array = |numbers| PyArray1::from_vec(py, numbers).reshape([height, width]);
        let [left, right] = maps.map(|[x, y]| Ok::<_, PyErr>((array(x)?, array(y)?)));
        Ok((left?, right?))
    }

    #[pyo3(signature = (alpha=0.0, size=None))]
    fn stereo_rectify(&self, alpha: f64, size: Option<(u16, u16)>) -> PyResult<Rectified> {
        let Rectification { rotations, camera, .. } = self.rectified(alpha, size)?;
        let (f, [cx, cy]) = (f64::from(camera.focal), camera.principal.map(f64::from));
        let baseline = self.rig.baseline_m.unwrap_or(1.0);
        let p = |shift| [[f, 0.0, cx, shift], [0.0, f, cy, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let q = [
            [1.0, 0.0, 0.0, -cx],
            [0.0, 1.0, 0.0, -cy],
            [0.0, 0.0, 0.0, f],
            [0.0, 0.0, 1.0 / baseline, 0.0],
        ];
        let rotation = |r: &Rotation3<f32>| Matrix(rows(&r.matrix().map(f64::from)));
        let [r1, r2] = [rotations.left(), rotations.right()].map(rotation);
        Ok((r1, r2, Matrix(p(0.0)), Matrix(p(-f * baseline)), Matrix(q)))
    }

    fn row_offsets(
        &self,
        uv_left: &Bound<'_, PyAny>,
        uv_right: &Bound<'_, PyAny>,
    ) -> PyResult<Vector> {
        let left = points("uv_left", uv_left)?;
        let right = points("uv_right", uv_right)?;
        same_length("uv_right", right.len(), left.len())?;
        let rotations = RectifyingRotations::from(&self.of.extrinsics);
        let focal = self.of.cameras.mean_focal();
        let offset = |(left, right): ([f64; 2], [f64; 2])| {
            let [left, right] = [left, right].map(|pixel| pixel.map(|x| x as f32));
            let pair = Correspondence { left, right, score: 1.0, grid_step: 0.0 };
            let rays = self.of.cameras.rays(&pair).ok()?;
            Some(f64::from(row_offset(&rotations, &rays)? * focal))
        };
        let all = left.into_iter().zip(right);
        Ok(Vector(all.map(|pair| offset(pair).unwrap_or(f64::NAN)).collect()))
    }

    fn __repr__(&self) -> String {
        format!("<Calibration {}>", self.of)
    }

    #[staticmethod]
    fn _of(rig: Rig, record: &[u8]) -> PyResult<Self> {
        let read = FactoryCalibration::from_record(record).map_err(raised("record"))?;
        Ok(Self::factory(&rig, &read))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State<'py>)> {
        let CoreCalibration { cameras, extrinsics, .. } = self.of;
        let record = FactoryCalibration::new(cameras, extrinsics).to_record();
        let record = PyBytes::new(py, &record);
        Ok((py.get_type::<Self>().getattr("_of")?, (self.rig.clone(), record)))
    }
}

/// State of a pickle.
type State<'py> = (Rig, Bound<'py, PyBytes>);

impl Calibration {
    /// The generation belongs to the calibrator, so calibrations are equal for any time of their application.
    pub(crate) fn new(rig: &Rig, of: CoreCalibration<f32>) -> Self {
        Self { rig: rig.clone(), of: CoreCalibration { generation: 0, ..of } }
    }

    pub(crate) fn factory(rig: &Rig, made: &FactoryCalibration<f32>) -> Self {
        let FactoryCalibration { cameras, extrinsics, .. } = *made;
        Self::new(rig, CoreCalibration { cameras, extrinsics, generation: 0 })
    }

    /// The common camera of both rectified views.
    ///
    /// * `size`: size of the rectified images, px, with the shape of the left image; by default the size of the left
    ///   image.
    fn rectified(&self, alpha: f64, size: Option<(u16, u16)>) -> PyResult<Rectification> {
        let rotations = RectifyingRotations::from(&self.of.extrinsics);
        let chosen = RectifiedCamera::try_choose(&self.of.cameras, &rotations, alpha as f32);
        let mut camera = chosen.map_err(raised("alpha"))?;
        let own = self.of.cameras.left.intrinsics().size;
        let size = size.map_or(own, Into::into);
        if size != own {
            let [x, y] = std::array::from_fn(|i| f32::from(size[i]) / f32::from(own[i]));
            let is_shape = (x / y - 1.0).abs() <= SHAPE;
            if !is_shape {
                return Err(value(format!(
                    "size: {size:?} px is not of the shape of the left image, {own:?} px"
                )));
            }
            // The centre of the first pixel is at 0, so the border is half a pixel away.
            camera.focal *= x;
            camera.principal = camera.principal.map(|c| (c + 0.5) * x - 0.5);
        }
        Ok(Rectification { rotations, camera, size })
    }
}

/// The camera as given, unless the core has corrected it.
fn camera(used: &CoreCamera<f32>, given: &Camera) -> PyResult<Camera> {
    let is_given = converted::<_, f32>(&given.0)? == *used;
    if is_given { Ok(given.clone()) } else { Ok(Camera(converted(used)?)) }
}

impl Rectification {
    /// Columns and rows of the captured image, for each rectified pixel row by row.
    fn map(&self, camera: &CoreCamera<f32>, rotation: &Rotation3<f32>) -> [Vec<f32>; 2] {
        let [width, height] = self.size;
        let (f, [cx, cy]) = (self.camera.focal, self.camera.principal);
        let back = rotation.inverse();
        let seen = |u: u16, v: u16| -> Option<[f32; 2]> {
            let rectified = Vector3::new((f32::from(u) - cx) / f, (f32::from(v) - cy) / f, 1.0);
            let ray = back * rectified;
            let in_front = ray.z > 0.0;
            in_front.then(|| camera.pixel(Vector2::new(ray.x, ray.y) / ray.z).ok()).flatten()
        };
        let pixels = (0..height).into_par_iter().flat_map_iter(|v| (0..width).map(move |u| (u, v)));
        let (x, y) = pixels.map(|(u, v)| seen(u, v).unwrap_or([OUTSIDE; 2]).into()).unzip();
        [x, y]
    }
}
