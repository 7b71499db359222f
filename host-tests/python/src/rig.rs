//! `Rig`: two cameras and their factory calibration.

use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::PathBuf;

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};
use rigs::data::{LensModel, Meta, WrongSign, in_f64};
use rigs::formats::Unknowns;
use serde_json::{Value, json};
use stereo_selfcal::nalgebra::Vector3;
use stereo_selfcal::{Calibration as CoreCalibration, Cameras, Extrinsics};
use stereo_selfcal::{FactoryCalibration, Scalar};

use crate::arguments::{Given, Matrix, Pose, Triple, matrix, pose, vector};
use crate::calibration::Calibration;
use crate::camera::Camera;
use crate::errors::{of_file, raised, value};

/// A stereo rig before the calibrator learns from pairs.
#[pyclass(frozen, eq, get_all, from_py_object, module = "stereo_selfcal")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rig {
    pub(crate) left: Camera,
    pub(crate) right: Camera,
    /// `None`: not calibrated; the start is side by side, a guess.
    factory: Option<Pose>,
    pub(crate) baseline_m: Option<f64>,
    /// Yaw deviation of the factory extrinsics, rad; `None`: the default of the core; infinite: a guess.
    yaw_sd_rad: Option<f64>,
}

#[pymethods]
impl Rig {
    #[new]
    #[pyo3(signature = (left, right, factory=None, *, baseline_m=None, yaw_sd_rad=None))]
    fn new(
        left: Camera,
        right: Camera,
        factory: Option<(Given<'_>, Given<'_>)>,
        baseline_m: Option<f64>,
        yaw_sd_rad: Option<f64>,
    ) -> PyResult<Self> {
        let factory = factory.map(|(r, t)| checked(&r, &t)).transpose()?;
        let rig = Self { left, right, factory, baseline_m, yaw_sd_rad };
        rig.made().map(|_| rig)
    }

    fn calibration(&self) -> PyResult<Calibration> {
        let FactoryCalibration { cameras, extrinsics, .. } = self.made()?;
        Calibration::of(self, &CoreCalibration { cameras, extrinsics, generation: 0 })
    }

    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.made()?.to_record()))
    }

    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, record: &[u8]) -> PyResult<Self> {
        let made = FactoryCalibration::<f32>::from_record(record).map_err(raised("record"))?;
        Ok(Self {
            left: Camera::of(&made.cameras.left),
            right: Camera::of(&made.cameras.right),
            factory: Some(pose(&in_f64(&made.extrinsics))),
            baseline_m: made.baseline_m().map(f64::from),
            yaw_sd_rad: Some(made.yaw_sd_rad().map_or(f64::INFINITY, f64::from)),
        })
    }

    pub(crate) fn __repr__(&self) -> PyResult<String> {
        let factory = match &self.factory {
            Some(_) => self.start::<f64>()?.to_string(),
            None => "no factory calibration: side by side".into(),
        };
        let baseline = self.baseline_m.map_or(String::new(), |m| format!(", baseline {m} m"));
        let (left, right) = (self.left.__repr__(), self.right.__repr__());
        Ok(format!("<Rig {left}, {right}; {factory}{baseline}>"))
    }

    fn __getnewargs_ex__(&self) -> (Arguments, BTreeMap<&str, Option<f64>>) {
        let named = [("baseline_m", self.baseline_m), ("yaw_sd_rad", self.yaw_sd_rad)];
        ((self.left.clone(), self.right.clone(), self.factory.clone()), named.into())
    }
}

/// Arguments of the constructor by their place.
type Arguments = (Camera, Camera, Option<Pose>);

impl Rig {
    /// The rig in the form of the host tools.
    pub(crate) fn meta(&self) -> PyResult<Meta> {
        let Self { left, right, baseline_m, .. } = self;
        let lens = |camera: &Camera| match camera.model {
            "fisheye" => LensModel::Fisheye,
            "rational" => LensModel::Rational,
            _ => LensModel::RadialTangential,
        };
        let (Matrix(r), Triple(t)) = pose(&self.start()?);
        let mut meta = json!({
            "K_l": left.K.0, "dist_l": left.dist.0, "width": left.size.0, "height": left.size.1, "lens": lens(left),
            "K_r": right.K.0, "dist_r": right.dist.0, "R": r, "t": t, "baseline_m": baseline_m,
        });
        if let Some(rad) = self.yaw_sd() {
            // JSON has no infinity: it becomes null, which means a guess.
            meta[Meta::FACTORY_YAW_SD] = rad.to_degrees().into();
        }
        let mut meta: Meta = serde_json::from_value(meta).map_err(value)?;
        meta.set_right(lens(right), right.size.into());
        Ok(meta)
    }

    /// Yaw deviation, rad; infinite for a guess, `None` for the default of the core.
    fn yaw_sd(&self) -> Option<f64> {
        if self.factory.is_some() { self.yaw_sd_rad } else { Some(f64::INFINITY) }
    }

    /// Start of every calibration: the factory calibration, or the cameras side by side.
    pub(crate) fn start<T: Scalar>(&self) -> PyResult<Extrinsics<T>> {
        let Some((Matrix(r), Triple(t))) = &self.factory else {
            return Ok(Extrinsics::SIDE_BY_SIDE);
        };
        let (r, t) = (rigs::data::matrix(r).map(T::lit), Vector3::from(t.map(T::lit)));
        Extrinsics::try_new(&r, &t).map_err(raised("factory"))
    }

    /// The factory calibration in the number type of a vehicle.
    ///
    /// # Errors
    /// Names the argument of `Rig`.
    pub(crate) fn made(&self) -> PyResult<FactoryCalibration<f32>> {
        let cameras = Cameras { left: self.left.core()?, right: self.right.core()? };
        let mut made = FactoryCalibration::new(cameras, self.start()?);
        if let Some(m) = self.baseline_m {
            made = made.with_baseline_m(m as f32).map_err(raised("baseline_m"))?;
        }
        match self.yaw_sd() {
            None => Ok(made),
            Some(f64::INFINITY) => Ok(made.without_yaw()),
            Some(sd) => made.with_yaw_sd_rad(sd as f32).map_err(raised("yaw_sd_rad")),
        }
    }
}

/// `R` and unit `t` of `factory=(R, t)`.
fn checked(r: &Given<'_>, t: &Given<'_>) -> PyResult<Pose> {
    let r = matrix("factory R", r)?;
    let wrong = |t: Vec<f64>| value(format!("factory t: 3 numbers are expected, not {}", t.len()));
    let t = vector("factory t", t)?.try_into().map_err(wrong)?;
    WrongSign::check(&r, t).map_err(|why| value(format!("factory t: {why}")))?;
    let found = Extrinsics::try_new(&rigs::data::matrix(&r), &Vector3::from(t));
    found.map(|found| pose(&found)).map_err(raised("factory"))
}

/// Reads the rig of a file or folder, or of several files.
#[pyfunction]
#[pyo3(signature = (*paths, size=None, unit_m=1.0, cameras=None))]
pub(crate) fn read_rig(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    size: Option<(u16, u16)>,
    unit_m: f64,
    cameras: Option<(u8, u8)>,
) -> PyResult<Rig> {
    let read = || -> anyhow::Result<(Rig, Vec<String>)> {
        anyhow::ensure!(!paths.is_empty(), "no path");
        let sizes = size.map(|size| [size.into(); 2]);
        let cameras = cameras.map(<[u8; 2]>::from);
        let meta = rigs::read_rig(&paths, Unknowns { sizes, unit_m, cameras })?;
        let [[width, height], _] = meta.sizes();
        anyhow::ensure!(
            sizes.is_none_or(|sizes| sizes == meta.sizes()),
            "the rig belongs to images of {width} x {height} px, not of size={:?}",
            size.unwrap_or_default()
        );
        let Cameras { left, right } = meta.cameras::<f64>()?;
        let factory = meta.has_reference().then(|| meta.extrinsics()).transpose()?;
        let yaw_sd = meta.other.get(Meta::FACTORY_YAW_SD).map(Value::as_f64);
        let rig = Rig {
            left: Camera::of(&left),
            right: Camera::of(&right),
            factory: factory.as_ref().map(pose),
            baseline_m: meta.baseline_m,
            yaw_sd_rad: yaw_sd.map(|deg| deg.map_or(f64::INFINITY, f64::to_radians)),
        };
        Ok((rig, rigs::doubts(&meta)))
    };
    let (rig, doubts) = read().map_err(of_file)?;
    for doubt in doubts {
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(doubt)?, 1)?;
    }
    Ok(rig)
}
