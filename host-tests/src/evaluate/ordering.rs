//! Does the order of the paper hold: ours no worse than the paper's method, that no worse than \[7\]?
//!
//! Nothing is compared below the standard error of the reference. Where the order does not hold, the
//! reason is looked for in the data, in a fixed order, and where none is found it says so.

use std::fmt;

use anyhow::Result;

use super::jackknife::{Jackknife, sd_of_difference};
use super::recorded::{Pair, Row};
use super::runner::{Measured, Runner};
use crate::rivals::Method;

/// Names of the methods in order, the best expected first.
pub const ORDER: [&str; 3] = ["robust", "paper", "ling-shen"];

/// A difference below so many of its standard deviations is chance: 5 % of a normal variable.
const SIGNIFICANT: f64 = 2.0;

/// The order says something of single pairs from so many on.
const MANY_PAIRS: usize = 5;

/// Why one method is not better than another where it was expected to be, all in rad.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// The difference is below the standard error of the reference.
    Reference {
        /// That error.
        sd: f64,
    },
    /// The difference is what leaving out parts of the data makes of it.
    Chance {
        /// Its standard deviation.
        sd: f64,
    },
    /// The data, all wrong matches taken out by the reference, are that far from the reference.
    Data {
        /// How far.
        error: f64,
    },
    /// Pair by pair the order holds: what errs more in each pair happens to cancel over these.
    SinglePairs {
        /// RMS over single pairs of the two methods.
        sigma: [f64; 2],
    },
    /// None of these.
    Unexplained,
}

/// One step of the order that does not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Exception {
    /// Expected to be the better, and the worse.
    pub methods: [&'static str; 2],
    /// Their errors, rad.
    pub errors: [f64; 2],
    /// Why.
    pub reason: Reason,
}

/// One data set, view and error.
pub struct Judged<'a> {
    /// Data set and view.
    pub row: &'a Row<'a>,
    /// 0: `e_t`, 1: `e_theta`.
    pub part: usize,
    /// Errors of the methods of [`ORDER`], rad; `None` where one has none.
    pub errors: Option<[f64; 3]>,
    /// Steps of the order that do not hold.
    pub exceptions: Vec<Exception>,
}

impl Judged<'_> {
    /// Whether the order holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.errors.is_some() && self.exceptions.is_empty()
    }

    /// Whether it does not, and nobody knows why.
    #[must_use]
    pub fn is_unexplained(&self) -> bool {
        let unexplained = |e: &Exception| e.reason == Reason::Unexplained;
        self.errors.is_none() || self.exceptions.iter().any(unexplained)
    }
}

/// Judges all rows that are evidence.
///
/// # Errors
/// If an outcome cannot be kept.
pub fn judge<'a>(
    runner: &Runner<'_>,
    rows: &'a [Row<'a>],
    methods: &[Box<dyn Method>],
) -> Result<Vec<Judged<'a>>> {
    let Some(places) = places(methods) else { return Ok(Vec::new()) };
    let mut judged = Vec::new();
    for row in rows.iter().filter(|row| row.look.is_evidence()) {
        let jackknives = if ordered(row, places) {
            None
        } else {
            let of = |place: usize| Jackknife::new(row.set, row.look, methods[place].as_ref());
            Some(runner.run(&places.map(of))?)
        };
        judged.extend([0, 1].map(|part| judge_part(row, places, part, jackknives.as_deref())));
    }
    Ok(judged)
}

/// Where the methods of [`ORDER`] stand among all.
fn places(methods: &[Box<dyn Method>]) -> Option<[usize; 3]> {
    let place = |name| methods.iter().position(|method| method.name() == name);
    let [a, b, c] = ORDER.map(place);
    Some([a?, b?, c?])
}

fn errors_of(row: &Row<'_>, places: [usize; 3]) -> Option<[Pair; 3]> {
    let of = |place: usize| row.errors[place].as_ref().ok().map(|errors| errors.fused);
    let [a, b, c] = places.map(of);
    Some([a?, b?, c?])
}

fn ordered(row: &Row<'_>, places: [usize; 3]) -> bool {
    errors_of(row, places)
        .is_none_or(|[a, b, c]| [0, 1].iter().all(|&part| a[part] <= b[part] && b[part] <= c[part]))
}

fn judge_part<'a>(
    row: &'a Row<'a>,
    places: [usize; 3],
    part: usize,
    jackknives: Option<&[Measured<Vec<Pair>>]>,
) -> Judged<'a> {
    let errors = errors_of(row, places).map(|errors| errors.map(|pair| pair[part]));
    let step = |[a, b]: [usize; 2]| {
        let [better, worse] = [errors?[a], errors?[b]];
        let sd = jackknives.and_then(|all| sd_of_difference(&all[a], &all[b]));
        (better > worse).then(|| Exception {
            methods: [ORDER[a], ORDER[b]],
            errors: [better, worse],
            reason: reason(row, [places[a], places[b]], part, better - worse, sd),
        })
    };
    let exceptions = [[0, 1], [1, 2]].into_iter().filter_map(step).collect();
    Judged { row, part, errors, exceptions }
}

fn reason(
    row: &Row<'_>,
    places: [usize; 2],
    part: usize,
    difference: f64,
    sd: Option<Pair>,
) -> Reason {
    let reference = row.set.reference.map(|r| [r.translation, r.rotation][part]);
    if let Some(sd) = reference.filter(|&sd| difference <= sd) {
        return Reason::Reference { sd };
    }
    if let Some(sd) = sd.map(|sd| sd[part]).filter(|&sd| difference <= SIGNIFICANT * sd) {
        return Reason::Chance { sd };
    }
    if let Some(error) =
        row.data_optimum.as_ref().ok().map(|e| e[part]).filter(|&e| difference <= e)
    {
        return Reason::Data { error };
    }
    let errors = places.map(|place| row.errors[place].as_ref().ok());
    let sigma = errors.map(|errors| Some(errors?.sigma()?[part]));
    let many = row.look.pairs.len() >= MANY_PAIRS;
    if let ([Some(better), Some(worse)], true) = (sigma, many) {
        if better <= worse {
            return Reason::SinglePairs { sigma: [better, worse] };
        }
    }
    Reason::Unexplained
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference { sd } => write!(f, "below the reference's own error, {sd:.4}"),
            Self::Chance { sd } => {
                write!(f, "chance: parts of the data left out move it by {sd:.4} (1 sd)")
            }
            Self::Data { error } => {
                write!(f, "the true matches themselves are {error:.4} off the reference")
            }
            Self::SinglePairs { sigma: [better, worse] } => {
                write!(f, "pair by pair the order holds, {better:.4} to {worse:.4} RMS")
            }
            Self::Unexplained => f.write_str("unexplained"),
        }
    }
}

impl fmt::Display for Exception {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { methods: [a, b], errors: [better, worse], reason } = self;
        write!(f, "{a} {better:.4} over {b} {worse:.4}, by {:.4}: {reason}", better - worse)
    }
}
