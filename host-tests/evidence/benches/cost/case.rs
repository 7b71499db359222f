//! The rows of the table, and the measured work of each.

use std::fmt;

use anyhow::{Result, bail, ensure};
use host_tests::data::{Match, Rays, in_f64};
use host_tests::synth::{ScenarioKind, Scene, SynthPair, five_degrees_off};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Config, Extrinsics, FactoryCalibration, PairReport, Rejection, State,
};

use crate::minpack::{Fit, RowOffsets};

/// Pairs of each row.
pub(crate) const PAIRS: usize = 50;

/// Pairs that lock a calibrator.
const LOCKING: usize = 20;

/// Calls of `advance_pair` after the first one and before the measured one: for more than 128 matches, and for at most
/// 128.
const ANNEALED: [usize; 2] = [4, 8];

/// Seed of the measured pairs; the pairs that lock a calibrator have the next seed.
const SEED: u64 = 1;

type Calibrator1024 = Calibrator<f32, 1024>;

/// The measured method.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Method {
    Acquiring,
    Pass,
    Locked,
    Paper,
    Minpack,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Acquiring => "robust, acquiring",
            Self::Pass => "robust, one pass",
            Self::Locked => "robust, locked",
            Self::Paper => "paper",
            Self::Minpack => "lmder, f64",
        })
    }
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    pub(crate) matches: usize,
    /// Share of outliers.
    pub(crate) outliers: f64,
    pub(crate) method: Method,
}

/// One pair, ready to be measured.
#[derive(Debug, Clone)]
pub(crate) enum Job {
    Solve(Box<Calibrator1024>),
    Pass(Box<Calibrator1024>),
    Minpack(Box<RowOffsets>),
}

/// Result of a job.
#[derive(Debug)]
pub(crate) enum Answer {
    Report(Result<Report, Rejection>),
    /// One pass taken.
    Pass(Result<(), Rejection>),
    Fit(Fit),
}

/// The part of the calibrator's report that a row needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Report {
    passes: u16,
    extrinsics: Extrinsics<f32>,
}

impl Case {
    /// All rows, in the order of the table.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let methods =
            [Method::Acquiring, Method::Pass, Method::Locked, Method::Paper, Method::Minpack];
        [64, 256, 1024].into_iter().flat_map(move |matches| {
            [0.0, 0.3]
                .into_iter()
                .flat_map(move |outliers| methods.map(|method| Self { matches, outliers, method }))
        })
    }

    /// The pairs to measure, prepared up to the measured work.
    pub(crate) fn jobs(&self) -> Result<Vec<Job>> {
        let scene = self.scene();
        scene.check()?;
        let pairs = scene.pairs(SEED).take(PAIRS);
        match self.method {
            Method::Acquiring => pairs.map(|pair| fresh(&scene, Config::robust(), &pair)).collect(),
            Method::Pass => pairs.map(|pair| amid(&scene, &pair)).collect(),
            Method::Paper => pairs.map(|pair| fresh(&scene, Config::paper(), &pair)).collect(),
            Method::Minpack => Ok(pairs.map(|pair| minpack(&scene, &pair)).collect()),
            Method::Locked => locked(&scene, pairs),
        }
    }

    /// Passes over the batch, evaluation included, and the error of the pair alone, if it was
    /// solved to the end.
    ///
    /// # Errors
    /// If there is no answer.
    pub(crate) fn outcome(&self, answer: &Answer) -> Result<(usize, Option<Deviation<f64>>)> {
        let (passes, found) = match answer {
            Answer::Pass(taken) => {
                (*taken)?;
                return Ok((1, None));
            }
            Answer::Report(report) => {
                let report = (*report)?;
                // The paper preset's report does not count the evaluation.
                let judging = usize::from(matches!(self.method, Method::Paper));
                (usize::from(report.passes) + judging, in_f64(&report.extrinsics))
            }
            Answer::Fit(Fit { solution, evaluations }) => {
                ensure!(solution.converged, "no convergence");
                (*evaluations, Extrinsics::try_new(&solution.rotation(), &solution.translation())?)
            }
        };
        Ok((passes, Some(Deviation::between(&found, &five_degrees_off()))))
    }

    fn scene(&self) -> Scene {
        let (matches, outliers) = (self.matches, self.outliers);
        Scene { rig: five_degrees_off(), matches, outliers, ..ScenarioKind::Near.scene() }
    }
}

impl Job {
    /// The measured work.
    pub(crate) fn run(self) -> Answer {
        match self {
            Self::Solve(mut calibrator) => Answer::Report(solve_and_fuse(&mut calibrator)),
            Self::Pass(mut calibrator) => {
                Answer::Pass(calibrator.advance_pair().map_or(Ok(()), |o| o.fused.map(|_| ())))
            }
            Self::Minpack(problem) => Answer::Fit(problem.minimise()),
        }
    }
}

impl From<PairReport<f32>> for Report {
    fn from(report: PairReport<f32>) -> Self {
        Self { passes: report.passes, extrinsics: report.extrinsics }
    }
}

fn solve_and_fuse(calibrator: &mut Calibrator1024) -> Result<Report, Rejection> {
    let outcome = calibrator.solve_pair();
    // A solved pair counts also if it is not fused.
    let why = outcome.fused.err().unwrap_or(Rejection::NotBegun);
    outcome.pair.map(Report::from).ok_or(why)
}

/// A calibrator with the matches of this pair only.
fn fresh(scene: &Scene, config: Config, pair: &SynthPair) -> Result<Job> {
    let factory = FactoryCalibration::guess(scene.dataset(0, SEED)?.cameras()?);
    let mut calibrator = Box::new(Calibrator1024::new(config, &factory));
    fill(&mut calibrator, pair)?;
    Ok(Job::Solve(calibrator))
}

/// A calibrator in the middle of a search: the next pass is the measured one.
fn amid(scene: &Scene, pair: &SynthPair) -> Result<Job> {
    let Job::Solve(mut calibrator) = fresh(scene, Config::robust(), pair)? else {
        bail!("a fresh calibrator is to be solved");
    };
    ensure!(calibrator.advance_pair().is_none(), "the pair has matches");
    let [many, few] = ANNEALED;
    for _ in 0..if pair.matches.len() <= 128 { few } else { many } {
        ensure!(calibrator.advance_pair().is_none(), "the pair goes on");
    }
    Ok(Job::Pass(calibrator))
}

/// The locked calibrator before each of the measured pairs. Pairs before which it is not locked are left out.
fn locked(scene: &Scene, pairs: impl Iterator<Item = SynthPair>) -> Result<Vec<Job>> {
    let factory = FactoryCalibration::guess(scene.dataset(0, SEED)?.cameras()?);
    let mut calibrator = Box::new(Calibrator1024::new(Config::robust(), &factory));
    for pair in scene.pairs(SEED + 1).take(LOCKING) {
        fill(&mut calibrator, &pair)?;
        // The lock is checked below.
        let _ = solve_and_fuse(&mut calibrator);
    }
    let mut jobs = Vec::with_capacity(PAIRS);
    for pair in pairs {
        fill(&mut calibrator, &pair)?;
        if calibrator.state() == State::Locked {
            jobs.push(Job::Solve(calibrator.clone()));
        }
        let _ = solve_and_fuse(&mut calibrator);
    }
    ensure!(!jobs.is_empty(), "{LOCKING} pairs did not lock the calibrator");
    Ok(jobs)
}

fn fill(calibrator: &mut Calibrator1024, pair: &SynthPair) -> Result<()> {
    calibrator.discard_pair();
    for m in &pair.matches {
        calibrator.push(&m.correspondence())?;
    }
    Ok(())
}

fn minpack(scene: &Scene, pair: &SynthPair) -> Job {
    let ray = |m: &Match| scene.rays([m.ul, m.vl, m.ur, m.vr]);
    let rays: Vec<Rays> = pair.matches.iter().map(ray).collect();
    Job::Minpack(Box::new(RowOffsets::new(&Extrinsics::SIDE_BY_SIDE, &rays)))
}
