//! Detects left and right images of different moments: a left image fits an earlier or later right image better.

use std::collections::{BTreeMap, VecDeque};
use std::ops::ControlFlow;

use anyhow::Result;
use rayon::prelude::*;
use rigs::data::Match;

use crate::matcher::{Matcher, View};
use crate::source::{Frame, Item, Source};

/// Largest number of pairs examined.
const PAIRS: usize = 8;

/// Largest shift of left against right, pairs.
const REACH: usize = 2;

/// Least number of pairs for a result.
pub const LEAST: usize = 3;

/// Largest row offset of a match that agrees with a rig, px of the image that was searched. At two pixels, pairs of
/// different moments agree if the rig turned by less than two pixels between them.
const IN_ROW_PX: f64 = 0.5;

/// Ratio of agreeing matches, shifted over unshifted, above which the shifted pairs count as better.
const CLEARLY: f64 = 1.5;

/// Left images that fit right images of other pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shift {
    /// Delay of the right images in pairs; negative if they are early.
    pub pairs: isize,
    /// Mean number of matches of a pair that agree, without a shift.
    pub matches: usize,
    /// Mean number of matches of a pair that agree, with the shift.
    pub shifted: usize,
}

impl Shift {
    /// Compares shifts over the first pairs. `None` if no shift is clearly better, or there are too few pairs.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn look(source: &Source, matcher: &Matcher) -> Result<Option<Self>> {
        let pairs = first_pairs(source, PAIRS)?;
        if pairs.len() < LEAST {
            return Ok(None);
        }
        // A single pair always fits some rig, so the largest shift leaves at least two pairs.
        let reach = REACH.min(pairs.len() - 2);
        let all = over_shifts(&pairs, matcher, reach);
        let of =
            |(shift, all): (isize, Vec<Rows>)| (shift, in_agreement(matcher, &all) / all.len());
        let mut all: BTreeMap<isize, usize> = all.into_iter().map(of).collect();
        let matches = all.remove(&0).unwrap_or(0);
        let best = all.into_iter().max_by_key(|(_, shifted)| *shifted);
        Ok(best.and_then(|(pairs, shifted)| {
            let clearly = shifted as f64 > CLEARLY * matches as f64;
            clearly.then_some(Self { pairs, matches, shifted })
        }))
    }
}

/// Matches of a pair with the limit of their row offsets, px.
struct Rows {
    matches: Vec<Match>,
    limit_px: f64,
}

/// Matches of the left image of each pair and the right image of a later or earlier pair, by the delay of the right
/// image in pairs. No more images are held at a time than the largest shift spans.
fn over_shifts(
    pairs: &[[Frame; 2]],
    matcher: &Matcher,
    reach: usize,
) -> BTreeMap<isize, Vec<Rows>> {
    let mut all = BTreeMap::<isize, Vec<Rows>>::new();
    // The newest pair comes first.
    let mut last = VecDeque::new();
    for frames in pairs {
        let pictures = frames[0].picture().and_then(|left| Ok([left, frames[1].picture()?]));
        last.push_front(pictures.and_then(|[left, right]| matcher.views(&left, &right)).ok());
        last.truncate(reach + 1);
        let late = (0..last.len()).map(|age| (age as isize, [age, 0]));
        let early = (1..last.len()).map(|age| (-(age as isize), [0, age]));
        let both: Vec<_> = late.chain(early).collect();
        let of = |(shift, ages): (isize, [usize; 2])| {
            (shift, rows(matcher, ages.map(|age| last[age].as_ref())))
        };
        let found: Vec<_> = both.into_par_iter().map(of).collect();
        for (shift, rows) in found {
            all.entry(shift).or_default().push(rows);
        }
    }
    all
}

/// Matches of a left and a right image; none if an image cannot be read.
fn rows(matcher: &Matcher, [left, right]: [Option<&[View; 2]>; 2]) -> Rows {
    let (Some([left, _]), Some([_, right])) = (left, right) else {
        return Rows { matches: Vec::new(), limit_px: 0.0 };
    };
    Rows { matches: matcher.first([left, right]), limit_px: IN_ROW_PX * left.pixel() }
}

/// Number of matches of the first pairs that agree on a rig, under each of two sets of cameras.
///
/// # Errors
/// If the source cannot be read.
pub fn fits(source: &Source, matchers: [&Matcher; 2]) -> Result<[usize; 2]> {
    let pairs = first_pairs(source, LEAST)?;
    let of = |matcher: &Matcher| -> usize {
        over_shifts(&pairs, matcher, 0).values().map(|all| in_agreement(matcher, all)).sum()
    };
    Ok(matchers.map(of))
}

fn first_pairs(source: &Source, most: usize) -> Result<Vec<[Frame; 2]>> {
    let mut pairs = Vec::new();
    source.read(&mut |item| {
        if let Item::Pair(pair) = item {
            pairs.push(pair);
        }
        if pairs.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    })?;
    Ok(pairs)
}

/// Number of matches of all pairs in row under the extrinsics that were estimated from one of the pairs, for the best
/// choice of this pair. If the cameras move and left and right show different moments, each pair has other extrinsics.
fn in_agreement(matcher: &Matcher, all: &[Rows]) -> usize {
    let rigs = all.iter().filter_map(|rows| matcher.rows(&rows.matches));
    let in_row = |rows: &Rows, rig: &_| matcher.in_row(&rows.matches, rig, rows.limit_px);
    let agree = |rig| all.iter().map(|rows| in_row(rows, &rig)).sum();
    rigs.map(agree).max().unwrap_or(0)
}
