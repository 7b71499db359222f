//! `Camera`: intrinsics and lens in OpenCV's conventions.

use pyo3::prelude::*;
use pyo3::types::PyType;
use stereo_selfcal::geometry::{Fisheye, RadialTangential, Rational};
use stereo_selfcal::{Camera as CoreCamera, Intrinsics, Lens, Scalar};

use crate::arguments::{Matrix, Points, Vector, matrix, points, vector};
use crate::errors::{raised, value};

/// A calibrated camera.
#[pyclass(frozen, eq, from_py_object, module = "stereo_selfcal")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Camera(pub(crate) CoreCamera<f64>);

#[pymethods]
impl Camera {
    #[classmethod]
    #[pyo3(signature = (K, dist=None, size=None))]
    #[expect(non_snake_case, reason = "the field's symbol")]
    fn from_opencv(
        _class: &Bound<'_, PyType>,
        K: &Bound<'_, PyAny>,
        dist: Option<&Bound<'_, PyAny>>,
        size: Option<(u32, u32)>,
    ) -> PyResult<Self> {
        let mut k = dist.map_or(Ok(Vec::new()), |dist| vector("dist", dist))?;
        if k.len() > 8 && k[8..].iter().any(|k| *k != 0.0) {
            return Err(value(format!(
                "dist: {} coefficients: thin prisms and tilted sensors are not supported",
                k.len()
            )));
        }
        k.truncate(8);
        let lens = match *k {
            _ if k.iter().all(|k| *k == 0.0) => Lens::Pinhole,
            [k1, k2, p1, p2] => radial([k1, k2, p1, p2, 0.0])?,
            [k1, k2, p1, p2, k3] | [k1, k2, p1, p2, k3, 0.0, 0.0, 0.0] => {
                radial([k1, k2, p1, p2, k3])?
            }
            [k1, k2, p1, p2, k3, k4, k5, k6] => {
                let k = [k1, k2, p1, p2, k3, k4, k5, k6];
                Lens::Rational(Rational::try_new(k).map_err(raised("dist"))?)
            }
            _ => {
                return Err(value(format!(
                    "dist: 4, 5, 8, 12 or 14 coefficients, not {}",
                    k.len()
                )));
            }
        };
        Self::of(matrix("K", K)?, lens, size)
    }

    #[classmethod]
    #[pyo3(signature = (K, dist, size))]
    #[expect(non_snake_case, reason = "the field's symbol")]
    fn from_fisheye(
        _class: &Bound<'_, PyType>,
        K: &Bound<'_, PyAny>,
        dist: &Bound<'_, PyAny>,
        size: Option<(u32, u32)>,
    ) -> PyResult<Self> {
        let k = vector("dist", dist)?;
        let four: [f64; 4] = k.try_into().map_err(|k: Vec<f64>| {
            value(format!("dist: a fisheye has 4 coefficients, not {}", k.len()))
        })?;
        let lens = Lens::Fisheye(Fisheye::try_new(four).map_err(raised("dist"))?);
        Self::of(matrix("K", K)?, lens, size)
    }

    #[getter(K)]
    fn k(&self) -> Matrix<3, 3> {
        Matrix(self.rows())
    }

    #[getter]
    fn dist(&self) -> Vector {
        Vector(self.coefficients())
    }

    #[getter]
    fn size(&self) -> (u16, u16) {
        self.0.intrinsics().size.into()
    }

    #[getter]
    pub(crate) fn model(&self) -> &'static str {
        match self.0.lens() {
            Lens::Pinhole => "pinhole",
            Lens::RadialTangential(_) => "radial_tangential",
            Lens::Fisheye(_) => "fisheye",
            Lens::Rational(_) => "rational",
        }
    }

    fn rays(&self, uv: &Bound<'_, PyAny>) -> PyResult<Points> {
        let ray = |pixel| self.0.ray(pixel).map_or([f64::NAN; 2], Into::into);
        Ok(Points(points("uv", uv)?.into_iter().map(ray).collect()))
    }

    fn pixels(&self, rays: &Bound<'_, PyAny>) -> PyResult<Points> {
        let pixel = |ray: [f64; 2]| self.0.pixel(ray.into()).unwrap_or([f64::NAN; 2]);
        Ok(Points(points("rays", rays)?.into_iter().map(pixel).collect()))
    }

    pub(crate) fn __repr__(&self) -> String {
        let Intrinsics { focal: [fx, fy], principal: [cx, cy], size: [width, height] } =
            self.0.intrinsics();
        format!(
            "<Camera {width} x {height} px, {}, focal length {fx:.2} {fy:.2} px, principal point {cx:.2} {cy:.2} px>",
            self.model().replace('_', "-")
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Arguments)> {
        let class = py.get_type::<Self>();
        let is_fisheye = matches!(self.0.lens(), Lens::Fisheye(_));
        let make = class.getattr(if is_fisheye { "from_fisheye" } else { "from_opencv" })?;
        Ok((make, (self.k(), self.dist(), self.size())))
    }
}

/// Arguments of the constructors.
type Arguments = (Matrix<3, 3>, Vector, (u16, u16));

impl Camera {
    fn of(k: [[f64; 3]; 3], lens: Lens<f64>, size: Option<(u32, u32)>) -> PyResult<Self> {
        let [[fx, skew, cx], [zero, fy, cy], bottom] = k;
        if (skew, zero, bottom) != (0.0, 0.0, [0.0, 0.0, 1.0]) {
            return Err(value("K: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] is expected: no skew"));
        }
        let (width, height) = size.ok_or_else(|| value("size: (width, height), px, is needed"))?;
        let side = |n: u32| {
            u16::try_from(n)
                .map_err(|_| value(format!("size: ({width}, {height}): a side has up to 65535 px")))
        };
        let size = [side(width)?, side(height)?];
        let intrinsics = Intrinsics { focal: [fx, fy], principal: [cx, cy], size };
        Ok(Self(CoreCamera::try_new(intrinsics, lens).map_err(raised("K or size"))?))
    }

    /// `K`, row by row.
    pub(crate) fn rows(&self) -> [[f64; 3]; 3] {
        let Intrinsics { focal: [fx, fy], principal: [cx, cy], .. } = *self.0.intrinsics();
        [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    }

    /// Coefficients in OpenCV's order.
    pub(crate) fn coefficients(&self) -> Vec<f64> {
        match self.0.lens() {
            Lens::Pinhole => vec![0.0; 5],
            Lens::RadialTangential(lens) => lens.coefficients().into(),
            Lens::Fisheye(lens) => lens.coefficients().into(),
            Lens::Rational(lens) => lens.coefficients().into(),
        }
    }
}

/// A camera in another number type.
///
/// # Errors
/// If a quantity is out of range once it is rounded.
pub(crate) fn converted<A: Scalar, B: Scalar>(camera: &CoreCamera<A>) -> PyResult<CoreCamera<B>> {
    fn all<A: Scalar, B: Scalar, const N: usize>(numbers: [A; N]) -> [B; N] {
        numbers.map(|x| B::lit(x.to_f64()))
    }
    let Intrinsics { focal, principal, size } = *camera.intrinsics();
    let intrinsics = Intrinsics { focal: all(focal), principal: all(principal), size };
    let lens = match camera.lens() {
        Lens::Pinhole => Ok(Lens::Pinhole),
        Lens::RadialTangential(lens) => {
            RadialTangential::try_new(all(lens.coefficients())).map(Lens::RadialTangential)
        }
        Lens::Fisheye(lens) => Fisheye::try_new(all(lens.coefficients())).map(Lens::Fisheye),
        Lens::Rational(lens) => Rational::try_new(all(lens.coefficients())).map(Lens::Rational),
    };
    CoreCamera::try_new(intrinsics, lens.map_err(raised("dist"))?).map_err(raised("K"))
}

fn radial(k: [f64; 5]) -> PyResult<Lens<f64>> {
    Ok(Lens::RadialTangential(RadialTangential::try_new(k).map_err(raised("dist"))?))
}
