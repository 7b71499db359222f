//! What a run of the calibrator came to, against the truth of the data set: pair by pair, and whole.

use std::fmt;

use anyhow::Result;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{
    Extrinsics, Fused, PairError, PairReport, Proposal, RayPair, RectifyingRotations, Refusal,
    Scalar, Stop, row_offset,
};

use crate::dataset::Dataset;
pub use crate::estimate::Estimate;

/// Matches further than this from the final estimate's rows do not count in RMS row offsets, px:
/// three Huber thresholds, as the core screens.
pub const SCREEN_PX: f64 = 3.0;

/// What became of one pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Taken in: how.
    Accepted(Fused),
    /// Solved, but not fused.
    Refused(Refusal),
    /// Not solved.
    Failed(PairError),
}

/// One pair of a run, in `f64` whatever the scalar of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Correspondences the data set has for this pair.
    pub offered: usize,
    /// Correspondences that the calibrator took.
    pub taken: usize,
    /// What became of it.
    pub verdict: Verdict,
    /// The solved pair.
    pub solved: Option<Solved>,
    /// Error of the running estimate after this pair.
    pub running: Option<Deviation<f64>>,
    /// The running estimate after this pair.
    pub estimate: Option<Estimate>,
}

/// What one pair said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Of this pair alone.
    pub extrinsics: Extrinsics<f64>,
    /// Error of this pair alone.
    pub error: Deviation<f64>,
    /// Passes taken.
    pub passes: u16,
    /// Whether they were not enough.
    pub at_pass_limit: bool,
    /// RMS row offset of the screened correspondences at the start, px.
    pub rms_px_before: f64,
    /// The same at the solution, px.
    pub rms_px_after: f64,
}

/// The stable fields of `--json`. Angles in rad; `null` before there is an estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Pairs in the run.
    pub pairs: usize,
    /// Pairs fused.
    pub accepted: usize,
    /// `no estimate`, or the state of the calibrator and what speaks against the estimate.
    pub state: String,
    /// Error of the fused baseline direction.
    pub e_t: Option<f64>,
    /// Error of the fused rotation.
    pub e_theta: Option<f64>,
    /// RMS error of the baseline direction over single accepted pairs.
    pub sigma_t: Option<f64>,
    /// RMS error of the rotation over single accepted pairs.
    pub sigma_theta: Option<f64>,
    /// Fused rotation, row-major.
    #[serde(rename = "R")]
    pub r: Option<[f64; 9]>,
    /// Fused unit baseline direction.
    pub t: Option<[f64; 3]>,
    /// Standard deviation that the fused rotation claims.
    pub sd_rotation: Option<f64>,
    /// Standard deviation that the fused baseline direction claims.
    pub sd_translation: Option<f64>,
    /// RMS row offset of the factory extrinsics over the screened matches of all pairs, px.
    pub rms_px_before: Option<f64>,
    /// The same of the fused extrinsics, px.
    pub rms_px_after: Option<f64>,
    /// Shares of all matches within [`SCREEN_PX`] of their row, with the factory extrinsics and with
    /// the fused ones: what the RMS over matches that fit the latter cannot tell.
    #[serde(skip)]
    pub in_row: Option<[f64; 2]>,
}

/// A run being evaluated.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Of the latest pair.
    truth: Extrinsics<f64>,
    /// Of each pair; empty where the rig does not move.
    truths: Vec<Extrinsics<f64>>,
    factory: Extrinsics<f64>,
    steps: Vec<Step>,
    fused: Option<Estimate>,
}

impl Evaluation {
    /// Of a run that starts at `factory`, on data whose truth is `truth`.
    #[must_use]
    pub fn new(truth: Extrinsics<f64>, factory: Extrinsics<f64>) -> Self {
        Self { truth, truths: Vec::new(), factory, steps: Vec::new(), fused: None }
    }

    /// The same for a rig that moves: pair `i`, and the estimate after it, against `truths[i]`, pairs
    /// beyond the last against the last.
    #[must_use]
    pub fn with_truths(self, truths: Vec<Extrinsics<f64>>) -> Self {
        Self { truths, ..self }
    }

    /// Records one pair.
    ///
    /// * `offered`, `taken`: correspondences in the data set and in the batch.
    /// * `outcome`: what solving and fusing returned.
    /// * `fused`: the estimate after this pair.
    pub fn record<T: Scalar>(
        &mut self,
        [offered, taken]: [usize; 2],
        outcome: Result<(PairReport<T>, Result<Fused, Refusal>), PairError>,
        fused: Option<&Proposal<T>>,
    ) -> &Step {
        self.truth = self.truths.get(self.steps.len()).copied().unwrap_or(self.truth);
        self.fused = fused.map(Estimate::of);
        let running = self.fused.map(|f| Deviation::between(&f.extrinsics, &self.truth));
        let (verdict, solved) = match outcome {
            Err(error) => (Verdict::Failed(error), None),
            Ok((report, fusing)) => {
                let verdict = fusing.map_or_else(Verdict::Refused, Verdict::Accepted);
                (verdict, Some(self.solved(&report)))
            }
        };
        let estimate = self.fused;
        self.steps.push(Step { offered, taken, verdict, solved, running, estimate });
        &self.steps[self.steps.len() - 1]
    }

    fn solved<T: Scalar>(&self, report: &PairReport<T>) -> Solved {
        let extrinsics = in_f64(&report.extrinsics);
        Solved {
            extrinsics,
            error: Deviation::between(&extrinsics, &self.truth),
            passes: report.passes,
            at_pass_limit: report.stop == Stop::PassesSpent,
            rms_px_before: report.rms_px_before.to_f64(),
            rms_px_after: report.rms_px_after.to_f64(),
        }
    }

    /// The pairs so far.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Where the run started.
    #[must_use]
    pub fn factory(&self) -> &Extrinsics<f64> {
        &self.factory
    }

    /// What the latest pair was compared with.
    #[must_use]
    pub fn truth(&self) -> &Extrinsics<f64> {
        &self.truth
    }

    /// The estimate so far.
    #[must_use]
    pub fn fused(&self) -> Option<&Estimate> {
        self.fused.as_ref()
    }

    /// The whole run.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn summary(&self, set: &Dataset) -> Result<Summary> {
        let accepted = |step: &&Step| matches!(step.verdict, Verdict::Accepted(_));
        let singles = self.steps.iter().filter(accepted).filter_map(|step| step.solved);
        let sigma = Deviation::root_mean_square(singles.map(|solved| solved.error));
        let error = self.fused.map(|f| Deviation::between(&f.extrinsics, &self.truth));
        let rows = match &self.fused {
            Some(f) => RowOffsets::over(set, &self.factory, &f.extrinsics)?,
            None => None,
        };
        let t = |f: Estimate| f.extrinsics.translation().into_inner().into();
        Ok(Summary {
            pairs: self.steps.len(),
            accepted: self.steps.iter().filter(accepted).count(),
            state: match &self.fused {
                None => "no estimate".into(),
                Some(f) => f.to_string(),
            },
            e_t: error.map(|e| e.translation),
            e_theta: error.map(|e| e.rotation),
            sigma_t: sigma.map(|s| s.translation),
            sigma_theta: sigma.map(|s| s.rotation),
            r: self.fused.map(|f| f.extrinsics.rotation_row_major()),
            t: self.fused.map(t),
            sd_rotation: self.fused.map(|f| f.sd.rotation),
            sd_translation: self.fused.map(|f| f.sd.translation),
            rms_px_before: rows.map(|rows| rows.rms_px[0]),
            rms_px_after: rows.map(|rows| rows.rms_px[1]),
            in_row: rows.map(|rows| rows.in_row),
        })
    }
}

/// Row offsets, px, of every correspondence of a data set under the given extrinsics, pair by pair
/// (`None`: no ray, or behind the rectified plane).
///
/// # Errors
/// If the data set's cameras are not valid.
pub fn row_offsets_px(
    set: &Dataset,
    extrinsics: &Extrinsics<f64>,
) -> Result<Vec<Vec<Option<f64>>>> {
    let cameras = set.cameras::<f64>()?;
    let rotations = RectifyingRotations::from(extrinsics);
    let offset = |rays: &RayPair<f64>| Some(row_offset(&rotations, rays)? * cameras.mean_focal());
    let of_pair = |pair: &Vec<crate::dataset::Match>| {
        let rays = pair.iter().map(|m| cameras.rays(&m.correspondence()).ok());
        rays.map(|rays| offset(&rays?)).collect()
    };
    Ok(set.pairs.iter().map(of_pair).collect())
}

/// Row offsets before and after, over a whole data set.
#[derive(Debug, Clone, Copy)]
struct RowOffsets {
    /// RMS over the matches within [`SCREEN_PX`] after.
    rms_px: [f64; 2],
    /// Share of all matches within [`SCREEN_PX`].
    in_row: [f64; 2],
}

impl RowOffsets {
    /// `None` if no match is screened.
    fn over(
        set: &Dataset,
        before: &Extrinsics<f64>,
        after: &Extrinsics<f64>,
    ) -> Result<Option<Self>> {
        let [before, after] = [row_offsets_px(set, before)?, row_offsets_px(set, after)?];
        let both: Vec<[Option<f64>; 2]> = before
            .into_iter()
            .flatten()
            .zip(after.into_iter().flatten())
            .map(|(before, after)| [before, after])
            .collect();
        let near = |px: Option<f64>| px.is_some_and(|px| px.abs() <= SCREEN_PX);
        let screened: Vec<[f64; 2]> = both
            .iter()
            .filter(|[_, after]| near(*after))
            .filter_map(|[before, after]| Some([(*before)?, (*after)?]))
            .collect();
        if screened.is_empty() {
            return Ok(None);
        }
        let count = |n: usize| Ok::<f64, anyhow::Error>(u32::try_from(n)?.into());
        let [all, kept] = [count(both.len())?, count(screened.len())?];
        let rms = |i: usize| (screened.iter().map(|e| e[i] * e[i]).sum::<f64>() / kept).sqrt();
        let in_row = |i: usize| count(both.iter().filter(|e| near(e[i])).count());
        Ok(Some(Self { rms_px: [rms(0), rms(1)], in_row: [in_row(0)? / all, in_row(1)? / all] }))
    }
}

/// The same extrinsics in `f64`.
///
/// # Panics
/// Never: the type holds what the conversion checks.
#[must_use]
pub fn in_f64<T: Scalar>(extrinsics: &Extrinsics<T>) -> Extrinsics<f64> {
    let r = Matrix3::from_row_slice(&extrinsics.rotation_row_major().map(T::to_f64));
    let t: Vector3<f64> = extrinsics.translation().map(T::to_f64);
    Extrinsics::try_new(&r, &t).expect("valid in the other scalar")
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Accepted(Fused::Added) => f.write_str("fused"),
            Self::Accepted(Fused::Repeated) => f.write_str("same scene again"),
            Self::Accepted(Fused::KeptApart) => f.write_str("kept apart"),
            Self::Accepted(Fused::Renewed) => f.write_str("fused, older pairs dropped"),
            Self::Accepted(Fused::TookOver) => f.write_str("the pairs kept apart took over"),
            Self::Accepted(other) => write!(f, "{other:?}"),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Failed(why) => write!(f, "not solved: {why}"),
        }
    }
}

impl Step {
    /// Heading over the lines of [`Step`]'s `Display`. Passes end in `+` where the limit cut them off.
    pub const HEADING: &str = "matches  rows px before>after  passes   pair e_t  e_theta deg   \
                               running e_t  e_theta deg   verdict";
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>7}  ", self.taken)?;
        match &self.solved {
            Some(s) => write!(
                f,
                "{:>9.3} > {:>9.3}  {:>5}{}   {:>8.3}  {:>11.3}   ",
                s.rms_px_before,
                s.rms_px_after,
                s.passes,
                if s.at_pass_limit { '+' } else { ' ' },
                s.error.translation.to_degrees(),
                s.error.rotation.to_degrees(),
            )?,
            None => write!(f, "{:>21}  {:>6}   {:>8}  {:>11}   ", "-", "-", "-", "-")?,
        }
        match &self.running {
            Some(e) => write!(
                f,
                "{:>11.3}  {:>11.3}   ",
                e.translation.to_degrees(),
                e.rotation.to_degrees()
            )?,
            None => write!(f, "{:>11}  {:>11}   ", "-", "-")?,
        }
        write!(f, "{}", self.verdict)?;
        if self.taken < self.offered {
            write!(f, " ({} of {} matches not taken)", self.offered - self.taken, self.offered)?;
        }
        Ok(())
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "pairs fused        {} of {} ({})", self.accepted, self.pairs, self.state)?;
        let mut angle = |name: &str, what: &str, value: Option<f64>| match value {
            Some(rad) => {
                writeln!(f, "{name:<18} {rad:>9.6} rad  {:>8.4} deg   {what}", rad.to_degrees())
            }
            None => writeln!(f, "{name:<18} {:>9}                     {what}", "-"),
        };
        angle("e_t", "fused baseline direction against the reference", self.e_t)?;
        angle("e_theta", "fused rotation against the reference", self.e_theta)?;
        angle("sigma_t", "single pairs, RMS", self.sigma_t)?;
        angle("sigma_theta", "single pairs, RMS", self.sigma_theta)?;
        angle("sd of t, claimed", "what the estimate says of itself", self.sd_translation)?;
        angle("sd of R, claimed", "what the estimate says of itself", self.sd_rotation)?;
        match self.rms_px_before.zip(self.rms_px_after) {
            Some((before, after)) => {
                writeln!(f, "RMS row offset     {before:.3} px before, {after:.3} px after")?;
            }
            None => writeln!(f, "RMS row offset     -")?,
        }
        let [before, after] = self.in_row.unwrap_or_default().map(|share| 100.0 * share);
        write!(
            f,
            "within {SCREEN_PX} px        {before:.1} % of all matches before, {after:.1} % after"
        )
    }
}
