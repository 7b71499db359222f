//! Sub-pixel refinement of both coordinates: iterative Lucas-Kanade (inverse compositional) with an affine
//! map, brightness and contrast free.
//!
//! S. Baker, I. Matthews, "Lucas-Kanade 20 Years On", IJCV 2004. The window has Gaussian weights around the left
//! corner. The translation is fitted first, then the affine map: slanted surfaces and rolled cameras shear the window,
//! which moves the optimum of a translation by tenths of a pixel.

use nalgebra::{SMatrix, SVector};

use super::patch::{AREA, REACH, SIDE, Warp, dot, moments, weights, window};
use crate::picture::Picture;

/// Standard deviation of the window's weights, px.
const SIGMA: f32 = 4.5;

/// Largest number of steps of the translation.
const TRANSLATIONS: usize = 12;
/// Largest number of steps of the affine map.
const AFFINES: usize = 10;

/// A step below this ends the iteration, px.
const SETTLED: f32 = 0.02;

/// Least contrast of the window, grey levels.
const LEAST_CONTRAST: f32 = 4.0;

/// Largest deviation of an element of the affine map from the identity.
const MOST_SHEAR: f32 = 0.5;

/// A refined position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Refined {
    /// Position in the right image, px.
    pub(super) place: [f64; 2],
    /// Correlation of the two windows, at most 1.
    pub(super) correlation: f64,
    /// Predicted standard deviation of column and row, px.
    pub(super) sd: [f64; 2],
}

impl Refined {
    /// Converts px of a halved image to px of the whole image.
    fn scaled(self, scale: f32) -> Self {
        let scaled = |pair: [f64; 2]| pair.map(|x| x * f64::from(scale));
        Self { place: scaled(self.place), sd: scaled(self.sd), ..self }
    }
}

/// Levels of an image pyramid: the image, then each level at half the size of the level before.
pub(super) type Halved = Vec<Picture>;

/// Refines positions of matches.
pub(super) struct Refiner {
    /// Gaussian weights of the window, sum 1.
    weights: [f32; AREA],
}

/// The window around the left corner, and its gradients.
struct Template {
    /// Values with mean 0 and standard deviation 1.
    values: [f32; AREA],
    /// Derivatives of `values` by x and y.
    gradients: [[f32; AREA]; 2],
}

impl Refiner {
    pub(super) fn new() -> Self {
        Self { weights: weights(SIGMA) }
    }

    /// Position in the right image of the content that the left image has at `left`; `None` if it is not found near
    /// `right`.
    ///
    /// * `levels`: coarsest level of the halved images, where the search starts, and finest, where it ends.
    pub(super) fn refine(
        &self,
        pictures: [&Halved; 2],
        left: [f64; 2],
        right: [f64; 2],
        [coarsest, finest]: [usize; 2],
    ) -> Option<Refined> {
        let mut place = right.map(|x| x as f32);
        let mut refined = None;
        for level in (finest..=coarsest).rev() {
            let scale = (1_u32 << level) as f32;
            let [l, r] = pictures.map(|halved| &halved[level]);
            let template = self.template(l, left.map(|x| x as f32 / scale))?;
            let mut warp = Warp::at(place.map(|x| x / scale));
            self.settle::<2>(&template, r, &mut warp, TRANSLATIONS)?;
            if level == finest {
                refined = Some(self.settle::<6>(&template, r, &mut warp, AFFINES)?.scaled(scale));
            }
            place = warp.place.map(|x| x * scale);
        }
        refined
    }

    fn template(&self, picture: &Picture, place: [f32; 2]) -> Option<Template> {
        let values = window(picture, &Warp::at(place))?;
        let (mean, sd) = moments(&values, &self.weights);
        if sd < LEAST_CONTRAST {
            return None;
        }
        let shifted = |dx: f32, dy: f32| window(picture, &Warp::at([place[0] + dx, place[1] + dy]));
        let difference = |a: [f32; AREA], b: [f32; AREA]| {
            let mut gradient = [0.0; AREA];
            for (g, (a, b)) in gradient.iter_mut().zip(a.iter().zip(&b)) {
                *g = (a - b) / (2.0 * sd);
            }
            gradient
        };
        let gradients = [
            difference(shifted(1.0, 0.0)?, shifted(-1.0, 0.0)?),
            difference(shifted(0.0, 1.0)?, shifted(0.0, -1.0)?),
        ];
        Some(Template { values: values.map(|x| (x - mean) / sd), gradients })
    }

    /// Updates the map until the step is small; `None` if it does not settle. `K` is 2 for a translation, and 6 for an
    /// affine map.
    fn settle<const K: usize>(
        &self,
        template: &Template,
        picture: &Picture,
        warp: &mut Warp,
        limit: usize,
    ) -> Option<Refined> {
        let columns = columns::<K>(template);
        let weighted = columns.map(|column| product(&column, &self.weights));
        let normal = SMatrix::<f32, K, K>::from_fn(|i, j| dot(&weighted[i], &columns[j]));
        let inverse = normal.try_inverse()?;
        for _ in 0..limit {
            let (residuals, correlation) = self.residuals(template, picture, warp)?;
            let step = inverse * SVector::<f32, K>::from_fn(|i, _| dot(&weighted[i], &residuals));
            compose(warp, step.as_slice())?;
            if step[0].hypot(step[1]) < SETTLED {
                return Some(self.report(warp, &residuals, correlation, &inverse));
            }
        }
        None
    }

    /// Right window less left window, both with mean 0 and standard deviation 1, and their correlation.
    fn residuals(
        &self,
        template: &Template,
        picture: &Picture,
        warp: &Warp,
    ) -> Option<([f32; AREA], f32)> {
        let values = window(picture, warp)?;
        let (mean, sd) = moments(&values, &self.weights);
        if sd < LEAST_CONTRAST {
            return None;
        }
        let values = values.map(|x| (x - mean) / sd);
        let correlation = dot(&product(&values, &self.weights), &template.values);
        Some((std::array::from_fn(|i| values[i] - template.values[i]), correlation))
    }

    fn report<const K: usize>(
        &self,
        warp: &Warp,
        residuals: &[f32; AREA],
        correlation: f32,
        inverse: &SMatrix<f32, K, K>,
    ) -> Refined {
        let squares = dot(&product(residuals, residuals), &self.weights);
        // Residuals of neighbouring pixels are correlated: the number of independent ones follows from the area of the
        // weights.
        let independent = 2.0 * std::f32::consts::PI * SIGMA * SIGMA;
        let sd = |i: usize| f64::from((inverse[(i, i)] * squares / independent).sqrt());
        Refined {
            place: warp.place.map(f64::from),
            correlation: f64::from(correlation),
            sd: [sd(0), sd(1)],
        }
    }
}

fn product(a: &[f32; AREA], b: &[f32; AREA]) -> [f32; AREA] {
    std::array::from_fn(|i| a[i] * b[i])
}

/// Derivatives of the template by the parameters of the map: two for the position, four for the shape.
fn columns<const K: usize>(template: &Template) -> [[f32; AREA]; K] {
    let [x, y] = [0, 1].map(|axis| {
        let steps = |i: usize| if axis == 0 { i % SIDE } else { i / SIDE };
        std::array::from_fn(|i| steps(i) as f32 - REACH as f32)
    });
    let [gx, gy] = &template.gradients;
    std::array::from_fn(|k| match k {
        0 => *gx,
        1 => *gy,
        2 => product(gx, &x),
        3 => product(gx, &y),
        4 => product(gy, &x),
        _ => product(gy, &y),
    })
}

/// Composes `warp` with the inverse of a step; `None` if there is no inverse, or the result is far from the identity.
fn compose(warp: &mut Warp, step: &[f32]) -> Option<()> {
    let get = |i: usize| step.get(i).copied().unwrap_or(0.0);
    let [a, b, c, d] = [1.0 + get(2), get(3), get(4), 1.0 + get(5)];
    let determinant = a * d - b * c;
    if determinant.is_nan() || determinant.abs() <= 0.1 {
        return None;
    }
    let inverse = [[d / determinant, -b / determinant], [-c / determinant, a / determinant]];
    let shift = inverse.map(|[p, q]| -(p * get(0) + q * get(1)));
    let [[a, b], [c, d]] = warp.shape;
    warp.place[0] += a * shift[0] + b * shift[1];
    warp.place[1] += c * shift[0] + d * shift[1];
    let [[p, q], [r, s]] = inverse;
    warp.shape = [[a * p + b * r, a * q + b * s], [c * p + d * r, c * q + d * s]];
    let [[a, b], [c, d]] = warp.shape;
    let far = [a - 1.0, b, c, d - 1.0].iter().any(|x| x.is_nan() || x.abs() > MOST_SHEAR);
    (!far).then_some(())
}
