//! Figures over the runs of one scene: errors, reported deviations, and the extrinsics in use.

use stereo_selfcal::State;
use stereo_selfcal::geometry::metrics::Deviation;

use super::real_rigs::{Claim, RealPair, RealRun};
use crate::stats::{mean, quantile, rms_deviation};

/// Numbers of pairs after which arming is counted, besides the last.
const ARMED_AT: [usize; 2] = [10, 50];

/// Figures after a number of pairs. Angles in rad; NaN without data.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Number of runs.
    pub runs: usize,
    /// Number of pairs of each run that the figures cover. "At the end" means after the last of them.
    pub pairs: usize,
    /// Number of runs with an estimate at the end.
    pub estimated: usize,
    /// Error of `t` at the end, median and worst.
    pub e_t: [f64; 2],
    /// Error of `R` at the end, median and worst.
    pub e_r: [f64; 2],
    /// RMS error at the end.
    pub rms: Deviation<f64>,
    /// RMS error of the joint fit of all true matches.
    pub joint_fit: Deviation<f64>,
    /// RMS of the Cramer-Rao bounds of all true matches.
    pub bound: Deviation<f64>,
    /// Reported standard deviation at the end, with the lens uncertain, median.
    pub sd: Deviation<f64>,
    /// Ratio of the error of `t` to its reported deviation at the end, 95th percentile and worst.
    pub t_in_sd: [f64; 2],
    /// Ratio of the error of `R` to its reported deviation at the end, 95th percentile and worst.
    pub r_in_sd: [f64; 2],
    /// Mean NEES (squared error normalised by the reported covariance) at the end, divided by its five degrees of
    /// freedom; 1 if the covariance is right.
    pub nees: f64,
    /// Number of runs locked at the end, and at any time.
    pub locked: [usize; 2],
    /// Shares of runs armed after 10 pairs, after 50 pairs, and at the end.
    pub armed: [f64; 3],
    /// Number of runs in which, after some pair, a locked estimate was off by more than 5 reported deviations.
    pub bad: usize,
    /// Shares of locked pairs, and of armed pairs, after which the estimate was off by more than 5 reported deviations.
    pub beyond: [f64; 2],
    /// Share of locked pairs after which the estimate was off by more than 3 of the deviations that are reported for
    /// exact lenses.
    pub beyond_3: f64,
    /// Reported vibration of `R` at the end, rad RMS: least, median and largest.
    pub vibration_r: [f64; 3],
    /// Reported vibration of the baseline at the end, rad RMS: least, median and largest.
    pub vibration_t: [f64; 3],
    /// Share of all pairs with a reported vibration.
    pub vibrating: f64,
    /// Error of `t` in use at the end, median and worst.
    pub in_use_t: [f64; 2],
    /// Error of `R` in use at the end, median and worst.
    pub in_use_r: [f64; 2],
    /// Largest ratio of the error of `t` in use at the end to the error of `t` at the start.
    pub in_use_growth: f64,
    /// RMS row offset over the last pair, with the calibration in use before the estimate is applied, px, median.
    pub in_use_px: f64,
}

impl Figures {
    /// Figures after the first `pairs` pairs of the runs. Joint fit and bound cover whole runs, so they are NaN if the
    /// runs are longer.
    #[must_use]
    pub fn after(runs: &[RealRun], pairs: usize) -> Self {
        let seen = || runs.iter().map(|run| &run.pairs[..pairs.min(run.pairs.len())]);
        let ends: Vec<&RealPair> = seen().filter_map(<[RealPair]>::last).collect();
        let claims: Vec<Claim> = ends.iter().filter_map(|pair| pair.claim).collect();
        let over = |of: fn(&Claim) -> f64| Numbers::of(claims.iter().map(of));
        let used = |of: fn(&RealPair) -> f64| Numbers::of(ends.iter().map(|pair| of(pair)));
        let whole = runs.iter().filter(|run| run.pairs.len() <= pairs);
        let locked = |pair: &RealPair| pair.state == State::Locked;
        let armed_at = |at: usize| {
            let at: Vec<&RealPair> =
                seen().filter_map(|pairs| pairs.get(at.checked_sub(1)?)).collect();
            share(at.iter().filter(|pair| pair.armed).count(), at.len())
        };
        let growth = runs.iter().zip(&ends);
        let growth = growth.map(|(run, end)| end.in_use.translation / run.start.translation);
        let of_vibration = |part: usize| {
            let numbers = Numbers::of(ends.iter().map(|pair| pair.vibration[part]));
            [numbers.quantile(0.0), numbers.median(), numbers.worst()]
        };
        let is_bad = |pairs: &&[RealPair]| pairs.iter().any(|pair| locked(pair) && beyond(pair));
        Self {
            runs: runs.len(),
            pairs,
            estimated: claims.len(),
            e_t: over(|claim| claim.error.translation).median_and_worst(),
            e_r: over(|claim| claim.error.rotation).median_and_worst(),
            rms: rms_deviation(claims.iter().map(|claim| claim.error)),
            joint_fit: rms_deviation(whole.clone().filter_map(|run| run.joint_fit)),
            bound: rms_deviation(whole.filter_map(|run| run.bound)),
            sd: Deviation {
                translation: over(|claim| claim.sd.translation).median(),
                rotation: over(|claim| claim.sd.rotation).median(),
            },
            t_in_sd: over(|claim| claim.error_in_sd().translation).p95_and_worst(),
            r_in_sd: over(|claim| claim.error_in_sd().rotation).p95_and_worst(),
            nees: over(|claim| claim.nees / 5.0).mean(),
            locked: [
                ends.iter().filter(|pair| locked(pair)).count(),
                seen().filter(|pairs| pairs.iter().any(locked)).count(),
            ],
            armed: [ARMED_AT[0], ARMED_AT[1], pairs].map(armed_at),
            bad: seen().filter(is_bad).count(),
            beyond: [
                share_beyond(seen().flatten().filter(|pair| locked(pair))),
                share_beyond(seen().flatten().filter(|pair| pair.armed)),
            ],
            vibration_r: of_vibration(0),
            vibration_t: of_vibration(1),
            vibrating: share(
                seen().flatten().filter(|pair| pair.vibration.iter().any(|rms| *rms > 0.0)).count(),
                seen().flatten().count(),
            ),
            beyond_3: {
                let all: Vec<f64> = seen()
                    .flatten()
                    .filter(|pair| locked(pair))
                    .filter_map(|pair| pair.claim)
                    .map(|Claim { error, sd_given: sd, .. }| {
                        (error.translation / sd.translation).max(error.rotation / sd.rotation)
                    })
                    .collect();
                share(all.iter().filter(|sd| **sd > 3.0).count(), all.len())
            },
            in_use_t: used(|pair| pair.in_use.translation).median_and_worst(),
            in_use_r: used(|pair| pair.in_use.rotation).median_and_worst(),
            in_use_growth: Numbers::of(growth).worst(),
            in_use_px: used(|pair| pair.rms_px.map_or(f64::NAN, |[px, _]| px)).median(),
        }
    }

    /// Ratios of the RMS error to that of the joint fit, of `t` and of `R`.
    #[must_use]
    pub fn over_joint_fit(&self) -> [f64; 2] {
        [
            self.rms.translation / self.joint_fit.translation,
            self.rms.rotation / self.joint_fit.rotation,
        ]
    }

    /// All figures with the names of their columns; angles in rad.
    #[must_use]
    pub fn columns(&self) -> Vec<(&'static str, f64)> {
        let count = |n: usize| u32::try_from(n).map_or(f64::NAN, f64::from);
        let [t_over_fit, r_over_fit] = self.over_joint_fit();
        vec![
            ("runs", count(self.runs)),
            ("pairs", count(self.pairs)),
            ("estimated", count(self.estimated)),
            ("e_t_median", self.e_t[0]),
            ("e_t_worst", self.e_t[1]),
            ("e_R_median", self.e_r[0]),
            ("e_R_worst", self.e_r[1]),
            ("e_t_rms", self.rms.translation),
            ("e_R_rms", self.rms.rotation),
            ("fit_t_rms", self.joint_fit.translation),
            ("fit_R_rms", self.joint_fit.rotation),
            ("e_t_over_fit", t_over_fit),
            ("e_R_over_fit", r_over_fit),
            ("bound_t", self.bound.translation),
            ("bound_R", self.bound.rotation),
            ("sd_t", self.sd.translation),
            ("sd_R", self.sd.rotation),
            ("t_in_sd_p95", self.t_in_sd[0]),
            ("t_in_sd_worst", self.t_in_sd[1]),
            ("R_in_sd_p95", self.r_in_sd[0]),
            ("R_in_sd_worst", self.r_in_sd[1]),
            ("nees_over_5", self.nees),
            ("locked_at_end", count(self.locked[0])),
            ("locked_ever", count(self.locked[1])),
            ("armed_at_10", self.armed[0]),
            ("armed_at_50", self.armed[1]),
            ("armed_at_end", self.armed[2]),
            ("bad", count(self.bad)),
            ("locked_beyond_5_sd", self.beyond[0]),
            ("armed_beyond_5_sd", self.beyond[1]),
            ("locked_beyond_3_sd", self.beyond_3),
            ("vibration_R_least", self.vibration_r[0]),
            ("vibration_R_median", self.vibration_r[1]),
            ("vibration_R_most", self.vibration_r[2]),
            ("vibration_t_least", self.vibration_t[0]),
            ("vibration_t_median", self.vibration_t[1]),
            ("vibration_t_most", self.vibration_t[2]),
            ("vibrating_pairs", self.vibrating),
            ("in_use_t_median", self.in_use_t[0]),
            ("in_use_t_worst", self.in_use_t[1]),
            ("in_use_R_median", self.in_use_r[0]),
            ("in_use_R_worst", self.in_use_r[1]),
            ("in_use_t_over_start_worst", self.in_use_growth),
            ("in_use_rms_px", self.in_use_px),
        ]
    }
}

/// Whether the estimate after the pair is off by more than 5 reported deviations.
fn beyond(pair: &RealPair) -> bool {
    pair.claim.is_some_and(|claim| claim.is_overconfident())
}

fn share_beyond<'a>(pairs: impl Iterator<Item = &'a RealPair>) -> f64 {
    let pairs: Vec<&RealPair> = pairs.collect();
    share(pairs.iter().filter(|pair| beyond(pair)).count(), pairs.len())
}

/// Part over whole; NaN for an empty whole.
fn share(part: usize, whole: usize) -> f64 {
    let count = |n: usize| u32::try_from(n).map_or(f64::NAN, f64::from);
    count(part) / count(whole)
}

/// Numbers without NaN; every figure is NaN if none remains.
struct Numbers(Vec<f64>);

impl Numbers {
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        Self(numbers.filter(|number| !number.is_nan()).collect())
    }

    fn quantile(&self, share: f64) -> f64 {
        quantile(self.0.iter().copied(), share).unwrap_or(f64::NAN)
    }

    fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    fn worst(&self) -> f64 {
        self.quantile(1.0)
    }

    fn median_and_worst(&self) -> [f64; 2] {
        [self.median(), self.worst()]
    }

    fn p95_and_worst(&self) -> [f64; 2] {
        [self.quantile(0.95), self.worst()]
    }

    fn mean(&self) -> f64 {
        mean(self.0.iter().copied()).unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pair with these errors of `t` and `R`, rad, and reported deviations of 1 mrad.
    fn pair(state: State, armed: bool, e_t: f64, e_r: f64) -> RealPair {
        let deviation = |translation: f64, rotation: f64| Deviation { translation, rotation };
        let [error, sd] = [deviation(e_t, e_r), deviation(1e-3, 1e-3)];
        let claim = Some(Claim { error, sd, sd_given: sd, nees: 10.0 });
        RealPair {
            state,
            fused: true,
            armed,
            claim,
            in_use: error,
            rms_px: Some([0.5, 0.4]),
            vibration: [0.0; 2],
        }
    }

    fn run(pairs: Vec<RealPair>) -> RealRun {
        let fit = Deviation { translation: 5e-4, rotation: 5e-4 };
        let start = Deviation { translation: 2e-3, rotation: 1e-3 };
        RealRun { pairs, start, joint_fit: Some(fit), bound: Some(fit) }
    }

    #[test]
    fn locked_and_armed_pairs_with_too_small_deviations_are_counted() {
        let good = pair(State::Locked, true, 1e-3, 1e-3);
        let bad = pair(State::Locked, false, 1e-3, 6e-3);
        let early = pair(State::Acquiring, false, 9e-3, 1e-3);
        let runs = [run(vec![early, good, good]), run(vec![early, bad, good])];
        let figures = Figures::after(&runs, 3);
        assert_eq!((figures.bad, figures.locked), (1, [2, 2]));
        assert!(figures.armed[0].is_nan());
        let [t, r] = figures.over_joint_fit();
        let found =
            [figures.beyond[0], figures.beyond[1], t, r, figures.nees, figures.in_use_growth];
        for (found, expected) in found.into_iter().zip([0.25, 0.0, 2.0, 2.0, 2.0, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        }
        let earlier = Figures::after(&runs, 2);
        assert!(earlier.joint_fit.rotation.is_nan());
        assert!((earlier.armed[2] - 0.5).abs() < 1e-12 && (earlier.e_r[1] - 6e-3).abs() < 1e-12);
    }
}
