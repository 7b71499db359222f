//! Square windows of an image at sub-pixel places.

use crate::picture::Picture;

/// Half of a window, px.
pub(super) const REACH: i32 = 8;
/// Pixels of a window's side.
pub(super) const SIDE: usize = 2 * REACH as usize + 1;
/// Pixels of a window.
pub(super) const AREA: usize = SIDE * SIDE;

/// An affine map of window coordinates into an image, px: `[u, v] = place + shape * [x, y]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Warp {
    pub(super) place: [f32; 2],
    pub(super) shape: [[f32; 2]; 2],
}

impl Warp {
    const PLAIN: [[f32; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

    /// A translation.
    pub(super) fn at(place: [f32; 2]) -> Self {
        Self { place, shape: Self::PLAIN }
    }
}

/// Values of the window, interpolated bilinearly; `None` if the window leaves the image.
pub(super) fn window(picture: &Picture, warp: &Warp) -> Option<[f32; AREA]> {
    let [width, height] = picture.size().map(usize::from);
    let [[a, b], [c, d]] = warp.shape;
    let reach = REACH as f32;
    // The corners bound the window, since the map is affine.
    let spread = [(a.abs() + b.abs()) * reach, (c.abs() + d.abs()) * reach];
    for ((place, spread), length) in warp.place.iter().zip(spread).zip([width, height]) {
        if !(place - spread >= 0.0 && place + spread < (length - 1) as f32 - 0.001) {
            return None;
        }
    }
    Some(if warp.shape == Warp::PLAIN { moved(picture, warp.place) } else { mapped(picture, warp) })
}

/// The window after a translation: the fractions of a pixel are the same for all values.
fn moved(picture: &Picture, place: [f32; 2]) -> [f32; AREA] {
    let width = usize::from(picture.size()[0]);
    let [left, top] = place.map(|x| x as usize - REACH as usize);
    let [du, dv] = place.map(|x| x - (x as usize) as f32);
    let weights = [(1.0 - du) * (1.0 - dv), du * (1.0 - dv), (1.0 - du) * dv, du * dv];
    let mut values = [0.0; AREA];
    for (row, values) in values.chunks_exact_mut(SIDE).enumerate() {
        let at = (top + row) * width + left;
        let line = |from: usize| &picture.pixels()[from..=from + SIDE];
        for (value, (upper, lower)) in
            values.iter_mut().zip(line(at).windows(2).zip(line(at + width).windows(2)))
        {
            let four = [upper[0], upper[1], lower[0], lower[1]].map(f32::from);
            let [p, q, r, s] = four;
            *value = weights[0] * p + weights[1] * q + weights[2] * r + weights[3] * s;
        }
    }
    values
}

fn mapped(picture: &Picture, warp: &Warp) -> [f32; AREA] {
    let width = usize::from(picture.size()[0]);
    let pixels = picture.pixels();
    let [[a, b], [c, d]] = warp.shape;
    let mut values = [0.0; AREA];
    for (row, values) in (-REACH..).zip(values.chunks_exact_mut(SIDE)) {
        let y = row as f32;
        let [u0, v0] = [warp.place[0] + b * y, warp.place[1] + d * y];
        for (column, value) in (-REACH..).zip(values) {
            let x = column as f32;
            let (u, v) = (u0 + a * x, v0 + c * x);
            // `i32`, because a conversion to 64 bits takes several more instructions.
            let (left, top) = (u as i32, v as i32);
            let (du, dv) = (u - left as f32, v - top as f32);
            let at = top as usize * width + left as usize;
            let (upper, lower) = (&pixels[at..at + 2], &pixels[at + width..at + width + 2]);
            let [p, q, r, s] = [upper[0], upper[1], lower[0], lower[1]].map(f32::from);
            let (upper, lower) = (p + du * (q - p), r + du * (s - r));
            *value = upper + dv * (lower - upper);
        }
    }
    values
}

/// Sum of products, in separate lanes. A plain sum has a fixed order, so the compiler could not use vector
/// instructions.
pub(super) fn dot(a: &[f32; AREA], b: &[f32; AREA]) -> f32 {
    const LANES: usize = 8;
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + rest
}

/// Mean and standard deviation under weights whose sum is 1.
pub(super) fn moments(values: &[f32; AREA], weights: &[f32; AREA]) -> (f32, f32) {
    let mean = dot(values, weights);
    let squares = std::array::from_fn(|i| (values[i] - mean) * (values[i] - mean));
    (mean, dot(&squares, weights).sqrt())
}

/// Gaussian weights over the window, sum 1.
pub(super) fn weights(sigma: f32) -> [f32; AREA] {
    let mut weights = [0.0; AREA];
    for (row, weights) in (-REACH..).zip(weights.chunks_exact_mut(SIDE)) {
        for (column, weight) in (-REACH..).zip(weights) {
            let squared = (row * row + column * column) as f32;
            *weight = (-squared / (2.0 * sigma * sigma)).exp();
        }
    }
    let sum: f32 = weights.iter().sum();
    weights.map(|w| w / sum)
}
