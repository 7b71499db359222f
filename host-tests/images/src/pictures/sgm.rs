//! Dense disparities of a rectified pair: census transform and semi-global matching.
//!
//! H. Hirschmueller, "Stereo Processing by Semiglobal Matching and Mutual Information", PAMI 2008: costs
//! aggregated along eight directions, winner takes all. The cost is the Hamming distance of 7 x 7 census
//! transforms. A disparity counts if its cost is clearly the least and the right image has the same.
//! Holes are not filled.

use rayon::prelude::*;

use super::grey::Grey;

/// Half the width of the census window, px.
const REACH: isize = 3;

/// Cost if one of the two pixels is unseen, and expected cost of random census bits: half of the 48 bits.
const UNSEEN: u8 = 24;

/// Penalties of a disparity that changes by 1 px between neighbours, and by more (eq 13 there).
const SMALL_STEP: i16 = 8;
const LARGE_STEP: i16 = 80;

/// Difference allowed between the disparities found from the left and from the right, px.
const CONSISTENT: usize = 1;

/// Least cost excess of any other disparity, per cent: the middle of OpenCV's recommendation for `uniquenessRatio`.
const UNIQUE_PERCENT: i32 = 10;

/// Disparities of the left image's pixels, `u_l - u_r`, px.
#[derive(Debug, Clone, PartialEq)]
pub struct Disparities {
    /// Width and height, px.
    pub size: [u16; 2],
    /// Rows of pixels, top first. `None` if the pixel is unseen, its disparity is not unique, or the right image has
    /// another one.
    pub pixels: Vec<Option<f64>>,
}

impl Disparities {
    /// Disparities of a rectified pair, from 0 to below `range`, px.
    ///
    /// Both images must have the same size: rows beyond the right image have no disparity.
    pub fn of(left: &Grey, right: &Grey, range: u16) -> Self {
        let range = usize::from(range.max(1));
        let width = left.width();
        let costs = matching_costs(left, right, range);
        let sums = aggregated(&costs, width, range);
        let rows = sums.par_chunks(width * range).zip(left.pixels().par_chunks(width));
        let pixels = rows.flat_map_iter(|(sums, pixels)| row(sums, pixels, range)).collect();
        Self { size: left.size(), pixels }
    }

    /// Share of the seen pixels of the left image that have a disparity, 0 to 1.
    pub fn valid_share(&self, left: &Grey) -> f64 {
        let seen = left.pixels().iter().flatten().count();
        let valid = self.pixels.iter().flatten().count();
        share(valid, seen)
    }
}

/// `part / whole`; 0 if `whole` is 0.
pub fn share(part: usize, whole: usize) -> f64 {
    let count = |n: usize| u32::try_from(n).map_or(f64::INFINITY, f64::from);
    if whole == 0 { 0.0 } else { count(part) / count(whole) }
}

/// The darker neighbours as bits; `None` if a pixel of the window is unseen.
fn census(image: &Grey) -> Vec<Option<u64>> {
    let [width, height] = image.size().map(usize::from);
    let neighbours = || (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
    let at = |u: usize, v: usize| {
        let centre = image.at(u, v)?;
        let mut bits = 0;
        for (dx, dy) in neighbours().filter(|&offset| offset != (0, 0)) {
            let neighbour = image.at(u.checked_add_signed(dx)?, v.checked_add_signed(dy)?)?;
            bits = bits << 1 | u64::from(neighbour < centre);
        }
        Some(bits)
    };
    (0..height).flat_map(|v| (0..width).map(move |u| (u, v))).map(|(u, v)| at(u, v)).collect()
}

/// `[row][column][disparity]`.
fn matching_costs(left: &Grey, right: &Grey, range: usize) -> Vec<u8> {
    let width = left.width();
    let (left, right) = (census(left), census(right));
    let mut costs = vec![UNSEEN; left.len() * range];
    let rows = costs.par_chunks_mut(width * range).zip(left.par_chunks(width));
    rows.zip(right.par_chunks(width)).for_each(|((costs, left), right)| {
        for ((u, l), costs) in left.iter().enumerate().zip(costs.chunks_mut(range)) {
            let from_here = right.get(..=u).unwrap_or(right).iter().rev();
            for (cost, r) in costs.iter_mut().zip(from_here) {
                let bits = l.zip(*r).map(|(l, r)| (l ^ r).count_ones());
                *cost = bits.and_then(|bits| u8::try_from(bits).ok()).unwrap_or(UNSEEN);
            }
        }
    });
    costs
}

/// Sums of the path costs of all eight directions.
fn aggregated(costs: &[u8], width: usize, range: usize) -> Vec<i16> {
    let mut sums = vec![0; costs.len()];
    for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)] {
        aggregate_along(costs, &mut sums, width, range, (dx, dy));
    }
    sums
}

/// Adds the path costs of one direction to the sums: `L_r` of Hirschmueller's eq 13, where `r` is the direction.
fn aggregate_along(
    costs: &[u8],
    sums: &mut [i16],
    width: usize,
    range: usize,
    (dx, dy): (isize, isize),
) {
    let stride = width * range;
    let height = costs.len() / stride;
    let in_order =
        |n: usize, forward: bool| (0..n).map(move |i| if forward { i } else { n - 1 - i });
    let mut above = vec![0_i16; stride];
    let mut here = vec![0_i16; stride];
    // Signed 16-bit numbers: every processor has vector instructions for the minimum of several. The path so far has an
    // extra element on either side whose cost is too high to be chosen.
    let mut before = vec![i16::MAX / 2; range + 2];
    for (n, y) in in_order(height, dy >= 0).enumerate() {
        std::mem::swap(&mut above, &mut here);
        for x in in_order(width, dx >= 0) {
            let from = x.checked_add_signed(-dx).filter(|&from| from < width);
            let path = if dy == 0 { &here } else { &above };
            let begins = from.is_none() || (dy != 0 && n == 0);
            match from.filter(|_| !begins) {
                Some(from) => {
                    before[1..=range].copy_from_slice(&path[from * range..(from + 1) * range]);
                }
                None => before[1..=range].fill(0),
            }
            let least = before.iter().copied().min().unwrap_or(0);
            let at = (y * width + x) * range;
            let pixel = costs[at..at + range].iter().zip(&mut sums[at..at + range]);
            let near = before[..range].iter().zip(&before[1..=range]).zip(&before[2..]);
            let places = near.zip(&mut here[x * range..(x + 1) * range]);
            for ((cost, sum), (((below, same), above), path)) in pixel.zip(places) {
                let step = *below.min(above) + SMALL_STEP;
                let cheapest = step.min(*same).min(least + LARGE_STEP);
                *path = i16::from(*cost) + cheapest - least;
                *sum += *path;
            }
        }
    }
}

/// One row of disparities: for each pixel the cheapest disparity, if it is unique and the pixel of the right image has
/// the same one to within [`CONSISTENT`].
fn row(sums: &[i16], pixels: &[Option<u8>], range: usize) -> Vec<Option<f64>> {
    let width = pixels.len();
    let cheapest = |costs: &mut dyn Iterator<Item = i16>| {
        costs.enumerate().min_by_key(|&(_, cost)| cost).map_or(0, |(d, _)| d)
    };
    let from_left: Vec<usize> =
        sums.chunks(range).map(|costs| cheapest(&mut costs.iter().copied())).collect();
    let from_right: Vec<usize> = (0..width)
        .map(|u| cheapest(&mut (0..range.min(width - u)).map(|d| sums[(u + d) * range + d])))
        .collect();
    let disparity = |u: usize| {
        pixels[u]?;
        let d = from_left[u];
        let other = *from_right.get(u.checked_sub(d)?)?;
        let costs = &sums[u * range..(u + 1) * range];
        (other.abs_diff(d) <= CONSISTENT && unique(costs, d)).then(|| vertex(costs, d))
    };
    (0..width).map(disparity).collect()
}

/// Whether each disparity other than `d - 1`, `d` and `d + 1` costs at least [`UNIQUE_PERCENT`] more than `d`.
fn unique(costs: &[i16], d: usize) -> bool {
    let limit = i32::from(costs[d]) * (100 + UNIQUE_PERCENT);
    let others = costs.iter().enumerate().filter(|(other, _)| other.abs_diff(d) > 1);
    others.into_iter().all(|(_, &cost)| i32::from(cost) * 100 >= limit)
}

/// The vertex of the parabola through the least cost and its neighbours.
fn vertex(costs: &[i16], d: usize) -> f64 {
    let whole = u32::try_from(d).map_or(0.0, f64::from);
    let neighbours = d.checked_sub(1).and_then(|i| costs.get(i)).zip(costs.get(d + 1));
    let Some((&low, &high)) = neighbours else { return whole };
    let [low, least, high] = [low, costs[d], high].map(f64::from);
    let curvature = low - 2.0 * least + high;
    if curvature > 0.0 { whole + (low - high) / (2.0 * curvature) } else { whole }
}
