//! Left and right of different moments: does a left image fit an earlier or later right one better?

use std::ops::ControlFlow;

use anyhow::Result;
use host_tests::data::Match;
use rayon::prelude::*;

use crate::matcher::Matcher;
use crate::source::{Frame, Item, Source};

/// Pairs that are looked at.
const PAIRS: usize = 8;

/// How far left and right are shifted against each other, pairs.
const REACH: isize = 2;

/// A match this close to its row agrees, px.
const IN_ROW_PX: f64 = 2.0;

/// How many times more matches the better shift must have.
const CLEARLY: f64 = 1.5;

/// Left images fit right ones of other pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shift {
    /// Pairs that the right images come late; negative: early.
    pub pairs: isize,
    /// Matches of the pairs as they are.
    pub matches: usize,
    /// Matches after the shift.
    pub shifted: usize,
}

impl Shift {
    /// Compares shifts over the first pairs; `None` if the pairs as they are fit best, or are too few.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn look(source: &Source, matcher: &Matcher) -> Result<Option<Self>> {
        let mut pairs: Vec<[Frame; 2]> = Vec::new();
        source.read(&mut |item| {
            if let Item::Pair(pair) = item {
                pairs.push(pair);
            }
            if pairs.len() < PAIRS { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        let reach = REACH.unsigned_abs();
        if pairs.len() < 2 * reach + 1 {
            return Ok(None);
        }
        let lefts = reach..pairs.len() - reach;
        let of = |shift: isize| -> usize {
            let right = |left: usize| left.checked_add_signed(shift).unwrap_or(left);
            let matches = |left: usize| matches(matcher, &pairs[left][0], &pairs[right(left)][1]);
            let all: Vec<Vec<Match>> = lefts.clone().into_par_iter().map(matches).collect();
            in_agreement(matcher, &all)
        };
        let matches = of(0);
        let others = (-REACH..=REACH).filter(|shift| *shift != 0).map(|shift| (shift, of(shift)));
        let best = others.max_by_key(|(_, shifted)| *shifted);
        Ok(best.and_then(|(pairs, shifted)| {
            let clearly = shifted as f64 > CLEARLY * matches as f64;
            clearly.then_some(Self { pairs, matches, shifted })
        }))
    }
}

fn matches(matcher: &Matcher, left: &Frame, right: &Frame) -> Vec<Match> {
    let pictures = left.picture().and_then(|left| Ok([left, right.picture()?]));
    let Ok([left, right]) = pictures else { return Vec::new() };
    if left.size() != right.size() {
        return Vec::new();
    }
    matcher.matches(&left, &right).map(|matched| matched.matches).unwrap_or_default()
}

/// Matches of all pairs in row under the one pair's extrinsics that most agree with: a rig that moves with its
/// images of different moments has other extrinsics in each pair.
fn in_agreement(matcher: &Matcher, all: &[Vec<Match>]) -> usize {
    let rigs = all.iter().filter_map(|matches| matcher.rows(matches));
    let agree = |rig| all.iter().map(|matches| matcher.in_row(matches, &rig, IN_ROW_PX)).sum();
    rigs.map(agree).max().unwrap_or(0)
}
