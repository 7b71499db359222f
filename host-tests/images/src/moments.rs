//! Detects left and right images of different moments: a left image fits an earlier or later right image better.

use std::collections::VecDeque;
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

/// Largest row offset of a match that agrees with a rig, px of the image that was searched.
const IN_ROW_PX: f64 = 2.0;

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
        let of = |shift: isize| {
            let at = shift.unsigned_abs() + if shift < 0 { REACH } else { 0 };
            in_agreement(matcher, &all[at]) / all[at].len().max(1)
        };
        let reach = reach as isize;
        let matches = of(0);
        let others = (-reach..=reach).filter(|shift| *shift != 0).map(|shift| (shift, of(shift)));
        let best = others.max_by_key(|(_, shifted)| *shifted);
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

/// Matches of the left image of each pair and the right image of a later or earlier pair.
///
/// Shifts 0 to `REACH` come first, then -1 to -`REACH`. No more images are held at a time than a shift spans.
fn over_shifts(
    pairs: &[[Frame; 2]],
    matcher: &Matcher,
    reach: usize,
) -> [Vec<Rows>; 2 * REACH + 1] {
    let mut all = [const { Vec::new() }; 2 * REACH + 1];
    let mut last = VecDeque::new();
    for frames in pairs {
        let pictures = frames[0].picture().and_then(|left| Ok([left, frames[1].picture()?]));
        last.push_front(pictures.and_then(|[left, right]| matcher.views(&left, &right)).ok());
        last.truncate(reach + 1);
        let late = (0..last.len()).map(|shift| (shift, [shift, 0]));
        let early = (1..last.len()).map(|shift| (REACH + shift, [0, shift]));
        let of = |(at, [left, right]): (usize, [usize; 2])| {
            (at, rows(matcher, last[left].as_ref(), last[right].as_ref()))
        };
        let both: Vec<_> = late.chain(early).collect();
        let found: Vec<_> = both.into_par_iter().map(of).collect();
        for (at, rows) in found {
            all[at].push(rows);
        }
    }
    all
}

fn rows(matcher: &Matcher, left: Option<&[View; 2]>, right: Option<&[View; 2]>) -> Rows {
    match (left, right) {
        (Some([left, _]), Some([_, right])) => {
            Rows { matches: matcher.first([left, right]), limit_px: IN_ROW_PX * left.pixel() }
        }
        _ => Rows { matches: Vec::new(), limit_px: 0.0 },
    }
}

/// Number of matches of the first pairs that agree on a rig, under each of two sets of cameras.
///
/// # Errors
/// If the source cannot be read.
pub fn fits(source: &Source, matchers: [&Matcher; 2]) -> Result<[usize; 2]> {
    let pairs = first_pairs(source, LEAST)?;
    let of = |matcher: &Matcher| in_agreement(matcher, &over_shifts(&pairs, matcher, 0)[0]);
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
