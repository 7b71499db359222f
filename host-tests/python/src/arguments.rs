//! Arrays of numpy as checked numbers. Every error names the argument, its shape and the value.

use std::convert::Infallible;

use host_tests::data::rows;
use numpy::ndarray::aview2;
use numpy::{
    Element, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
    ToPyArray,
};
use pyo3::prelude::*;
use stereo_selfcal::{Correspondence, Extrinsics};

use crate::errors::{value, wrong_type};

/// A float array of any number type and strides, row by row.
struct Floats {
    shape: Vec<usize>,
    numbers: Vec<f64>,
}

impl Floats {
    /// Reads `f32` and `f64` in place; numpy converts other floats, and lists.
    fn of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(read) = Self::read::<f32>(given).or_else(|| Self::read::<f64>(given)) {
            return Ok(read);
        }
        let is_array = given.cast::<PyUntypedArray>().is_ok();
        let array = given.py().import("numpy")?.call_method1("asarray", (given,));
        let array = array.map_err(|why| {
            wrong_type(format!("{name}: not an array of floats, but a {}: {why}", given.get_type()))
        })?;
        let untyped = array.cast::<PyUntypedArray>()?;
        let (dtype, shape) = (untyped.dtype(), untyped.shape());
        let kind: char = dtype.getattr("kind")?.extract()?;
        // Whole numbers of a list are accepted as floats; an array of whole numbers may be an image.
        if kind != 'f' && (is_array || kind != 'i') {
            let is_image = shape.len() >= 2 && kind == 'u';
            let hint = if is_image { ": an image? `match` finds points in images" } else { "" };
            return Err(wrong_type(format!(
                "{name}: floats are expected, not {dtype} of shape {shape:?}{hint}"
            )));
        }
        let converted = array.call_method1("astype", ("float64",))?;
        Self::read::<f64>(&converted)
            .ok_or_else(|| wrong_type(format!("{name}: {dtype} is no float")))
    }

    /// `None` unless it is an array of this number type.
    fn read<S: Element + Copy + Into<f64>>(given: &Bound<'_, PyAny>) -> Option<Self> {
        let array = given.cast::<PyArrayDyn<S>>().ok()?.try_readonly().ok()?;
        let view = array.as_array();
        let numbers = match view.as_slice() {
            Some(in_rows) => in_rows.iter().map(|x| (*x).into()).collect(),
            None => view.iter().map(|x| (*x).into()).collect(),
        };
        Some(Self { shape: array.shape().to_vec(), numbers })
    }

    /// Rows of `K` numbers; `None` for another shape.
    fn rows<const K: usize>(&self) -> Option<&[[f64; K]]> {
        let is_of_rows = matches!(self.shape[..], [_, columns] if columns == K);
        is_of_rows.then(|| self.numbers.as_chunks().0)
    }

    fn points(&self, name: &str) -> PyResult<&[[f64; 2]]> {
        let wrong = || value(format!("{name}: shape (n, 2) is expected, not {:?}", self.shape));
        self.rows().ok_or_else(wrong)
    }

    /// Finite points, at least one.
    fn some_points(&self, name: &str) -> PyResult<&[[f64; 2]]> {
        let points = self.points(name)?;
        if points.is_empty() {
            return Err(value(format!("{name}: no points, shape (0, 2)")));
        }
        let is_bad = |point: &[f64; 2]| point.iter().any(|x| !x.is_finite());
        match points.iter().position(is_bad) {
            Some(i) => Err(value(format!("{name}[{i}] = {:?} is not finite", points[i]))),
            None => Ok(points),
        }
    }
}

/// Points, (n, 2).
pub(crate) fn points(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    Ok(Floats::of(name, given)?.points(name)?.to_vec())
}

/// The matches of a pair; each array has one row for each match.
///
/// * `names`: names of the left and the right points.
pub(crate) fn matches(
    names: [&str; 2],
    left: &Bound<'_, PyAny>,
    right: &Bound<'_, PyAny>,
    score: Option<&Bound<'_, PyAny>>,
    grid_step: f64,
) -> PyResult<Vec<Correspondence<f32>>> {
    if !(0.0..=255.99).contains(&grid_step) {
        return Err(value(format!("grid_step: {grid_step} px is not within 0 to 255.99")));
    }
    let (left, right) = (Floats::of(names[0], left)?, Floats::of(names[1], right)?);
    let (left, right) = (left.some_points(names[0])?, right.some_points(names[1])?);
    same_length(names[1], right.len(), left.len())?;
    let score = score.filter(|score| !score.is_none());
    let score = score.map(|given| scores(given, left.len())).transpose()?;
    let narrow = |pixel: &[f64; 2]| pixel.map(|x| x as f32);
    let all = left.iter().zip(right).enumerate();
    let correspondence = |(i, (left, right)): (usize, (&[f64; 2], &[f64; 2]))| Correspondence {
        left: narrow(left),
        right: narrow(right),
        score: score.as_ref().map_or(1.0, |score| score[i] as f32),
        grid_step: grid_step as f32,
    };
    Ok(all.map(correspondence).collect())
}

fn scores(given: &Bound<'_, PyAny>, rows: usize) -> PyResult<Vec<f64>> {
    let Floats { shape, numbers } = Floats::of("score", given)?;
    if shape.len() != 1 {
        return Err(value(format!("score: shape ({rows},) is expected, not {shape:?}")));
    }
    same_length("score", numbers.len(), rows)?;
    match numbers.iter().position(|score| !(0.0..=1.0).contains(score)) {
        Some(i) => Err(value(format!("score[{i}] = {} is not within 0 to 1", numbers[i]))),
        None => Ok(numbers),
    }
}

/// Names of the points of a pair.
pub(crate) const POINTS: [&str; 2] = ["uv_left", "uv_right"];

/// Checks that an argument has one row for each match.
pub(crate) fn same_length(name: &str, rows: usize, expected: usize) -> PyResult<()> {
    if rows == expected {
        return Ok(());
    }
    Err(value(format!("{name}: {rows} rows, not {expected}: one for each match")))
}

/// A 3 x 3 matrix, row by row.
pub(crate) fn matrix(name: &str, given: &Bound<'_, PyAny>) -> PyResult<[[f64; 3]; 3]> {
    let floats = Floats::of(name, given)?;
    let square = floats.rows::<3>().and_then(|rows| rows.try_into().ok());
    square.ok_or_else(|| value(format!("{name}: shape (3, 3) is expected, not {:?}", floats.shape)))
}

/// A vector as `(n,)`, `(n, 1)` or `(1, n)`: OpenCV returns all three.
pub(crate) fn vector(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let Floats { shape, numbers } = Floats::of(name, given)?;
    match shape[..] {
        [_] | [_, 1] | [1, _] => Ok(numbers),
        _ => Err(value(format!("{name}: a vector is expected, not shape {shape:?}"))),
    }
}

/// Defines plain data that is read as a new array of numpy.
macro_rules! arrays {
    ($($(#[$doc:meta])* $name:ident($data:ty)$(<$($size:ident),+>)?, $array:ty, $make:expr;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, FromPyObject)]
        pub(crate) struct $name$(<$(const $size: usize),+>)?(pub(crate) $data);

        impl<'py$($(, const $size: usize)+)?> IntoPyObject<'py> for $name$(<$($size),+>)? {
            type Target = $array;
            type Output = Bound<'py, $array>;
            type Error = Infallible;

            fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Infallible> {
                let make: fn(Python<'py>, &$data) -> Self::Output = $make;
                Ok(make(py, &self.0))
            }
        }
    )+};
}
arrays! {
    /// A matrix.
    Matrix([[f64; C]; R])<R, C>, PyArray2<f64>, |py, rows| aview2(rows).to_pyarray(py);
    /// Points, (n, 2).
    Points(Vec<[f64; 2]>), PyArray2<f64>, |py, rows| aview2(rows).to_pyarray(py);
    /// A vector.
    Vector(Vec<f64>), PyArray1<f64>, |py, numbers| PyArray1::from_slice(py, numbers);
}

/// `R` and `t` of extrinsics.
pub(crate) fn pose(of: &Extrinsics<f64>) -> (Matrix<3, 3>, Vector) {
    (Matrix(rows(of.rotation().matrix())), Vector(of.translation().as_slice().to_vec()))
}
