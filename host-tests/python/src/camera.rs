//! `Camera`: intrinsics and lens in OpenCV's conventions.

#![allow(non_snake_case, reason = "the field's symbol")]

use pyo3::prelude::*;
use pyo3::types::PyType;
use stereo_selfcal::geometry::{CameraError, Fisheye, RadialTangential, Rational};
use stereo_selfcal::{Camera as CoreCamera, Intrinsics, Lens, Scalar};

use crate::arguments::{Given, Matrix, Points, Vector, matrix, points, vector};
use crate::errors::{raised, value};

/// A calibrated camera.
#[pyclass(frozen, eq, get_all, from_py_object, module = "stereo_selfcal")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Camera {
    pub(crate) K: Matrix<3, 3>,
    /// Coefficients in OpenCV's order.
    pub(crate) dist: Vector,
    pub(crate) size: (u16, u16),
    pub(crate) model: &'static str,
}

#[pymethods]
impl Camera {
    #[classmethod]
    #[pyo3(signature = (K, dist=None, size=None))]
    fn from_opencv(
        _class: &Bound<'_, PyType>,
        K: &Given<'_>,
        dist: Option<&Given<'_>>,
        size: Option<[i64; 2]>,
    ) -> PyResult<Self> {
        let mut k = dist.map_or(Ok(Vec::new()), |dist| vector("dist", dist))?;
        let given = k.len();
        if !matches!(given, 0 | 4 | 5 | 8 | 12 | 14) {
            return Err(value(format!("dist: 4, 5, 8, 12 or 14 coefficients, not {given}")));
        }
        let (model, count) = match k.iter().rposition(|k| *k != 0.0) {
            None => ("pinhole", 5),
            Some(..5) => ("radial_tangential", 5),
            Some(..8) => ("rational", 8),
            Some(_) => {
                let not = "thin prisms and tilted sensors are not supported";
                return Err(value(format!("dist: {given} coefficients: {not}")));
            }
        };
        k.resize(count, 0.0);
        Self::checked(K, model, k, size)
    }

    #[classmethod]
    fn from_fisheye(
        _class: &Bound<'_, PyType>,
        K: &Given<'_>,
        dist: &Given<'_>,
        size: [i64; 2],
    ) -> PyResult<Self> {
        let k = vector("dist", dist)?;
        if k.len() != 4 {
            return Err(value(format!("dist: a fisheye has 4 coefficients, not {}", k.len())));
        }
        Self::checked(K, "fisheye", k, Some(size))
    }

    fn rays(&self, uv: &Given<'_>) -> PyResult<Points> {
        let camera = self.core::<f64>()?;
        let ray = |pixel| camera.ray(pixel).map_or([f64::NAN; 2], Into::into);
        Ok(Points(points("uv", uv)?.into_iter().map(ray).collect()))
    }

    fn pixels(&self, rays: &Given<'_>) -> PyResult<Points> {
        let camera = self.core::<f64>()?;
        let pixel = |ray: [f64; 2]| camera.pixel(ray.into()).unwrap_or([f64::NAN; 2]);
        Ok(Points(points("rays", rays)?.into_iter().map(pixel).collect()))
    }

    pub(crate) fn __repr__(&self) -> String {
        let Self { K: Matrix([[fx, _, cx], [_, fy, cy], _]), size: (width, height), .. } = self;
        let model = self.model.replace('_', "-");
        format!(
            "<Camera {width} x {height} px, {model}, focal length {fx:.2} {fy:.2} px, principal point {cx:.2} {cy:.2} px>"
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Given<'py>, Arguments)> {
        let make = if self.model == "fisheye" { "from_fisheye" } else { "from_opencv" };
        let arguments = (self.K.clone(), self.dist.clone(), self.size);
        Ok((py.get_type::<Self>().getattr(make)?, arguments))
    }
}

/// Arguments of the constructors.
type Arguments = (Matrix<3, 3>, Vector, (u16, u16));

impl Camera {
    fn checked(
        k: &Given<'_>,
        model: &'static str,
        dist: Vec<f64>,
        size: Option<[i64; 2]>,
    ) -> PyResult<Self> {
        let k = matrix("K", k)?;
        let [[_, skew, _], [zero, _, _], bottom] = k;
        if (skew, zero, bottom) != (0.0, 0.0, [0.0, 0.0, 1.0]) {
            return Err(value("K: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] is expected: no skew"));
        }
        let size = size.ok_or_else(|| value("size: (width, height), px, is needed"))?;
        let [Ok(width), Ok(height)] = size.map(u16::try_from) else {
            return Err(value(format!("size: {size:?}: a side has 0 to 65535 px")));
        };
        let camera = Self { K: Matrix(k), dist: Vector(dist), size: (width, height), model };
        camera.core::<f64>().map(|_| camera)
    }

    /// Converts a camera of the core.
    pub(crate) fn of<T: Scalar>(camera: &CoreCamera<T>) -> Self {
        fn all<T: Scalar>(k: &[T]) -> Vec<f64> {
            k.iter().map(|k| k.to_f64()).collect()
        }
        let (model, dist) = match camera.lens() {
            Lens::Pinhole => ("pinhole", vec![0.0; 5]),
            Lens::RadialTangential(lens) => ("radial_tangential", all(&lens.coefficients())),
            Lens::Fisheye(lens) => ("fisheye", all(&lens.coefficients())),
            Lens::Rational(lens) => ("rational", all(&lens.coefficients())),
        };
        let Intrinsics { focal, principal, size } = *camera.intrinsics();
        let ([fx, fy], [cx, cy]) = (focal.map(T::to_f64), principal.map(T::to_f64));
        let k = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]];
        Self { K: Matrix(k), dist: Vector(dist), size: size.into(), model }
    }

    /// Converts this camera to a camera of the core.
    ///
    /// # Errors
    /// If a quantity is out of range once it is rounded to `T`.
    pub(crate) fn core<T: Scalar>(&self) -> PyResult<CoreCamera<T>> {
        fn first<T: Scalar, const N: usize>(k: &[f64]) -> [T; N] {
            std::array::from_fn(|i| T::lit(k.get(i).copied().unwrap_or_default()))
        }
        let k = &self.dist.0[..];
        let lens = match self.model {
            "pinhole" => Ok(Lens::Pinhole),
            "fisheye" => Fisheye::try_new(first(k)).map(Lens::Fisheye),
            "rational" => Rational::try_new(first(k)).map(Lens::Rational),
            _ => RadialTangential::try_new(first(k)).map(Lens::RadialTangential),
        };
        let Matrix([[fx, _, cx], [_, fy, cy], _]) = self.K;
        let (focal, principal) = ([fx, fy].map(T::lit), [cx, cy].map(T::lit));
        let intrinsics = Intrinsics { focal, principal, size: self.size.into() };
        let made = lens.and_then(|lens| CoreCamera::try_new(intrinsics, lens));
        made.map_err(|why| {
            raised(if why == CameraError::Distortion { "dist" } else { "K or size" })(why)
        })
    }
}
