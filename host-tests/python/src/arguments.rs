//! Arrays of numpy as checked numbers. Every error names the argument, its shape and the value.

use std::convert::Infallible;

use numpy::ndarray::aview2;
use numpy::{Element, PyArray1, PyArray2, PyReadonlyArrayDyn, PyUntypedArray, ToPyArray};
use numpy::{PyUntypedArrayMethods, ndarray::ArrayView1};
use pyo3::prelude::*;
use rigs::data::rows;
use stereo_selfcal::{Correspondence, Extrinsics};

use crate::errors::{value, wrong_type};

/// An argument as it is given.
pub(crate) type Given<'py> = Bound<'py, PyAny>;

/// Whether frames are to tell motion.
pub(crate) fn motion(given: &Given<'_>) -> PyResult<bool> {
    given.extract().map_err(|_| wrong_type(format!("motion: {given} is neither True nor False")))
}

/// An array of any type of real number and any strides, row by row.
struct Floats {
    shape: Vec<usize>,
    numbers: Vec<f64>,
}

impl Floats {
    /// Reads arrays of `f32` and `f64` directly; numpy converts other numbers, and lists of them.
    fn of(name: &str, given: &Given<'_>) -> PyResult<Self> {
        if let Some(read) = Self::read::<f32>(given).or_else(|| Self::read::<f64>(given)) {
            return Ok(read);
        }
        let array = given.py().import("numpy")?.call_method1("asarray", (given,));
        let array = array.map_err(|why| {
            wrong_type(format!("{name}: not an array of floats, but a {}: {why}", given.get_type()))
        })?;
        let kind: char = array.getattr("dtype")?.getattr("kind")?.extract()?;
        if !matches!(kind, 'f' | 'i' | 'u') {
            let given = described(&array);
            return Err(wrong_type(format!("{name}: real numbers are expected, not {given}")));
        }
        let converted = array.call_method1("astype", ("float64",))?;
        let read = Self::read::<f64>(&converted);
        read.ok_or_else(|| wrong_type(format!("{name}: {} is no float", described(&array))))
    }

    /// `None` unless it is an array of this number type.
    fn read<S: Element + Copy + Into<f64>>(given: &Given<'_>) -> Option<Self> {
        let array: PyReadonlyArrayDyn<'_, S> = given.extract().ok()?;
        let numbers = array.as_array().as_standard_layout().mapv(Into::into);
        Some(Self { shape: array.shape().to_vec(), numbers: numbers.into_raw_vec_and_offset().0 })
    }

    /// Rows of `K` numbers; those of OpenCV are in an axis of their own, `(n, 1, K)`.
    ///
    /// * `shape`: the shape in words.
    fn rows<const K: usize>(&self, name: &str, shape: &str) -> PyResult<&[[f64; K]]> {
        let is_of_rows = matches!(self.shape[..], [_, columns] | [_, 1, columns] if columns == K);
        let wrong = || {
            let is_image = matches!(self.shape[..], [rows, columns, ..] if rows.min(columns) > 16);
            let hint = if is_image { ": an image? `match` finds points in images" } else { "" };
            value(format!("{name}: shape {shape} is expected, not {:?}{hint}", self.shape))
        };
        is_of_rows.then(|| self.numbers.as_chunks().0).ok_or_else(wrong)
    }

    /// Finite points, at least one.
    fn some_points(&self, name: &str) -> PyResult<&[[f64; 2]]> {
        let points = self.rows(name, "(n, 2)")?;
        if points.is_empty() {
            return Err(value(format!("{name}: no points, shape (0, 2)")));
        }
        match points.iter().position(|[u, v]| !u.is_finite() || !v.is_finite()) {
            Some(i) => Err(value(format!("{name}[{i}] = {:?} is not finite", points[i]))),
            None => Ok(points),
        }
    }
}

/// Type and shape of an array; the type of anything else.
pub(crate) fn described(given: &Given<'_>) -> String {
    match given.cast::<PyUntypedArray>() {
        Ok(array) => format!("{} of shape {:?}", array.dtype(), array.shape()),
        Err(_) => given.get_type().to_string(),
    }
}

/// Points, (n, 2).
pub(crate) fn points(name: &str, given: &Given<'_>) -> PyResult<Vec<[f64; 2]>> {
    Ok(Floats::of(name, given)?.rows(name, "(n, 2)")?.to_vec())
}

/// The matches of a pair; each array has one row for each match.
///
/// * `names`: names of the left and the right points.
pub(crate) fn matches(
    names: [&str; 2],
    [left, right]: [&Given<'_>; 2],
    score: Option<&Given<'_>>,
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
    let pair = left.iter().zip(right).enumerate().map(|(i, (left, right))| Correspondence {
        left: left.map(|x| x as f32),
        right: right.map(|x| x as f32),
        score: score.as_ref().map_or(1.0, |score| score[i] as f32),
        grid_step: grid_step as f32,
    });
    Ok(pair.collect())
}

fn scores(given: &Given<'_>, rows: usize) -> PyResult<Vec<f64>> {
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
    let wrong = || value(format!("{name}: {rows} rows, not {expected}: one for each match"));
    (rows == expected).then_some(()).ok_or_else(wrong)
}

/// A 3 x 3 matrix, row by row.
pub(crate) fn matrix(name: &str, given: &Given<'_>) -> PyResult<[[f64; 3]; 3]> {
    let floats = Floats::of(name, given)?;
    let rows = floats.rows(name, "(3, 3)")?;
    let wrong = |_| value(format!("{name}: shape (3, 3) is expected, not {:?}", floats.shape));
    rows.try_into().map_err(wrong)
}

/// A vector as `(n,)`, `(n, 1)` or `(1, n)`: OpenCV returns all three.
pub(crate) fn vector(name: &str, given: &Given<'_>) -> PyResult<Vec<f64>> {
    let Floats { shape, numbers } = Floats::of(name, given)?;
    match shape[..] {
        [_] | [_, 1] | [1, _] => Ok(numbers),
        _ => Err(value(format!("{name}: a vector is expected, not shape {shape:?}"))),
    }
}

/// Defines plain data that is read as a new array of numpy.
macro_rules! arrays {
    ($($(#[$doc:meta])* $name:ident($data:ty)$(<$($size:ident),+>)?, $array:ty, $view:expr;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, FromPyObject)]
        pub(crate) struct $name$(<$(const $size: usize),+>)?(pub(crate) $data);

        impl<'py$($(, const $size: usize)+)?> IntoPyObject<'py> for $name$(<$($size),+>)? {
            type Target = $array;
            type Output = Bound<'py, $array>;
            type Error = Infallible;

            fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Infallible> {
                Ok($view(&self.0[..]).to_pyarray(py))
            }
        }
    )+};
}
arrays! {
    /// A matrix.
    Matrix([[f64; C]; R])<R, C>, PyArray2<f64>, aview2;
    /// Points, (n, 2).
    Points(Vec<[f64; 2]>), PyArray2<f64>, aview2;
    /// Three numbers.
    Triple([f64; 3]), PyArray1<f64>, ArrayView1::from;
    /// A vector.
    Vector(Vec<f64>), PyArray1<f64>, ArrayView1::from;
}

/// `R` and `t` of extrinsics.
pub(crate) type Pose = (Matrix<3, 3>, Triple);

/// `R` and `t` of extrinsics.
pub(crate) fn pose(of: &Extrinsics<f64>) -> Pose {
    (Matrix(rows(of.rotation().matrix())), Triple(of.translation().into_inner().into()))
}
