//! Does the order of the paper hold: ours no worse than the paper's method, that no worse than \[7\]?
//!
//! A method without an estimate is worse than any. Nothing is compared below the standard error of the
//! reference. Where the order does not hold, the
//! reason is searched in the data, in a fixed order; if there is none, the check is unexplained.

use std::fmt;

use anyhow::Result;

use super::jackknife::{Jackknife, sd_of_difference};
use super::measurement::{Measured, Runner};
use super::on_recorded::{ErrorPair, Row};
use crate::baselines::Method;

/// Names of the methods in order, the best expected first.
pub const ORDER: [&str; 3] = ["robust", "paper", "ling-shen"];

/// A difference below so many of its standard deviations is chance: 5 % of a normal variable.
const SIGNIFICANT: f64 = 2.0;

/// Fewest pairs for an order of single pairs.
const MANY_PAIRS: usize = 5;

/// Why one method is not better than another where it was expected to be, all in rad.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// The difference is below the standard error of the reference.
    Reference {
        /// That error.
        sd: f64,
    },
    /// The difference is within the jackknife's standard deviation of it.
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
pub struct Violation {
    /// Expected to be the better, and the worse.
    pub methods: [&'static str; 2],
    /// Their errors, rad.
    pub errors: [f64; 2],
    /// Why.
    pub reason: Reason,
}

/// One data set, view and error.
pub struct OrderCheck<'a> {
    /// Data set and view.
    pub row: &'a Row<'a>,
    /// 0: `e_t`, 1: `e_theta`.
    pub part: usize,
    /// Errors of the methods of [`ORDER`], rad; infinite where one has no estimate.
    pub errors: [f64; 3],
    /// Steps of the order that do not hold.
    pub violations: Vec<Violation>,
}

impl OrderCheck<'_> {
    /// Whether the order holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.violations.is_empty()
    }

    /// Whether it does not hold, without a reason.
    #[must_use]
    pub fn is_unexplained(&self) -> bool {
        self.violations.iter().any(|violation| violation.reason == Reason::Unexplained)
    }
}

/// Checks all rows that are evidence.
///
/// # Errors
/// If the cache cannot be written.
pub fn check<'a>(
    runner: &Runner<'_>,
    rows: &'a [Row<'a>],
    methods: &[Box<dyn Method>],
) -> Result<Vec<OrderCheck<'a>>> {
    let Some(places) = places(methods) else { return Ok(Vec::new()) };
    let mut checks = Vec::new();
    for row in rows.iter().filter(|row| row.seen.is_evidence()) {
        let jackknives = if ordered(row, places) {
            None
        } else {
            let of = |place: usize| Jackknife::new(row.set, row.seen, methods[place].as_ref());
            Some(runner.run(&places.map(of))?)
        };
        checks.extend([0, 1].map(|part| check_part(row, places, part, jackknives.as_deref())));
    }
    Ok(checks)
}

/// Where the methods of [`ORDER`] stand among all.
fn places(methods: &[Box<dyn Method>]) -> Option<[usize; 3]> {
    let place = |name| methods.iter().position(|method| method.name() == name);
    let [a, b, c] = ORDER.map(place);
    Some([a?, b?, c?])
}

/// No estimate is worse than any.
fn errors_of(row: &Row<'_>, places: [usize; 3]) -> [ErrorPair; 3] {
    places.map(|place| row.errors[place].as_ref().map_or([f64::INFINITY; 2], |e| e.fused))
}

fn ordered(row: &Row<'_>, places: [usize; 3]) -> bool {
    let [a, b, c] = errors_of(row, places);
    [0, 1].iter().all(|&part| a[part] <= b[part] && b[part] <= c[part])
}

fn check_part<'a>(
    row: &'a Row<'a>,
    places: [usize; 3],
    part: usize,
    jackknives: Option<&[Measured<Vec<ErrorPair>>]>,
) -> OrderCheck<'a> {
    let errors = errors_of(row, places).map(|pair| pair[part]);
    let step = |[a, b]: [usize; 2]| {
        let [better, worse] = [errors[a], errors[b]];
        let sd = jackknives.and_then(|all| sd_of_difference(&all[a], &all[b]));
        (better > worse).then(|| Violation {
            methods: [ORDER[a], ORDER[b]],
            errors: [better, worse],
            reason: reason(row, [places[a], places[b]], part, better - worse, sd),
        })
    };
    let violations = [[0, 1], [1, 2]].into_iter().filter_map(step).collect();
    OrderCheck { row, part, errors, violations }
}

fn reason(
    row: &Row<'_>,
    places: [usize; 2],
    part: usize,
    difference: f64,
    sd: Option<ErrorPair>,
) -> Reason {
    if difference.is_infinite() {
        return Reason::Unexplained;
    }
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
    let many = row.seen.pairs.len() >= MANY_PAIRS;
    match sigma {
        [Some(better), Some(worse)] if many && better <= worse => {
            Reason::SinglePairs { sigma: [better, worse] }
        }
        _ => Reason::Unexplained,
    }
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

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { methods: [a, b], errors: [better, worse], reason } = self;
        write!(f, "{a} over {b} by {:.4}: {reason}", better - worse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::on_recorded::Errors;
    use crate::evidence::recorded_sets::RecordedSet;
    use crate::synth::Scene;
    use stereo_selfcal::metrics::Deviation;

    /// Reference error, and the data's own, of the fabricated rows, rad.
    const REFERENCE: f64 = 0.001;
    const DATA: f64 = 0.05;

    fn recording() -> RecordedSet {
        let set = Scene { matches: 20, ..Scene::default() }.dataset(6, 1).unwrap();
        let reference = Some(Deviation { translation: REFERENCE, rotation: REFERENCE });
        RecordedSet { reference, ..RecordedSet::new(&set).unwrap() }
    }

    /// `e_t` of the methods of [`ORDER`], fused and RMS over six single pairs.
    fn row(set: &RecordedSet, errors: [(Option<f64>, f64); 3]) -> Row<'_> {
        let of = |(fused, single): (Option<f64>, f64)| match fused {
            Some(fused) => Ok(Errors { fused: [fused, 0.0], single: vec![Some([single, 0.0]); 6] }),
            None => Err("no estimate".into()),
        };
        let seen = &set.views[1];
        Row { set, seen, errors: errors.map(of).to_vec(), data_optimum: Ok([DATA, 0.0]) }
    }

    /// Jackknives whose differences of `e_t` have this standard deviation for two groups.
    fn jackknives(sd: f64) -> Vec<Measured<Vec<ErrorPair>>> {
        let of = |sign: f64| Ok(vec![[sign * sd, 0.0], [-sign * sd, 0.0]]);
        vec![of(0.5), of(-0.5), of(0.5)]
    }

    fn reasons(errors: [(Option<f64>, f64); 3], sd: f64) -> Vec<Reason> {
        let set = recording();
        let row = row(&set, errors);
        let checks = check_part(&row, [0, 1, 2], 0, Some(&jackknives(sd)));
        checks.violations.into_iter().map(|violation| violation.reason).collect()
    }

    fn errors(fused: [f64; 3]) -> [(Option<f64>, f64); 3] {
        // Single pairs against the order, so that they explain nothing.
        let [a, b, c] = fused;
        [(Some(a), 3.0), (Some(b), 2.0), (Some(c), 1.0)]
    }

    #[test]
    fn an_order_that_holds_needs_no_reason() {
        assert_eq!(reasons(errors([0.01, 0.02, 0.02]), 0.0), []);
    }

    #[test]
    fn reasons_are_found_in_their_order_and_only_where_they_hold() {
        let step = |difference: f64| errors([0.1 + difference, 0.1, 0.2]);
        assert_eq!(reasons(step(0.0009), 1.0), [Reason::Reference { sd: REFERENCE }]);
        let chance = reasons(step(0.06), 0.031);
        assert!(matches!(chance[..], [Reason::Chance { .. }]), "{chance:?}");
        assert_eq!(reasons(step(0.04), 0.0), [Reason::Data { error: DATA }]);
        assert_eq!(reasons(step(0.06), 0.0), [Reason::Unexplained]);
        let single = [(Some(0.2), 0.3), (Some(0.1), 0.4), (Some(0.3), 0.5)];
        assert_eq!(reasons(single, 0.0), [Reason::SinglePairs { sigma: [0.3, 0.4] }]);
    }

    #[test]
    fn both_steps_of_the_order_are_checked() {
        assert_eq!(reasons(errors([0.5, 0.3, 0.1]), 0.0), [const { Reason::Unexplained }; 2]);
    }

    #[test]
    fn no_estimate_is_worse_than_any_and_nothing_excuses_it() {
        let none = |a, b, c| [(a, 1.0), (b, 2.0), (c, 3.0)];
        assert_eq!(reasons(none(Some(0.1), None, None), 0.0), []);
        assert_eq!(reasons(none(None, Some(9.0), Some(9.0)), 0.0), [Reason::Unexplained]);
    }
}
