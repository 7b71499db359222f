//! `Rig`: two cameras and their factory calibration.

use std::path::PathBuf;

use host_tests::data::{LensModel, Meta, WrongSign, in_f64, rows};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};
use selfcal_commands::conventions::Unknowns;
use serde_json::Value;
use stereo_selfcal::nalgebra::Vector3;
use stereo_selfcal::{Cameras, Extrinsics, FactoryCalibration, Lens, Scalar};

use crate::arguments::{Matrix, Vector, matrix, pose, vector};
use crate::calibration::Calibration;
use crate::camera::{Camera, converted};
use crate::errors::{of_file, raised, value};

/// A stereo rig before the calibrator learns from pairs.
#[pyclass(frozen, eq, from_py_object, module = "stereo_selfcal")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rig {
    #[pyo3(get)]
    pub(crate) left: Camera,
    #[pyo3(get)]
    pub(crate) right: Camera,
    /// `None`: not calibrated; the start is side by side, a guess.
    factory: Option<Extrinsics<f64>>,
    #[pyo3(get)]
    pub(crate) baseline_m: Option<f64>,
    /// Yaw deviation of the factory extrinsics; `None`: the default of the core; infinite: a guess.
    #[pyo3(get)]
    yaw_sd_rad: Option<f64>,
}

#[pymethods]
impl Rig {
    #[new]
    #[pyo3(signature = (left, right, factory=None, *, baseline_m=None, yaw_sd_rad=None))]
    fn new(
        left: Camera,
        right: Camera,
        factory: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
        baseline_m: Option<f64>,
        yaw_sd_rad: Option<f64>,
    ) -> PyResult<Self> {
        let factory = factory.map(|(r, t)| extrinsics(&r, &t)).transpose()?;
        let rig = Self { left, right, factory, baseline_m, yaw_sd_rad };
        rig.made()?;
        Ok(rig)
    }

    #[getter]
    fn factory(&self) -> Option<(Matrix<3, 3>, Vector)> {
        self.factory.as_ref().map(pose)
    }

    fn calibration(&self) -> PyResult<Calibration> {
        Ok(Calibration::factory(self, &self.made()?))
    }

    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.made()?.to_record()))
    }

    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, record: &[u8]) -> PyResult<Self> {
        let made = FactoryCalibration::<f32>::from_record(record).map_err(raised("record"))?;
        let Cameras { left, right } = made.cameras;
        Ok(Self {
            left: Camera(converted(&left)?),
            right: Camera(converted(&right)?),
            factory: Some(in_f64(&made.extrinsics)),
            baseline_m: made.baseline_m().map(f64::from),
            yaw_sd_rad: Some(made.yaw_sd_rad().map_or(f64::INFINITY, f64::from)),
        })
    }

    pub(crate) fn __repr__(&self) -> String {
        let factory = match &self.factory {
            Some(extrinsics) => extrinsics.to_string(),
            None => "no factory calibration: side by side".into(),
        };
        let baseline = self.baseline_m.map_or(String::new(), |m| format!(", baseline {m} m"));
        format!("<Rig {}, {}; {factory}{baseline}>", self.left.__repr__(), self.right.__repr__())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let named = PyDict::new(py);
        named.set_item("baseline_m", self.baseline_m)?;
        named.set_item("yaw_sd_rad", self.yaw_sd_rad)?;
        let make = py.import("functools")?.getattr("partial")?;
        let make = make.call((py.get_type::<Self>(),), Some(&named))?;
        let arguments = (self.left.clone(), self.right.clone(), self.factory());
        Ok((make, arguments).into_pyobject(py)?.into_any())
    }
}

impl Rig {
    /// The rig of a file of this project or of another tool.
    fn of_meta(meta: &Meta) -> anyhow::Result<Self> {
        let Cameras { left, right } = meta.cameras::<f64>()?;
        let factory = meta.has_reference().then(|| meta.extrinsics()).transpose()?;
        let yaw_sd_rad = meta.other.get(Meta::FACTORY_YAW_SD);
        let yaw_sd_rad =
            yaw_sd_rad.map(|degrees| degrees.as_f64().map_or(f64::INFINITY, f64::to_radians));
        let baseline_m = meta.baseline_m;
        Ok(Self { left: Camera(left), right: Camera(right), factory, baseline_m, yaw_sd_rad })
    }

    /// The rig in the form of the host tools.
    pub(crate) fn meta(&self) -> PyResult<Meta> {
        let [left, right] = [&self.left, &self.right].map(|camera| camera.0.intrinsics().size);
        let lens = |camera: &Camera| match camera.0.lens() {
            Lens::Fisheye(_) => LensModel::Fisheye,
            Lens::Rational(_) => LensModel::Rational,
            _ => LensModel::RadialTangential,
        };
        let start = self.start::<f64>()?;
        let yaw_sd = match (&self.factory, self.yaw_sd_rad) {
            (None, _) | (_, Some(f64::INFINITY)) => Some(Value::Null),
            (_, sd) => sd.map(|rad| rad.to_degrees().into()),
        };
        Ok(Meta {
            k_l: self.left.rows(),
            k_r: self.right.rows(),
            dist_l: self.left.coefficients(),
            dist_r: self.right.coefficients(),
            lens: lens(&self.left),
            lens_r: Some(lens(&self.right)).filter(|lens_r| *lens_r != lens(&self.left)),
            width: left[0],
            height: left[1],
            size_r: Some(right).filter(|right| *right != left),
            r: rows(start.rotation().matrix()),
            t: start.translation().into_inner().into(),
            baseline_m: self.baseline_m,
            source: "stereo_selfcal.Rig".into(),
            license: String::new(),
            sigma_r_deg: None,
            sigma_t_deg: None,
            other: yaw_sd.into_iter().map(|sd| (Meta::FACTORY_YAW_SD.into(), sd)).collect(),
        })
    }

    /// Both cameras in the number type of a vehicle.
    pub(crate) fn cameras(&self) -> PyResult<Cameras<f32>> {
        Ok(Cameras { left: converted(&self.left.0)?, right: converted(&self.right.0)? })
    }

    /// Start of every calibration.
    pub(crate) fn start<T: Scalar>(&self) -> PyResult<Extrinsics<T>> {
        let Some(factory) = &self.factory else { return Ok(Extrinsics::SIDE_BY_SIDE) };
        let r = factory.rotation().matrix().map(T::lit);
        let t = factory.translation().into_inner().map(T::lit);
        Extrinsics::try_new(&r, &t).map_err(raised("factory"))
    }

    /// The factory calibration in the number type of a vehicle.
    ///
    /// # Errors
    /// Names the argument of `Rig`.
    pub(crate) fn made(&self) -> PyResult<FactoryCalibration<f32>> {
        let made = FactoryCalibration::new(self.cameras()?, self.start()?);
        let made = match self.baseline_m {
            Some(m) => made.with_baseline_m(m as f32).map_err(raised("baseline_m"))?,
            None => made,
        };
        match (&self.factory, self.yaw_sd_rad) {
            (None, _) | (_, Some(f64::INFINITY)) => Ok(made.without_yaw()),
            (_, None) => Ok(made),
            (_, Some(sd)) => made.with_yaw_sd_rad(sd as f32).map_err(raised("yaw_sd_rad")),
        }
    }
}

/// Extrinsics of `factory=(R, t)`.
fn extrinsics(r: &Bound<'_, PyAny>, t: &Bound<'_, PyAny>) -> PyResult<Extrinsics<f64>> {
    let r = matrix("factory R", r)?;
    let t: [f64; 3] = vector("factory t", t)?.try_into().map_err(|t: Vec<f64>| {
        value(format!("factory t: 3 numbers are expected, not {}", t.len()))
    })?;
    WrongSign::check(&r, t).map_err(|why| value(format!("factory t: {why}")))?;
    Extrinsics::try_new(&host_tests::data::matrix(&r), &Vector3::from(t)).map_err(raised("factory"))
}

/// Reads the rig of a file or folder, or of several files.
#[pyfunction]
#[pyo3(signature = (*paths, size=None, unit_m=1.0))]
pub(crate) fn read_rig(
    paths: Vec<PathBuf>,
    size: Option<(u16, u16)>,
    unit_m: f64,
) -> PyResult<Rig> {
    let read = || -> anyhow::Result<Rig> {
        anyhow::ensure!(!paths.is_empty(), "no path");
        let sizes = size.map(|size| [size.into(); 2]);
        let meta = selfcal_commands::read_rig(&paths, Unknowns { sizes, unit_m, cameras: None })?;
        let own = meta.sizes();
        anyhow::ensure!(
            sizes.is_none_or(|sizes| sizes == own),
            "the rig belongs to images of {} x {} px, not of size={:?}",
            own[0][0],
            own[0][1],
            size.unwrap_or_default()
        );
        Rig::of_meta(&meta)
    };
    read().map_err(of_file)
}
