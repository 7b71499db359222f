//! Jackknife: the change of an error when a part of the data is left out.
//!
//! The delete-a-group jackknife: with `g` groups and the errors `e_i` without group `i`, the variance
//! of a difference of two methods' errors is `(g - 1) / g * sum (d_i - mean d)^2`. Both methods leave
//! out the same groups, so that common errors cancel.

use anyhow::{Context, Result};
use serde::Serialize;

use super::measurement::{Measured, Measurement};
use super::on_recorded::{ErrorPair, error_pair};
use super::recorded_sets::{RecordedSet, SetView, TURN_DEG};
use crate::baselines::Method;
use crate::data::Rays;

/// Groups at most.
const GROUPS: usize = 12;

/// From so many pairs on, pairs are left out; below, matches.
const MANY_PAIRS: usize = 5;

/// Errors of one method without each group in turn.
#[derive(Serialize)]
pub struct Jackknife<'a> {
    set: &'a str,
    digest: &'a str,
    view: &'static str,
    degrees: f64,
    groups: usize,
    method: &'static str,
    #[serde(skip)]
    seen: &'a SetView,
    #[serde(skip)]
    by: &'a dyn Method,
}

impl<'a> Jackknife<'a> {
    /// A measurement of a method on a data set, from one of its views.
    #[must_use]
    pub fn new(set: &'a RecordedSet, seen: &'a SetView, by: &'a dyn Method) -> Self {
        let groups = if by_pairs(&seen.pairs) { seen.pairs.len().min(GROUPS) } else { GROUPS };
        Self {
            set: &set.name,
            digest: &set.digest,
            view: seen.view,
            degrees: TURN_DEG,
            groups,
            method: by.name(),
            seen,
            by,
        }
    }
}

impl Measurement for Jackknife<'_> {
    type Outcome = Vec<ErrorPair>;
    const KIND: &'static str = "jackknife";

    fn label(&self) -> String {
        format!("{} on parts of {}, {}", self.method, self.set, self.view)
    }

    fn measure(&self) -> Result<Vec<ErrorPair>> {
        let without = |group: usize| {
            let left = without(&self.seen.pairs, group, self.groups);
            let estimate = self.by.fused(&left, &self.seen.setting);
            let estimate = estimate.with_context(|| format!("no estimate without part {group}"))?;
            Ok(error_pair(self.seen.error(&estimate)))
        };
        (0..self.groups).map(without).collect()
    }
}

fn by_pairs(pairs: &[Vec<Rays>]) -> bool {
    pairs.len() >= MANY_PAIRS
}

/// All but one group: consecutive pairs, as neighbours resemble each other, or every so-manyth match.
fn without(pairs: &[Vec<Rays>], group: usize, groups: usize) -> Vec<Vec<Rays>> {
    if by_pairs(pairs) {
        let [from, to] = [group, group + 1].map(|i| i * pairs.len() / groups);
        return [&pairs[..from], &pairs[to..]].concat();
    }
    let kept = |rays: &Vec<Rays>| {
        let numbered = rays.iter().enumerate().filter(|(i, _)| i % groups != group);
        numbered.map(|(_, rays)| *rays).collect()
    };
    pairs.iter().map(kept).collect()
}

/// Standard deviations of the differences of `e_t` and of `e_theta` between two methods, rad.
#[must_use]
pub fn sd_of_difference(
    a: &Measured<Vec<ErrorPair>>,
    b: &Measured<Vec<ErrorPair>>,
) -> Option<ErrorPair> {
    let (a, b) = (a.as_ref().ok()?, b.as_ref().ok()?);
    let groups = f64::from(u32::try_from(a.len().min(b.len())).ok()?);
    let of = |part: usize| {
        let differences = || a.iter().zip(b).map(|(a, b)| a[part] - b[part]);
        let mean = differences().sum::<f64>() / groups;
        let squares: f64 = differences().map(|d| (d - mean) * (d - mean)).sum();
        ((groups - 1.0) / groups * squares).sqrt()
    };
    (groups > 1.0).then(|| [of(0), of(1)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn match_at(x: f64) -> Rays {
        [Vector3::new(x, 0.0, 1.0); 2]
    }

    #[test]
    fn every_pair_or_match_is_left_out_once() {
        let many: Vec<Vec<Rays>> = (0..25).map(|i| vec![match_at(f64::from(i))]).collect();
        let left: usize = (0..12).map(|g| without(&many, g, 12).len()).sum();
        assert_eq!(left, 11 * 25);
        let one = vec![many.concat()];
        let left: usize = (0..12).map(|g| without(&one, g, 12)[0].len()).sum();
        assert_eq!(left, 11 * 25);
    }

    #[test]
    fn the_deviation_of_a_mean_is_that_of_the_textbook() {
        // Means of 1..=6 without one of them: the standard error of the mean is sqrt(3.5 / 6).
        let means: Vec<ErrorPair> =
            (1..=6).map(|left| [(21.0 - f64::from(left)) / 5.0, 0.0]).collect();
        let sd = sd_of_difference(&Ok(means), &Ok(vec![[0.0; 2]; 6])).unwrap();
        assert!((sd[0] - (3.5_f64 / 6.0).sqrt()).abs() < 1e-12 && sd[1] < 1e-12, "{sd:?}");
    }
}
