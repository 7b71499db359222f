//! Detects left and right images of different moments: a left image fits an earlier or later right image better.

use std::ops::ControlFlow;

use anyhow::Result;
use rayon::prelude::*;
use rigs::data::Match;

use crate::matcher::Matcher;
use crate::source::{Frame, Item, Source};

/// Largest number of pairs examined.
const PAIRS: usize = 8;

/// Largest shift of left against right, pairs.
const REACH: usize = 2;

/// Least number of pairs for a result.
pub const LEAST: usize = 3;

/// Largest row offset of a match that agrees with a rig, px.
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
        let count = pairs.len() as isize;
        // A single pair always fits some rig, so the largest shift leaves at least two pairs.
        let reach = REACH.min(pairs.len() - 2) as isize;
        let of = |shift: isize| -> usize {
            let both = |left: isize| {
                let [l, r] = [left, left + shift].map(|i| usize::try_from(i).ok());
                Some((pairs.get(l?)?, pairs.get(r?)?))
            };
            let both: Vec<_> = (0..count).filter_map(both).collect();
            let matches = |(l, r): &(&[Frame; 2], &[Frame; 2])| matches(matcher, &l[0], &r[1]);
            let all: Vec<Vec<Match>> = both.par_iter().map(matches).collect();
            in_agreement(matcher, &all) / both.len().max(1)
        };
        let matches = of(0);
        let others = (-reach..=reach).filter(|shift| *shift != 0).map(|shift| (shift, of(shift)));
        let best = others.max_by_key(|(_, shifted)| *shifted);
        Ok(best.and_then(|(pairs, shifted)| {
            let clearly = shifted as f64 > CLEARLY * matches as f64;
            clearly.then_some(Self { pairs, matches, shifted })
        }))
    }
}

/// Number of matches of the first pairs that agree on a rig, under each of two sets of cameras.
///
/// # Errors
/// If the source cannot be read.
pub fn fits(source: &Source, matchers: [&Matcher; 2]) -> Result<[usize; 2]> {
    let pairs = first_pairs(source, LEAST)?;
    let of = |matcher: &Matcher| {
        let all: Vec<Vec<Match>> = pairs.par_iter().map(|[l, r]| matches(matcher, l, r)).collect();
        in_agreement(matcher, &all)
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

fn matches(matcher: &Matcher, left: &Frame, right: &Frame) -> Vec<Match> {
    let pictures = left.picture().and_then(|left| Ok([left, right.picture()?]));
    let Ok([left, right]) = pictures else { return Vec::new() };
    matcher.matches(&left, &right).map(|matched| matched.matches).unwrap_or_default()
}

/// Number of matches of all pairs in row under the extrinsics that were estimated from one of the pairs, for the best
/// choice of this pair. If the cameras move and left and right show different moments, each pair has other extrinsics.
fn in_agreement(matcher: &Matcher, all: &[Vec<Match>]) -> usize {
    let rigs = all.iter().filter_map(|matches| matcher.rows(matches));
    let agree = |rig| all.iter().map(|matches| matcher.in_row(matches, &rig, IN_ROW_PX)).sum();
    rigs.map(agree).max().unwrap_or(0)
}
