//! Arrays of numpy as checked numbers. Every error names the argument, its shape and the value.

use numpy::ndarray::{ArrayView1, ArrayView2, Axis};
use numpy::{
    PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods, ToPyArray,
};
use pyo3::prelude::*;
use stereo_selfcal::Correspondence;

use crate::errors::{value, wrong_type};

/// Points `(u, v)` or any other columns, and the numbers of a list.
type Pixels = Vec<[f64; 2]>;

/// A float array in the number type that it has.
enum Floats<'py> {
    F32(PyReadonlyArrayDyn<'py, f32>),
    F64(PyReadonlyArrayDyn<'py, f64>),
}

impl<'py> Floats<'py> {
    /// Views an array without a copy if it is of `f32` or `f64`, of any strides.
    fn of(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Some(view) = Self::view(given) {
            return Ok(view);
        }
        let numpy = given.py().import("numpy")?;
        let array = match given.cast::<PyUntypedArray>() {
            Ok(array) => array.as_any().clone(),
            Err(_) => numpy.call_method1("asarray", (given,)).map_err(|why| {
                wrong_type(format!("{name}: no array of floats, but {}: {why}", type_name(given)))
            })?,
        };
        let untyped = array.cast::<PyUntypedArray>()?;
        let dtype = untyped.dtype();
        let kind: char = dtype.getattr("kind")?.extract()?;
        // Whole numbers of a list are as good as floats; those of an array may be an image.
        let listed = given.cast::<PyUntypedArray>().is_err() && kind == 'i';
        if kind != 'f' && !listed {
            return Err(wrong_type(format!(
                "{name}: floats are expected, not {dtype} of shape {:?}{}",
                untyped.shape(),
                if untyped.ndim() >= 2 && kind == 'u' {
                    ": an image? `match` finds points in images"
                } else {
                    ""
                }
            )));
        }
        let converted = array.call_method1("astype", ("float64",))?;
        Self::view(&converted).ok_or_else(|| wrong_type(format!("{name}: {dtype} is no float")))
    }

    fn view(given: &Bound<'py, PyAny>) -> Option<Self> {
        let f64s = || given.cast::<PyArrayDyn<f64>>().ok().and_then(|a| a.try_readonly().ok());
        let f32s = || given.cast::<PyArrayDyn<f32>>().ok().and_then(|a| a.try_readonly().ok());
        f32s().map(Self::F32).or_else(|| f64s().map(Self::F64))
    }

    fn shape(&self) -> &[usize] {
        match self {
            Self::F32(array) => array.shape(),
            Self::F64(array) => array.shape(),
        }
    }

    /// Rows of `K` numbers, each passed through.
    fn rows<const K: usize, T>(&self, mut each: impl FnMut([f64; K]) -> T) -> Option<Vec<T>> {
        fn all<S: Copy + Into<f64>, const K: usize, T>(
            view: ArrayView2<'_, S>,
            each: &mut impl FnMut([f64; K]) -> T,
        ) -> Vec<T> {
            view.axis_iter(Axis(0))
                .map(|row| each(std::array::from_fn(|i| row[i].into())))
                .collect()
        }
        let [_, columns] = *self.shape() else { return None };
        if columns != K {
            return None;
        }
        Some(match self {
            Self::F32(array) => all(array.as_array().into_dimensionality().ok()?, &mut each),
            Self::F64(array) => all(array.as_array().into_dimensionality().ok()?, &mut each),
        })
    }

    /// The numbers of a list.
    fn list(&self) -> Option<Vec<f64>> {
        fn all<S: Copy + Into<f64>>(view: ArrayView1<'_, S>) -> Vec<f64> {
            view.iter().map(|x| (*x).into()).collect()
        }
        Some(match self {
            Self::F32(array) => all(array.as_array().into_dimensionality().ok()?),
            Self::F64(array) => all(array.as_array().into_dimensionality().ok()?),
        })
    }
}

fn type_name(of: &Bound<'_, PyAny>) -> String {
    of.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

/// Points, (n, 2).
pub(crate) fn points(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Pixels> {
    let floats = Floats::of(name, given)?;
    let rows = floats.rows(|point: [f64; 2]| point);
    rows.ok_or_else(|| value(format!("{name}: shape (n, 2) is expected, not {:?}", floats.shape())))
}

/// The same, finite and at least one.
fn some_points(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Pixels> {
    let points = points(name, given)?;
    if points.is_empty() {
        return Err(value(format!("{name}: no points, shape (0, 2)")));
    }
    let is_bad = |point: &[f64; 2]| point.iter().any(|x| !x.is_finite());
    match points.iter().position(is_bad) {
        Some(i) => Err(value(format!("{name}[{i}] = {:?} is not finite", points[i]))),
        None => Ok(points),
    }
}

/// The matches of a pair; each of the arrays has a row for each.
pub(crate) fn matches(
    left: &Bound<'_, PyAny>,
    right: &Bound<'_, PyAny>,
    score: Option<&Bound<'_, PyAny>>,
    grid_step: f64,
) -> PyResult<Vec<Correspondence<f32>>> {
    if !(0.0..=255.99).contains(&grid_step) {
        return Err(value(format!("grid_step: {grid_step} px is not within 0 to 255.99")));
    }
    let left = some_points("uv_left", left)?;
    let right = some_points("uv_right", right)?;
    same_length("uv_right", right.len(), left.len())?;
    let score = match score {
        Some(given) => scores(given, left.len())?,
        None => vec![1.0; left.len()],
    };
    let narrow = |pixel: [f64; 2]| pixel.map(|x| x as f32);
    let all = left.into_iter().zip(right).zip(score);
    Ok(all
        .map(|((left, right), score)| Correspondence {
            left: narrow(left),
            right: narrow(right),
            score: score as f32,
            grid_step: grid_step as f32,
        })
        .collect())
}

fn scores(given: &Bound<'_, PyAny>, rows: usize) -> PyResult<Vec<f64>> {
    let floats = Floats::of("score", given)?;
    let wrong = || value(format!("score: shape ({rows},) is expected, not {:?}", floats.shape()));
    let scores = floats.list().ok_or_else(wrong)?;
    same_length("score", scores.len(), rows)?;
    match scores.iter().position(|score| !(0.0..=1.0).contains(score)) {
        Some(i) => Err(value(format!("score[{i}] = {} is not within 0 to 1", scores[i]))),
        None => Ok(scores),
    }
}

/// Checks that an argument has a row for each of another.
pub(crate) fn same_length(name: &str, rows: usize, expected: usize) -> PyResult<()> {
    if rows == expected {
        return Ok(());
    }
    Err(value(format!("{name}: {rows} rows, but uv_left has {expected}: one row for each match")))
}

/// A 3 x 3 matrix, row by row.
pub(crate) fn matrix(name: &str, given: &Bound<'_, PyAny>) -> PyResult<[[f64; 3]; 3]> {
    let floats = Floats::of(name, given)?;
    let rows: Option<Vec<[f64; 3]>> = floats.rows(|row| row);
    let square = rows.and_then(|rows| rows.try_into().ok());
    square
        .ok_or_else(|| value(format!("{name}: shape (3, 3) is expected, not {:?}", floats.shape())))
}

/// A vector as `(n,)`, `(n, 1)` or `(1, n)`: OpenCV returns all three.
pub(crate) fn vector(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let floats = Floats::of(name, given)?;
    let wrong = || value(format!("{name}: a vector is expected, not shape {:?}", floats.shape()));
    match floats.shape() {
        [_] => floats.list().ok_or_else(wrong),
        [_, 1] => Ok(floats.rows(|[x]: [f64; 1]| x).unwrap_or_default()),
        [1, _] => {
            let flat = given.call_method0("ravel")?;
            vector(name, &flat)
        }
        _ => Err(wrong()),
    }
}

/// A matrix as a new array.
pub(crate) fn to_matrix<'py, const R: usize, const C: usize>(
    py: Python<'py>,
    rows: &[[f64; C]; R],
) -> Bound<'py, PyArray2<f64>> {
    numpy::ndarray::aview2(rows).to_pyarray(py)
}

/// A vector as a new array.
pub(crate) fn to_vector<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, numbers)
}
