//! Runs of all rows with each mechanism off, on the same pairs.

use std::fs::{File, create_dir_all};
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use host_tests::bounds::cramer_rao;
use host_tests::data::{Dataset, Match, TurnedCamera, TurnedView, in_f64};
use host_tests::run::monte_carlo::{CAPACITY, FEW, TOO_MANY_SD, calibrator};
use host_tests::run::progress;
use host_tests::run::real_rigs::push_witnessed;
use host_tests::synth::{Scenario, ScenarioKind, ScenarioPair};
use rayon::prelude::*;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Config, Correspondence, Extrinsics, FactoryCalibration, Fused, State,
};

use super::super::real_cases::all;
use super::super::{fused, single};

/// A row of the campaigns: a scene, or a recorded set from all views.
pub(super) struct Row {
    /// `campaign/group/name`.
    pub(super) name: String,
    source: Source,
}

enum Source {
    Made(Box<Scenario>),
    Recorded(Vec<Dataset>),
}

/// A pair of a run.
struct Pair {
    matches: Vec<Correspondence<f32>>,
    truth: Extrinsics<f64>,
    /// The generated pair, with its witnesses.
    frame: Option<ScenarioPair>,
}

/// Figures of one run, in the order of its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Figures {
    /// Error of `t` and of `R` at the end, rad; NaN without an estimate.
    pub(super) error: [f64; 2],
    /// 1 if the run succeeds, otherwise 0. A run of several pairs succeeds if it is locked at the end, a single pair if
    /// its errors are below 4 times the bound, and a run that must not lock if it never locks.
    pub(super) success: f64,
    /// 1 if the estimate is off by more than 5 reported deviations after any pair while locked, otherwise 0. For a
    /// single pair: 1 if it has an answer that is not within 4 times the bound.
    pub(super) bad: f64,
    /// Share of the pairs after which the rig may arm; 0 for a single pair.
    pub(super) armed: f64,
    /// Changes of the estimate of a rig that has not turned; NaN for a drift.
    pub(super) alarms: f64,
    /// Pairs from the step to its detection; NaN without a step or a detection.
    pub(super) found: f64,
    /// Passes over all pairs.
    pub(super) passes: f64,
}

impl Figures {
    fn line(&self) -> String {
        let Self { error: [t, r], success, bad, armed, alarms, found, passes } = self;
        format!("{t},{r},{success},{bad},{armed},{alarms},{found},{passes}")
    }

    pub(super) fn of_line(line: &str) -> Option<Self> {
        let numbers: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
        let [t, r, success, bad, armed, alarms, found, passes] = numbers.ok()?.try_into().ok()?;
        Some(Self { error: [t, r], success, bad, armed, alarms, found, passes })
    }
}

impl Row {
    fn made(name: String, mut scenario: Scenario, most: usize) -> Self {
        scenario.pairs = scenario.pairs.min(most);
        Self { name, source: Source::Made(Box::new(scenario)) }
    }

    fn pairs(&self, seed: u64, first: u64) -> Result<Option<Vec<Pair>>> {
        let all = |pair: &[Match]| pair.iter().map(Match::correspondence).collect();
        Ok(match &self.source {
            Source::Made(scenario) => {
                let frame = |frame: ScenarioPair| Pair {
                    matches: all(&frame.pair.matches),
                    truth: frame.steady,
                    frame: Some(frame),
                };
                Some(scenario.frames(seed)?.map(frame).collect())
            }
            Source::Recorded(views) => {
                let Some(set) = views.get(usize::try_from(seed - first)?) else { return Ok(None) };
                let (truth, truths) = (set.truth()?, set.truths()?);
                let of = |(i, pair): (usize, &Vec<Match>)| Pair {
                    matches: all(pair),
                    truth: truths.get(i).copied().unwrap_or(truth),
                    frame: None,
                };
                Some(set.pairs.iter().enumerate().map(of).collect())
            }
        })
    }

    fn calibrator(&self, seed: u64, first: u64) -> Result<Box<Calibrator<f32, CAPACITY>>> {
        match &self.source {
            Source::Made(scenario) => calibrator(scenario, Config::default()),
            Source::Recorded(views) => {
                let set = views.get(usize::try_from(seed - first)?).context("no such view")?;
                let factory = FactoryCalibration::guess(set.cameras()?);
                Ok(Box::new(Calibrator::new(Config::default(), &factory)))
            }
        }
    }

    fn scenario(&self) -> Option<&Scenario> {
        match &self.source {
            Source::Made(scenario) => Some(scenario),
            Source::Recorded(_) => None,
        }
    }

    /// Index of the first pair after the turn; `None` if the rig does not turn in one step.
    fn step(&self) -> Option<usize> {
        let turns = |s: &&Scenario| s.kind == ScenarioKind::Step && s.turn_deg != 0.0;
        self.scenario().filter(turns).map(Scenario::turned_from)
    }

    /// Whether the rig turns with every pair: a change of the estimate is then not a false alarm.
    fn drifts(&self) -> bool {
        self.scenario().is_some_and(|s| s.kind == ScenarioKind::Drift)
    }

    /// Whether the matches are wrong on purpose, so that the calibrator must not lock.
    fn must_not_lock(&self) -> bool {
        self.name.starts_with("garbage/") || self.scenario().is_some_and(|s| s.mistake.is_some())
    }

    /// Cramer-Rao bound of a single generated pair; `None` for other rows, and for fewer than [`FEW`] true matches.
    fn bound(&self, seed: u64) -> Result<Option<Deviation<f64>>> {
        let Source::Made(scenario) = &self.source else { return Ok(None) };
        if scenario.pairs > 1 {
            return Ok(None);
        }
        let frame = scenario.frames(seed)?.next().context("a scenario has pairs")?;
        let rays = frame.pair.clean_inlier_rays(&frame.scene);
        let noise = frame.scene.noise_px / frame.scene.focal;
        Ok((rays.len() >= FEW).then(|| cramer_rao(&frame.steady, rays.iter(), noise)))
    }

    fn run(
        &self,
        calibrator: &mut Calibrator<f32, CAPACITY>,
        pairs: &[Pair],
        bound: Option<Deviation<f64>>,
    ) -> Figures {
        let step = self.step();
        let count = |n: usize| u32::try_from(n).map_or(f64::NAN, f64::from);
        let [mut alarms, mut bad, mut armed, mut passes] = [0.0; 4];
        let (mut found, mut ever) = (f64::NAN, false);
        for (at, Pair { matches, truth, frame }) in pairs.iter().enumerate() {
            let outcome = calibrator.take_pair(matches.iter().copied());
            if let Some(frame) = frame {
                push_witnessed(calibrator, frame);
            }
            passes += outcome.pair.map_or(0.0, |report| f64::from(report.passes));
            if pairs.len() > 1 {
                let may_arm = calibrator.health().is_ok_and(|health| health.may_arm());
                armed += f64::from(u8::from(may_arm)) / count(pairs.len());
                let _ = calibrator.apply();
            }
            if matches!(outcome.fused, Ok(Fused::Renewed | Fused::TookOver)) {
                match step {
                    Some(step) if at >= step && found.is_nan() => found = count(at - step + 1),
                    Some(step) if at >= step => (),
                    _ => alarms += 1.0,
                }
            }
            if calibrator.state() == State::Locked {
                ever = true;
                let over = calibrator.proposal().map(|proposal| {
                    let error = Deviation::between(&in_f64(&proposal.extrinsics), truth);
                    let sd = proposal.sd_lens;
                    (error.translation / f64::from(sd.translation))
                        .max(error.rotation / f64::from(sd.rotation))
                });
                if over.is_some_and(|over| over > TOO_MANY_SD) {
                    bad = 1.0;
                }
            }
        }
        let end = calibrator
            .proposal()
            .zip(pairs.last())
            .map(|(proposal, last)| Deviation::between(&in_f64(&proposal.extrinsics), &last.truth));
        let error = end.map_or([f64::NAN; 2], |e| [e.translation, e.rotation]);
        let mut success = calibrator.state() == State::Locked;
        if pairs.len() == 1 {
            let within = |e: Deviation<f64>| {
                bound.is_some_and(|b| {
                    e.translation < 4.0 * b.translation && e.rotation < 4.0 * b.rotation
                })
            };
            success = end.is_some_and(within);
            bad = f64::from(u8::from(end.is_some() && !success));
        } else if self.must_not_lock() {
            success = !ever;
        }
        let success = f64::from(u8::from(success));
        let alarms = if self.drifts() { f64::NAN } else { alarms };
        // A single pair that fails ends at another optimum: it counts as a failure only.
        let error = if pairs.len() == 1 && success == 0.0 { [f64::NAN; 2] } else { error };
        Figures { error, success, bad, armed, alarms, found, passes }
    }
}

/// All rows.
///
/// * `most`: pairs of a run at most.
pub(super) fn rows(most: usize) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let recorded = |name: &&str| -> Result<Row> {
        let set = Dataset::load(&Dataset::shipped().join(name))?;
        let mut views = vec![set.clone()];
        for camera in [TurnedCamera::Left, TurnedCamera::Right, TurnedCamera::Both] {
            for view in [TurnedView::Top, TurnedView::Bottom, TurnedView::Left, TurnedView::Right] {
                views.push(view.turn_camera(&set, 5.0, camera)?);
            }
        }
        Ok(Row { name: format!("recorded/{name}"), source: Source::Recorded(views) })
    };
    for row in Dataset::SHIPPED.iter().map(recorded) {
        rows.push(row?);
    }
    for (name, scenario) in single::scenarios()? {
        rows.push(Row::made(format!("single/{name}"), scenario, most));
    }
    for (name, scenario) in fused::scenarios() {
        rows.push(Row::made(format!("fused/{name}"), scenario, most));
    }
    for case in all()? {
        rows.push(Row::made(format!("real/{}", case.path()), case.scenario, most));
    }
    let rig = host_tests::synth::five_degrees_off();
    for degrees in [5.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01, 0.0] {
        let mut scenario = Scenario::new(ScenarioKind::Step, 120);
        (scenario.scene.outliers, scenario.scene.rig, scenario.turn_deg) = (0.1, rig, degrees);
        rows.push(Row::made(format!("steps/{degrees}"), scenario, most));
    }
    for matches in [256, 64, 30, 20] {
        let mut scenario = Scenario::new(ScenarioKind::Near, 50);
        (scenario.scene.outliers, scenario.scene.matches) = (1.0, matches);
        rows.push(Row::made(format!("garbage/{matches}"), scenario, most));
    }
    Ok(rows)
}

/// Runs all rows, and writes a line a run: `row;seed;figures`. A row that is complete in the file of a mechanism is not
/// run again for this mechanism.
///
/// * `switch`: switches the mechanism of that number off in the calling thread.
/// * `names`: numbers and names of the mechanisms.
pub(super) fn measure(
    into: &Path,
    names: &[(usize, String)],
    seeds: [u64; 2],
    most: usize,
    switch: impl Fn(usize) + Sync,
) -> Result<()> {
    create_dir_all(into)?;
    let rows = rows(most)?;
    let read =
        |(_, name): &(usize, String)| std::fs::read_to_string(into.join(name)).unwrap_or_default();
    let had: Vec<String> = names.iter().map(read).collect();
    let mut files = Vec::new();
    for (_, name) in names {
        files.push(File::options().append(true).create(true).open(into.join(name))?);
    }
    let count = |row: &Row| if row.name.starts_with("single") { seeds[0] } else { seeds[1] };
    let all: u64 = rows.iter().map(count).sum();
    let bar = progress::over(usize::try_from(all)?, "runs of all mechanisms");
    for row in &rows {
        bar.set_message(row.name.clone());
        let count = count(row);
        let first = 9_000_000;
        let last = format!("{};{};", row.name, first + count);
        let due: Vec<usize> = (0..names.len())
            .filter(|&k| had.get(k).is_none_or(|had| !had.contains(&last)))
            .collect();
        let of_seed = |seed: u64| -> Result<Option<Vec<Figures>>> {
            let Some(pairs) = row.pairs(seed, first)? else { return Ok(None) };
            let bound = row.bound(seed)?;
            let run = |&k: &usize| -> Result<Figures> {
                switch(names[k].0);
                Ok(row.run(&mut *row.calibrator(seed, first)?, &pairs, bound))
            };
            Ok(Some(due.iter().map(run).collect::<Result<_>>()?))
        };
        if due.is_empty() {
            bar.inc(count);
            continue;
        }
        let runs: Vec<_> = (first..first + count)
            .into_par_iter()
            .map(|seed| Ok((seed, of_seed(seed).inspect(|_| bar.inc(1))?)))
            .collect::<Result<_>>()?;
        for (i, &k) in due.iter().enumerate() {
            let file = &mut files[k];
            for (seed, figures) in &runs {
                if let Some(figures) = figures.as_ref().and_then(|figures| figures.get(i)) {
                    writeln!(file, "{};{seed};{}", row.name, figures.line())?;
                }
            }
            // Marks the row as complete.
            writeln!(file, "{last}")?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}
