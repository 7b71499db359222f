//! Figures of the runs of a case, each with its chance.

use sim::run::monte_carlo::{AfterPair, Run};
use sim::stats::{mean, quantile, rms, rms_deviation};
use sim::synth::{Grid, Scenario};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Fused, State};

use super::chance::Chance;

/// A figure of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Figure {
    /// Its column.
    pub(crate) name: &'static str,
    /// Angles in rad; NaN without data.
    pub(crate) value: f64,
    /// How far another campaign may be from it by chance.
    pub(crate) chance: Chance,
}

/// A single pair counts as solved if its error is below so many bounds.
const NEAR: f64 = 4.0;

/// A pair does not fit the extrinsics in use below this share.
const UNFIT: f64 = 0.5;

/// Pairs at the start of a run, before the yaw in use counts.
const AT_START: usize = 50;

/// An error is overconfident above so many reported deviations.
const TOO_MANY_SD: f64 = 5.0;

/// All figures after the first `pairs` pairs of the runs. Joint fit and bound cover whole runs, so they are NaN if the
/// runs are longer.
pub(super) fn all(runs: &[Run], scenario: &Scenario, pairs: usize) -> Vec<Figure> {
    let seen = runs.iter().map(|run| &run.pairs[..pairs.min(run.pairs.len())]).collect();
    let of = Of { runs, seen, pairs };
    [
        of.errors(scenario),
        of.alone(),
        of.deviations(),
        of.locks(),
        of.armed(),
        of.in_use(),
        of.passes(),
        of.changes(scenario.turned_from()),
        of.yaw_in_use(),
    ]
    .concat()
}

/// Runs, and what was seen of each.
struct Of<'a> {
    runs: &'a [Run],
    seen: Vec<&'a [Option<AfterPair>]>,
    pairs: usize,
}

pub(super) fn count(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::NAN, f64::from)
}

pub(super) fn counted(name: &'static str, n: usize) -> Figure {
    Figure { name, value: count(n), chance: Chance::Count }
}

pub(super) fn shared(name: &'static str, [part, whole]: [usize; 2]) -> Figure {
    let [part, whole] = [part, whole].map(count);
    Figure { name, value: part / whole, chance: Chance::Share(whole) }
}

pub(super) fn quantile_of(
    name: &'static str,
    share: f64,
    numbers: impl IntoIterator<Item = f64>,
    runs: usize,
) -> Figure {
    let known = numbers.into_iter().filter(|number| !number.is_nan());
    let extreme = !(0.01..0.99).contains(&share);
    let chance = if extreme { Chance::worst(runs) } else { Chance::quantile(runs) };
    Figure { name, value: quantile(known, share).unwrap_or(f64::NAN), chance }
}

impl<'a> Of<'a> {
    /// The estimates at the end.
    fn ends(&self) -> impl Iterator<Item = &'a AfterPair> + Clone {
        self.seen.iter().filter_map(|pairs| pairs.last()?.as_ref())
    }

    fn rms(&self, name: &'static str, value: f64) -> Figure {
        Figure { name, value, chance: Chance::rms(self.runs.len()) }
    }

    fn quantile(&self, name: &'static str, share: f64, of: impl Fn(&AfterPair) -> f64) -> Figure {
        quantile_of(name, share, self.ends().map(of), self.runs.len())
    }

    fn share(&self, name: &'static str, part: usize) -> Figure {
        shared(name, [part, self.runs.len()])
    }

    /// Errors at the end, over the joint fit and over the bound of noise and rounding.
    fn errors(&self, scenario: &Scenario) -> Vec<Figure> {
        let whole = || self.runs.iter().filter(|run| run.pairs.len() <= self.pairs);
        let e = rms_deviation(self.ends().map(|m| m.error));
        let fit = rms_deviation(whole().filter_map(|run| run.joint_fit));
        let bound = rms_deviation(whole().filter_map(|run| run.bound));
        let rounded = rounded_px(scenario) / scenario.scene.noise_px;
        let nees = mean(self.ends().map(|m| m.nees)).unwrap_or(f64::NAN);
        vec![
            counted("runs", self.runs.len()),
            self.rms("e_t", e.translation),
            self.rms("e_R", e.rotation),
            self.quantile("e_t median", 0.5, |m| m.error.translation),
            self.quantile("e_t worst", 1.0, |m| m.error.translation),
            self.quantile("e_R median", 0.5, |m| m.error.rotation),
            self.quantile("e_R worst", 1.0, |m| m.error.rotation),
            self.rms("e_t over joint fit", e.translation / fit.translation),
            self.rms("e_R over joint fit", e.rotation / fit.rotation),
            self.rms("bound t", bound.translation),
            self.rms("bound R", bound.rotation),
            self.rms("e_t over bound", e.translation / bound.translation / rounded),
            self.rms("e_R over bound", e.rotation / bound.rotation / rounded),
            Figure { name: "NEES", value: nees, chance: Chance::nees(self.runs.len()) },
        ]
    }

    /// Runs near the bound, which campaigns of single pairs show.
    fn alone(&self) -> Vec<Figure> {
        let near = |run: &&&Run| {
            let found = run.last().zip(run.bound);
            found.is_some_and(|(m, bound)| {
                m.error.translation < NEAR * bound.translation
                    && m.error.rotation < NEAR * bound.rotation
            })
        };
        let runs: Vec<&Run> = self.runs.iter().collect();
        let good: Vec<&&Run> = runs.iter().filter(near).collect();
        let none = runs.iter().filter(|run| run.last().is_none()).count();
        let e = rms_deviation(good.iter().filter_map(|run| run.last()).map(|m| m.error));
        let bound = rms_deviation(good.iter().filter_map(|run| run.bound));
        vec![
            self.rms("sigma_t over bound", e.translation / bound.translation),
            self.rms("sigma_R over bound", e.rotation / bound.rotation),
            self.share("within 4 bounds", good.len()),
            self.share("wrong", runs.len() - good.len() - none),
            self.share("no estimate", none),
        ]
    }

    /// Reported deviations and vibration at the end, and the errors over them.
    fn deviations(&self) -> Vec<Figure> {
        vec![
            self.quantile("sd t", 0.5, |m| m.sd.translation),
            self.quantile("sd R", 0.5, |m| m.sd.rotation),
            self.quantile("e_t over sd 95 %", 0.95, |m| m.in_sd()[0]),
            self.quantile("e_t over sd worst", 1.0, |m| m.in_sd()[0]),
            self.quantile("e_R over sd 95 %", 0.95, |m| m.in_sd()[1]),
            self.quantile("e_R over sd worst", 1.0, |m| m.in_sd()[1]),
            self.quantile("vibration R least", 0.0, |m| m.vibration[0]),
            self.quantile("vibration R most", 1.0, |m| m.vibration[0]),
            self.quantile("vibration t most", 1.0, |m| m.vibration[1]),
        ]
    }

    /// Locked runs and pairs, and those beyond 5 reported deviations.
    fn locks(&self) -> Vec<Figure> {
        let locked = |m: &&AfterPair| m.state == State::Locked;
        let beyond = |m: &AfterPair| m.error_in_sd > TOO_MANY_SD;
        let beyond_lens = |m: &AfterPair| m.in_sd().into_iter().any(|sd| sd > TOO_MANY_SD);
        let pairs = || self.seen.iter().map(|pairs| pairs.iter().flatten().filter(locked));
        let first = |pairs: &&[Option<AfterPair>]| {
            pairs.iter().position(|m| m.as_ref().is_some_and(|m| locked(&m)))
        };
        let locks: Vec<usize> = self.seen.iter().filter_map(first).collect();
        let at_lock = pairs().filter_map(|mut locked| locked.next());
        vec![
            self.share("locked", self.ends().filter(locked).count()),
            self.share("ever locked", locks.len()),
            quantile_of(
                "all locked by pair",
                1.0,
                locks.iter().map(|at| count(at + 1)),
                self.runs.len(),
            ),
            counted("locked pairs", pairs().flatten().count()),
            counted("pairs beyond 5 sd", pairs().flatten().filter(|m| beyond(m)).count()),
            counted("locks beyond 5 sd", at_lock.filter(|m| beyond(m)).count()),
            counted(
                "runs beyond 5 sd",
                pairs().filter_map(|mut m| m.find(|m| beyond_lens(m))).count(),
            ),
        ]
    }

    /// Shares of runs armed after 10 and 50 pairs and at the end; NaN if the runs are shorter. Armed pairs that, like the
    /// pair before them, fit the extrinsics in use with less than half of what fits the pair itself.
    fn armed(&self) -> Vec<Figure> {
        let after = |name, at: usize| {
            let reached: Vec<_> =
                self.seen.iter().filter_map(|pairs| pairs.get(at.checked_sub(1)?)).collect();
            let armed = reached.iter().filter(|m| m.is_some_and(|m| m.armed)).count();
            shared(name, [armed, reached.len()])
        };
        let unfit = |m: &Option<AfterPair>| m.is_some_and(|m| m.coverage < UNFIT);
        let armed_unfit =
            |two: &&[Option<AfterPair>]| two.iter().all(unfit) && two[1].is_some_and(|m| m.armed);
        let armed_unfit = self.seen.iter().flat_map(|pairs| pairs.windows(2)).filter(armed_unfit);
        vec![
            after("armed at 10", 10),
            after("armed at 50", 50),
            after("armed", self.pairs),
            counted("armed unfit", armed_unfit.count()),
        ]
    }

    /// The calibration in use at the end.
    fn in_use(&self) -> Vec<Figure> {
        let used: Vec<(Deviation<f64>, &Run)> = self
            .seen
            .iter()
            .zip(self.runs)
            .map(|(pairs, run)| {
                let last = pairs.last().copied().flatten();
                (last.map_or(run.start, |m| m.in_use), run)
            })
            .collect();
        let e = rms_deviation(used.iter().map(|(e, _)| *e));
        let growth = used.iter().map(|(e, run)| e.translation / run.start.translation);
        vec![
            self.rms("e_t in use", e.translation),
            self.rms("e_R in use", e.rotation),
            quantile_of("e_t in use over start worst", 1.0, growth, self.runs.len()),
            self.quantile("rows in use px", 0.5, |m| m.in_use_px),
        ]
    }

    /// The yaw in use for each pair after the first [`AT_START`], and reloads of the rectifier. NaN if all runs are
    /// shorter.
    fn yaw_in_use(&self) -> Vec<Figure> {
        let later = || self.seen.iter().filter_map(|pairs| pairs.get(AT_START..));
        let used = || later().flatten().flatten().map(|m| m.yaw_in_use);
        let worst = |name, part: fn([f64; 2]) -> f64| {
            quantile_of(name, 1.0, used().map(part), self.runs.len())
        };
        let reloads = |pairs: &[Option<AfterPair>]| {
            let used: Vec<u32> = pairs.iter().flatten().map(|m| m.generation).collect();
            used.windows(2).filter(|two| two[0] != two[1]).count()
        };
        vec![
            self.rms("yaw in use", rms(used().map(|[yaw, _]| yaw)).unwrap_or(f64::NAN)),
            worst("yaw in use worst", |[yaw, _]| yaw.abs()),
            worst("yaw over reported worst", |[_, over]| over),
            counted("reloads", later().map(reloads).sum()),
        ]
    }

    /// Passes of a pair: mean and most of all, and means of those that started and ended locked, or not locked.
    fn passes(&self) -> Vec<Figure> {
        let mut all = [Vec::new(), Vec::new(), Vec::new()];
        for pairs in &self.seen {
            let mut before = State::Acquiring;
            for m in pairs.iter().flatten() {
                let kind = [
                    true,
                    [before, m.state] == [State::Locked; 2],
                    ![before, m.state].contains(&State::Locked),
                ];
                for (numbers, _) in all.iter_mut().zip(kind).filter(|(_, is)| *is) {
                    numbers.extend(m.passes.map(f64::from));
                }
                before = m.state;
            }
        }
        let names = ["passes", "passes locked", "passes before"];
        let mean_of = |(name, numbers): (&'static str, &Vec<f64>)| {
            let value = mean(numbers.iter().copied()).unwrap_or(f64::NAN);
            Figure { name, value, chance: Chance::mean_count(value, numbers.len()) }
        };
        let most = quantile_of("passes at most", 1.0, all[0].iter().copied(), self.runs.len());
        names.into_iter().zip(&all).map(mean_of).chain([most]).collect()
    }

    /// Changes of the estimate, and what follows a turn: pairs to the first change, and RMS error in use.
    fn changes(&self, turn: usize) -> Vec<Figure> {
        let changed = |m: &Option<AfterPair>| {
            m.is_some_and(|m| matches!(m.fused, Some(Fused::Renewed | Fused::TookOver)))
        };
        let after = |pairs: &&[Option<AfterPair>]| pairs.get(turn..)?.iter().position(changed);
        let found: Vec<f64> = self.seen.iter().filter_map(after).map(|at| count(at + 1)).collect();
        let changes = |pairs: &&[Option<AfterPair>]| pairs.iter().filter(|m| changed(m)).count();
        let follows =
            |name, share| quantile_of(name, share, found.iter().copied(), self.runs.len());
        let in_use = |names: [&'static str; 2], pairs: usize| {
            let at = self.seen.iter().filter_map(|seen| *seen.get(turn + pairs - 1)?);
            let at: Vec<Deviation<f64>> = at.map(|m| m.in_use).collect();
            let part = |of: fn(&Deviation<f64>) -> f64| rms(at.iter().map(of)).unwrap_or(f64::NAN);
            [self.rms(names[0], part(|e| e.translation)), self.rms(names[1], part(|e| e.rotation))]
        };
        let mut all = vec![
            counted("pairs", self.seen.iter().map(|pairs| pairs.len()).sum()),
            counted("changes", self.seen.iter().map(changes).sum()),
            follows("followed after", 0.5),
            follows("followed after 99 %", 0.99),
            follows("followed after at most", 1.0),
            counted("never followed", self.runs.len() - found.len()),
        ];
        all.extend(in_use(["e_t 3 pairs later", "e_R 3 pairs later"], 3));
        all.extend(in_use(["e_t 15 pairs later", "e_R 15 pairs later"], 15));
        all
    }
}

/// Standard deviation of noise and rounding together, px. A pyramid's levels count by their information.
fn rounded_px(scenario: &Scenario) -> f64 {
    let noise = scenario.scene.noise_px;
    let with = |q: f64| noise * noise + q * q / 12.0;
    match scenario.scene.grid {
        Grid::Continuous => noise,
        Grid::Pixels(q) => with(q).sqrt(),
        Grid::Pyramid => {
            let levels = (0..8).map(|level| 1.0 / with(1.2_f64.powi(level)));
            (levels.sum::<f64>() / 8.0).sqrt().recip()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::synth::ScenarioKind;
    use stereo_selfcal::Extrinsics;

    /// A pair with these errors of `t` and `R`, rad, and reported deviations of 1 mrad.
    fn pair(state: State, armed: bool, e_t: f64, e_r: f64) -> AfterPair {
        let deviation = |translation: f64, rotation: f64| Deviation { translation, rotation };
        AfterPair {
            state,
            fused: None,
            passes: Some(4),
            found: Extrinsics::SIDE_BY_SIDE,
            error: deviation(e_t, e_r),
            in_use: deviation(e_t, e_r),
            sd: deviation(1e-3, 1e-3),
            error_in_sd: e_t.max(e_r) / 1e-3,
            nees: 10.0,
            armed,
            coverage: 1.0,
            vibration: [0.0; 2],
            yaw_in_use: [e_r, e_r / 1e-3],
            generation: 1,
            in_use_px: 0.5,
        }
    }

    fn run(pairs: &[AfterPair]) -> Run {
        let fit = Deviation { translation: 5e-4, rotation: 5e-4 };
        let start = Deviation { translation: 2e-3, rotation: 1e-3 };
        let pairs = pairs.iter().copied().map(Some).collect();
        Run { pairs, start, joint_fit: Some(fit), bound: Some(fit) }
    }

    #[test]
    fn locked_and_armed_pairs_with_too_small_deviations_are_counted() {
        let good = pair(State::Locked, true, 1e-3, 1e-3);
        let bad = pair(State::Locked, false, 1e-3, 6e-3);
        let early = pair(State::Acquiring, false, 9e-3, 1e-3);
        let runs = [run(&[early, good, good]), run(&[early, bad, good])];
        let scenario = Scenario::new(ScenarioKind::Near, 3);
        let value = |pairs: usize, name: &str| {
            let figures = all(&runs, &scenario, pairs);
            figures.iter().find(|figure| figure.name == name).unwrap().value
        };
        for (name, expected) in [
            ("locked", 1.0),
            ("all locked by pair", 2.0),
            ("locked pairs", 4.0),
            ("pairs beyond 5 sd", 1.0),
            ("locks beyond 5 sd", 1.0),
            ("runs beyond 5 sd", 1.0),
            ("e_t over joint fit", 2.0),
            ("within 4 bounds", 1.0),
            ("NEES", 10.0),
            ("e_t in use over start worst", 0.5),
            ("passes locked", 4.0),
            ("never followed", 2.0),
        ] {
            let found = value(3, name);
            assert!((found - expected).abs() < 1e-12, "{name}: {found}, not {expected}");
        }
        assert!(value(3, "armed at 10").is_nan() && value(2, "e_R over joint fit").is_nan());
        assert!((value(2, "armed") - 0.5).abs() < 1e-12);
        assert!((value(2, "e_R worst") - 6e-3).abs() < 1e-12);
    }
}
