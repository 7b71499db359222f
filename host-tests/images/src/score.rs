//! Compares candidate calibrations on the same matches: rows, coverage, depths, and whether a difference is
//! significant.
//!
//! All candidates are scored on the matches within [`SCREEN_PX`] of their rows under at least one of them. If
//! pairs are held out, the estimate uses every second pair, and all candidates are scored on the others.

use std::fmt;

use anyhow::{Context, Result};
use rigs::data::{Dataset, Match, Meta};
use serde::Serialize;
use sim::run::{SCREEN_PX, Start, offsets, replay, row_offsets_px};
use sim::stats::{mean, median, rms};
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::{Calibration, Config, Extrinsics};

/// Largest row offset of a match that counts for coverage, px.
const IN_ROW_PX: f64 = 1.0;

/// Cells of the left image, across and down.
const CELLS: [usize; 2] = [8, 6];

/// A cell is covered if at least this many matches of all pairs lie in it and on their row ([`IN_ROW_PX`]).
const COVERED: usize = 3;

/// Number of parts of an image, across and down, that are separate observations if there are few pairs.
const PARTS: usize = 3;

/// With at least this many pairs each pair is one observation; with fewer each part of a pair is one.
const PAIRS: usize = 5;

/// Two-sided 95 % quantiles of Student's t, by degrees of freedom from 1.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

/// A calibration to score.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Name for the user.
    pub name: String,
    /// Cameras, `R` and `t`.
    pub rig: Meta,
}

/// Score of one candidate.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// Name for the user.
    pub name: String,
    /// RMS row offset, px.
    pub rows_px: f64,
    /// Share of the cells of the left image that matches in row cover.
    pub coverage: f64,
    /// Median difference of the depths from those of the estimate, relative; `None` without an estimate.
    pub depth_off: Option<f64>,
}

/// Comparison of two candidates.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// The candidate with the smaller row offsets.
    pub better: String,
    /// The other candidate.
    pub worse: String,
    /// Difference of the mean squared row offsets, and the limits of its 95 % confidence interval, px^2.
    pub by_px2: [f64; 3],
    /// Whether the interval excludes 0.
    pub significant: bool,
    /// Unit of observation: `pairs`, or `parts of pairs`.
    pub observations: &'static str,
}

/// All scores.
#[derive(Debug, Clone, Serialize)]
pub struct Scores {
    /// Number of pairs scored.
    pub pairs: usize,
    /// Number of matches scored.
    pub matches: usize,
    /// Whether the scored pairs were held out: the estimate has not used them. Always false for a single pair.
    pub held_out: bool,
    /// Candidates in the given order, then the estimate, if there is one.
    pub candidates: Vec<Score>,
    /// Comparisons of all candidates with each other.
    pub comparisons: Vec<Comparison>,
}

impl Scores {
    /// Scores candidates, and the estimate of a run that starts from the first candidate.
    ///
    /// # Errors
    /// If a candidate is not valid, or there are no pairs.
    pub fn of(set: &Dataset, mut candidates: Vec<Candidate>, hold_out: bool) -> Result<Self> {
        let every = |odd: usize| set.pairs.iter().skip(odd).step_by(2).cloned().collect();
        let held_out = hold_out && set.pairs.len() >= 2;
        let (seen, scored) = if held_out {
            (Dataset { pairs: every(0), ..set.clone() }, Dataset { pairs: every(1), ..set.clone() })
        } else {
            (set.clone(), set.clone())
        };
        let first = candidates.first().context("a candidate")?.rig.clone();
        let seen = Dataset { meta: first.clone(), ..seen };
        let start: Extrinsics<f32> = first.extrinsics()?;
        let log = replay(&seen, Config::robust(), Start::Calibration(start), |_| ())?;
        let fused = log.fused();
        if let Some(fused) = fused {
            let name = if held_out {
                "estimate from the other pairs"
            } else {
                "estimate from the same pairs"
            };
            candidates.push(Candidate { name: name.into(), rig: fused.rig(&first) });
        }
        let calibrations = candidates.iter().map(calibration).collect::<Result<Vec<_>>>()?;
        let offsets: Vec<Vec<Vec<Option<f64>>>> =
            calibrations.iter().map(|one| row_offsets_px(&scored, one)).collect();
        let kept = kept(&scored, &offsets);
        let reference = if fused.is_some() { calibrations.last() } else { None };
        let score = |i: usize| Score {
            name: candidates[i].name.clone(),
            rows_px: rms(kept.iter().filter_map(|at| at.of(&offsets[i]))).unwrap_or(f64::NAN),
            coverage: coverage(&scored, &offsets[i]),
            depth_off: reference
                .and_then(|reference| depth_off(&scored, &kept, &calibrations[i], reference)),
        };
        let scores: Vec<Score> = (0..candidates.len()).map(score).collect();
        let pairs = (0..scores.len()).flat_map(|i| (i + 1..scores.len()).map(move |j| [i, j]));
        let comparisons = pairs.filter_map(|[i, j]| {
            compared(&scored, &kept, [&offsets[i], &offsets[j]], [&scores[i], &scores[j]])
        });
        Ok(Self {
            pairs: scored.pairs.len(),
            matches: kept.len(),
            held_out,
            comparisons: comparisons.collect(),
            candidates: scores,
        })
    }
}

fn calibration(candidate: &Candidate) -> Result<Calibration<f64>> {
    let read = || candidate.rig.calibration(&candidate.rig.extrinsics()?, &LensCorrection::NONE);
    read().with_context(|| candidate.name.clone())
}

/// A scored match: numbers of its pair and of the match in the pair.
#[derive(Debug, Clone, Copy)]
struct Kept([usize; 2]);

impl Kept {
    /// Row offset of the match under a candidate, px, for the score.
    fn of(self, offsets: &[Vec<Option<f64>>]) -> Option<f64> {
        let Self([pair, i]) = self;
        // A match without a row under a candidate counts as an offset of `SCREEN_PX`. Offsets are clipped at
        // twice this.
        Some(
            offsets
                .get(pair)?
                .get(i)?
                .map_or(SCREEN_PX, |px| px.clamp(-2.0 * SCREEN_PX, 2.0 * SCREEN_PX)),
        )
    }

    fn of_set(self, set: &Dataset) -> Match {
        let Self([pair, i]) = self;
        set.pairs[pair][i]
    }
}

/// The matches within [`SCREEN_PX`] of their rows under at least one candidate.
fn kept(set: &Dataset, offsets: &[Vec<Vec<Option<f64>>>]) -> Vec<Kept> {
    let fits = |pair: usize, i: usize| {
        let mut all = offsets.iter().filter_map(|of| of[pair][i]);
        all.any(|px| px.abs() <= SCREEN_PX)
    };
    let places = set
        .pairs
        .iter()
        .enumerate()
        .flat_map(|(pair, matches)| (0..matches.len()).map(move |i| [pair, i]));
    places.filter(|[pair, i]| fits(*pair, *i)).map(Kept).collect()
}

fn coverage(set: &Dataset, offsets: &[Vec<Option<f64>>]) -> f64 {
    let size = set.meta.sizes()[0].map(f64::from);
    let mut counts = [[0_usize; CELLS[0]]; CELLS[1]];
    for (m, px) in set.pairs.iter().flatten().zip(offsets.iter().flatten()) {
        if px.is_some_and(|px| px.abs() <= IN_ROW_PX) {
            let cell = |x: f64, i: usize| {
                (((x + 0.5) / size[i] * CELLS[i] as f64) as usize).min(CELLS[i] - 1)
            };
            counts[cell(m.vl, 1)][cell(m.ul, 0)] += 1;
        }
    }
    let covered = counts.as_flattened().iter().filter(|count| **count >= COVERED).count();
    covered as f64 / (CELLS[0] * CELLS[1]) as f64
}

/// Disparity of a match at unit depth; its inverse is the depth in baselines. `None` unless it is positive.
fn disparity(calibration: &Calibration<f64>, m: &Match) -> Option<f64> {
    offsets(calibration, m).map(|[disparity, ..]| disparity).filter(|d| *d > 0.0)
}

fn depth_off(
    set: &Dataset,
    kept: &[Kept],
    one: &Calibration<f64>,
    reference: &Calibration<f64>,
) -> Option<f64> {
    let off = |at: &Kept| {
        let m = at.of_set(set);
        Some((disparity(reference, &m)? / disparity(one, &m)? - 1.0).abs())
    };
    median(kept.iter().filter_map(off))
}

/// Compares two candidates by the paired differences of their squared row offsets. `None` for too few observations.
fn compared(
    set: &Dataset,
    kept: &[Kept],
    offsets: [&Vec<Vec<Option<f64>>>; 2],
    scores: [&Score; 2],
) -> Option<Comparison> {
    let by_parts = set.pairs.len() < PAIRS;
    let size = set.meta.sizes()[0].map(f64::from);
    let parts = if by_parts { PARTS } else { 1 };
    let mut observed = vec![Vec::new(); set.pairs.len() * parts * parts];
    for at in kept {
        let m = at.of_set(set);
        let part =
            |x: f64, i: usize| (((x + 0.5) / size[i] * parts as f64) as usize).min(parts - 1);
        let place = (at.0[0] * parts + part(m.vl, 1)) * parts + part(m.ul, 0);
        let squares = offsets.map(|offsets| at.of(offsets).map(|px| px * px));
        if let [Some(a), Some(b)] = squares {
            observed[place].push(b - a);
        }
    }
    let differences: Vec<f64> = observed.into_iter().filter_map(mean).collect();
    let count = differences.len();
    let by = mean(differences.iter().copied())?;
    let freedom = count.checked_sub(1).filter(|n| *n > 0)?;
    let variance = differences.iter().map(|d| (d - by) * (d - by)).sum::<f64>() / freedom as f64;
    let t = STUDENT.get(freedom - 1).copied().unwrap_or(1.96 + 2.5 / freedom as f64);
    let reach = t * (variance / count as f64).sqrt();
    let [better, worse] = if by >= 0.0 { scores } else { [scores[1], scores[0]] };
    let by = by.abs();
    Some(Comparison {
        better: better.name.clone(),
        worse: worse.name.clone(),
        by_px2: [by, by - reach, by + reach],
        significant: by > reach,
        observations: if by_parts { "parts of pairs" } else { "pairs" },
    })
}

impl fmt::Display for Scores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unseen = if self.held_out { ", which the estimate has not seen" } else { "" };
        writeln!(f, "{} matches of {} pairs{unseen}", self.matches, self.pairs)?;
        writeln!(
            f,
            "{:<40} {:>10} {:>9} {:>16}",
            "calibration", "rows, px", "coverage", "depths differ by"
        )?;
        for Score { name, rows_px, coverage, depth_off } in &self.candidates {
            let depth = depth_off.map_or("-".into(), |off| format!("{:.2} %", 100.0 * off));
            writeln!(f, "{name:<40} {rows_px:>10.3} {:>7.0} % {depth:>16}", 100.0 * coverage)?;
        }
        for Comparison { better, worse, by_px2: [by, low, high], significant, observations } in
            &self.comparisons
        {
            let verdict =
                if *significant { "is better than" } else { "is not significantly better than" };
            writeln!(
                f,
                "{better} {verdict} {worse}: squared rows by {by:.3} px^2 (95 %: {low:.3} to {high:.3}, over {observations})"
            )?;
        }
        write!(
            f,
            "Depths are compared with those of the estimate. Rows do not tell yaw: of two calibrations with the same rows the \
                   depths may differ."
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::synth::{Scenario, ScenarioKind};

    fn candidates(set: &Dataset, degrees: f64) -> Vec<Candidate> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // Pitch: all rows move.
        let pitch = nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
        let off = Meta {
            r: rigs::data::rows(&(pitch * rigs::data::matrix(&set.meta.r))),
            ..set.meta.clone()
        };
        [("true", set.meta.clone()), ("off", off)]
            .map(|(name, rig)| Candidate { name: name.into(), rig })
            .into()
    }

    #[test]
    fn the_true_rig_is_better_than_a_turned_one_and_two_equal_rigs_hardly_differ() {
        for pairs in [2, 8] {
            let set = Scenario::new(ScenarioKind::Near, pairs).dataset(7).unwrap();
            let scores = Scores::of(&set, candidates(&set, 0.05), true).unwrap();
            let first = &scores.comparisons[0];
            assert!(first.significant && first.better == "true", "{scores}");
            assert!(scores.held_out && scores.pairs == pairs / 2, "{scores}");
            let alike = Scores::of(&set, candidates(&set, 1e-6), false).unwrap();
            assert!(alike.comparisons[0].by_px2[0] < 1e-3, "{alike}");
        }
    }
}
