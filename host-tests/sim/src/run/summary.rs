//! A whole run in numbers.

use std::fmt;

use anyhow::Result;
use nalgebra::{Matrix3, Rotation3};
use serde::Serialize;
use stereo_selfcal::Calibration;
use stereo_selfcal::batch::{RayPair, row_offset};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{LensCorrection, RectifyingRotations, so3};

use super::checked::Judged;
use super::depth_error::{
    DEPTHS_M, DepthErrors, ExpectedDepth, behind_infinity, calibration_in_use,
};
use super::estimate::{Lens, in_words};
use super::log::RunLog;
use super::reference::Reference;
use super::refused::{self, CountByReason, WitnessCounts};
use crate::stats::rms;
use rigs::data::{Dataset, Match};

/// Largest row offset, px, under the final estimate, of a match that counts in RMS row offsets: three Huber thresholds
/// of 1 px, as in the core for matches of little noise.
pub const SCREEN_PX: f64 = 3.0;

/// Least step of a grid that the text names, px: a finer one is harmless.
const NAMED_STEP_PX: f64 = 0.2;

/// Version of the fields of [`Summary`].
const SCHEMA: u32 = 2;

/// A verdict with its numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(clippy::struct_excessive_bools, reason = "each answers a question of its own")]
pub struct JudgedInWords {
    /// Row offset in use beyond that of the pair's own pose, px; `null` before the first solved pair.
    pub rows_px: Option<f64>,
    /// Expected error of the disparities in use, px; `null` without an estimate.
    pub depth_px: Option<f64>,
    /// Share of the matches that fit the calibration in use, among those that fit the pair's own pose.
    pub coverage: f64,
    /// Share of the image with matches that fit the pair's own pose.
    pub image_coverage: f64,
    /// Whether the rows are within their limit.
    pub rows_ok: bool,
    /// Whether the depth is within its limit.
    pub depth_ok: bool,
    /// Answer to an arming check.
    pub may_arm: bool,
    /// Whether applying the estimate is worthwhile.
    pub should_apply: bool,
    /// Reasons not to rely on the calibration in use, the worst first.
    pub reasons: Vec<String>,
    /// The likeliest mistake in rig file or matcher.
    pub cause: Option<String>,
}

impl JudgedInWords {
    pub(super) fn of(judged: &Judged) -> Self {
        let known = |px: f64| Some(px).filter(|px| px.is_finite());
        Self {
            rows_px: known(judged.rows_px),
            depth_px: known(judged.depth_px),
            coverage: judged.coverage,
            image_coverage: judged.image_coverage,
            rows_ok: judged.rows_ok,
            depth_ok: judged.depth_ok,
            may_arm: judged.may_arm,
            should_apply: judged.should_apply,
            reasons: judged.reasons.iter().map(|reason| reason.to_string()).collect(),
            cause: judged.cause.map(|cause| cause.to_string()),
        }
    }
}

impl fmt::Display for JudgedInWords {
    /// Writes two lines: rows, depth, coverage and arming; then reasons and cause, if there are any.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let px = |px: Option<f64>| px.map_or("-".into(), |px| format!("{px:.1} px"));
        let arming = if self.may_arm { "may arm" } else { "must not arm" };
        let (rows, depth) = (px(self.rows_px), px(self.depth_px));
        write!(f, "rows {rows}, depth {depth}, coverage {:.2}: {arming}", self.coverage)?;
        if self.should_apply {
            f.write_str(", should apply")?;
        }
        if !self.reasons.is_empty() {
            write!(f, "\nagainst it         {}", self.reasons.join(", "))?;
        }
        self.cause.as_ref().map_or(Ok(()), |cause| write!(f, "\nlikely cause       {cause}"))
    }
}

/// The stable fields of `--json`. Angles in rad; `null` before there is an estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Version of these fields: a change of the meaning of a field, or the loss of one, changes it.
    pub schema: u32,
    /// Pairs in the run.
    pub pairs: usize,
    /// Pairs fused.
    pub accepted: usize,
    /// Pairs not solved or not fused, by reason.
    pub rejected_pairs: CountByReason,
    /// Matches in all pairs.
    pub matches: usize,
    /// Refused matches by reason, without those left out of a full batch.
    pub refused_matches: CountByReason,
    /// `no estimate`, or the state of the calibrator and the doubt about the estimate.
    pub state: String,
    /// Origin of the errors of `R` and `t`.
    #[serde(skip)]
    pub reference: Reference,
    /// Error of the fused baseline direction.
    pub e_t: Option<f64>,
    /// Error of the fused rotation.
    pub e_theta: Option<f64>,
    /// RMS error of the baseline direction over pairs solved alone, each from the factory extrinsics.
    pub sigma_t: Option<f64>,
    /// RMS error of the rotation over the same pairs as `sigma_t`.
    pub sigma_theta: Option<f64>,
    /// Number of pairs with an estimate when solved alone.
    pub sigma_pairs: usize,
    /// RMS error of the baseline direction over the fused pairs as solved in the run. The robust preset starts a pair from
    /// the running estimate if there is one.
    pub tracked_t: Option<f64>,
    /// RMS error of the rotation over the same pairs as `tracked_t`.
    pub tracked_theta: Option<f64>,
    /// Fused rotation, row-major.
    #[serde(rename = "R")]
    pub r: Option<[f64; 9]>,
    /// Fused unit baseline direction.
    pub t: Option<[f64; 3]>,
    /// Reported standard deviation of the fused rotation, with the lens as given.
    pub sd_rotation: Option<f64>,
    /// Reported standard deviation of the fused baseline direction, with the lens as given.
    pub sd_translation: Option<f64>,
    /// RMS row offset of the factory extrinsics over the matches within [`SCREEN_PX`] of their row with the fused
    /// extrinsics, px.
    pub rms_px_before: Option<f64>,
    /// RMS row offset of the fused extrinsics over the same matches, px.
    pub rms_px_after: Option<f64>,
    /// Number of pairs that the row offsets cover: all pairs, or every 2nd, 4th, ... pair of a run too long to keep.
    pub rms_pairs: usize,
    /// Shares of all matches within [`SCREEN_PX`] of their row, with the factory extrinsics and with the fused ones.
    /// The RMS values cover only the matches that are in row with the fused ones.
    #[serde(skip)]
    pub in_row: Option<[f64; 2]>,
    /// Error of depth, if true depths are known.
    pub depth: Option<DepthErrors>,
    /// Error of depth that the calibrator expects; `null` unless locked.
    pub depth_expected: Option<ExpectedDepth>,
    /// Apparent yaw `a` of the lenses, rad: it offsets rows by `a x y`. `R` does not contain it, because depth needs
    /// the yaw of the mount.
    pub lens_yaw: Option<f64>,
    /// Standard deviation of `lens_yaw`, rad.
    pub lens_yaw_sd: Option<f64>,
    /// Expected error of the yaw in use, rad, with the lens uncertain, before the estimate of the last pair was
    /// applied: the error of depth is `Z^2 / b` times this.
    pub yaw_sd: Option<f64>,
    /// Results of range readings and of tracked matches.
    pub witnesses: WitnessCounts,
    /// Share of the matches in row that are behind infinity with the extrinsics in use: their disparity is -1 px or
    /// less.
    pub behind_infinity: Option<f64>,
    /// Extrinsics in use after the last pair.
    pub in_use: Option<InUse>,
    /// Step of the grid that the rows of the last pair lie on, px, stated or found: mean over its matches; 0 for
    /// continuous rows.
    pub grid_step_px: Option<f64>,
    /// The verdict after the last pair, on the calibration in use before the estimate was applied.
    pub verdict: Option<JudgedInWords>,
    /// Whether this verdict permits arming.
    pub armed: bool,
    /// Reasons against arming or against the estimate, and the likely cause.
    pub reasons: Vec<String>,
    /// First pair, from 0, after which the state was locked.
    pub locked_at: Option<usize>,
    /// Whether the pairs have determined the baseline direction.
    pub baseline_observed: bool,
    /// `sd_rotation` with the lens uncertain.
    pub sd_rotation_lens: Option<f64>,
    /// `sd_translation` with the lens uncertain.
    pub sd_translation_lens: Option<f64>,
    /// Lens errors that the pairs show; `null` without a lens prior.
    pub lens: Option<Lens>,
    /// Correction of the cameras that `R` and `t` belong to; zero if the lens is as given.
    pub correction: LensCorrection<f64>,
    /// RMS deviation of the rig's rotation from the estimate, from pair to pair, each axis; 0 without detected
    /// vibration.
    pub vibration_rotation: Option<f64>,
    /// RMS deviation of the baseline direction from the estimate, each of its two angles; 0 without detected vibration.
    pub vibration_translation: Option<f64>,
}

/// The extrinsics in use. Angles in rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InUse {
    /// Error of the baseline direction.
    pub e_t: Option<f64>,
    /// Error of the rotation.
    pub e_theta: Option<f64>,
    /// RMS row offset over the matches of `rms_px_before` and `rms_px_after`, px.
    pub rms_px: Option<f64>,
}

impl RunLog {
    /// The whole run in numbers.
    ///
    /// # Errors
    /// If the data set's cameras are not valid.
    pub fn summary(&self, set: &Dataset) -> Result<Summary> {
        let fused = self.fused();
        let totals = self.totals();
        let [tracked, sigma] = [totals.tracked, totals.alone].map(|squares| squares.root_mean());
        let error = fused.zip(self.truth());
        let error = error.map(|(f, truth)| Deviation::between(&f.extrinsics, truth));
        let checked = self.steps().last().and_then(|step| step.checked);
        let rows = self.row_offsets(set)?;
        let in_use = checked.map(|checked| InUse {
            e_t: checked.error.map(|e| e.translation),
            e_theta: checked.error.map(|e| e.rotation),
            rms_px: rows.map(|rows| rows.rms_px[2]),
        });
        Ok(Summary {
            schema: SCHEMA,
            pairs: totals.pairs,
            accepted: totals.accepted,
            rejected_pairs: totals.rejected,
            matches: totals.matches,
            refused_matches: totals.refused,
            state: fused.map_or_else(|| "no estimate".into(), ToString::to_string),
            reference: Reference::of(self.truth(), self.factory()),
            e_t: error.map(|e| e.translation),
            e_theta: error.map(|e| e.rotation),
            sigma_t: sigma.map(|s| s.translation),
            sigma_theta: sigma.map(|s| s.rotation),
            sigma_pairs: totals.alone_pairs,
            tracked_t: tracked.map(|s| s.translation),
            tracked_theta: tracked.map(|s| s.rotation),
            r: fused.map(|f| f.extrinsics.rotation_row_major()),
            t: fused.map(|f| f.extrinsics.translation().into_inner().into()),
            sd_rotation: fused.map(|f| f.sd.rotation),
            sd_translation: fused.map(|f| f.sd.translation),
            rms_px_before: rows.map(|rows| rows.rms_px[0]),
            rms_px_after: rows.map(|rows| rows.rms_px[1]),
            rms_pairs: set.pairs.len().min(totals.pairs),
            in_row: rows.map(|rows| rows.in_row),
            depth: None,
            depth_expected: ExpectedDepth::of(set, self)?,
            lens_yaw: fused.map(|f| f.lens_yaw.value),
            lens_yaw_sd: fused.map(|f| f.lens_yaw.sd),
            yaw_sd: checked.and_then(|checked| checked.details).map(|details| details.yaw_sd),
            witnesses: totals.witnessed,
            behind_infinity: behind_infinity(set, self)?,
            in_use,
            grid_step_px: checked.map(|checked| checked.grid_step_px),
            verdict: checked.map(|checked| JudgedInWords::of(&checked.judged)),
            armed: checked.is_some_and(|checked| checked.is_armed()),
            reasons: checked.map(|checked| checked.reasons()).unwrap_or_default(),
            locked_at: totals.locked_at,
            baseline_observed: fused.is_some_and(|f| f.baseline_observed),
            sd_rotation_lens: fused.map(|f| f.sd_lens.rotation),
            sd_translation_lens: fused.map(|f| f.sd_lens.translation),
            lens: fused.and_then(|f| f.lens),
            correction: fused.map_or(LensCorrection::NONE, |f| f.correction),
            vibration_rotation: fused.map(|f| f.vibration.rotation),
            vibration_translation: fused.map(|f| f.vibration.baseline),
        })
    }

    /// Row offsets of the factory extrinsics, the estimate and the calibration in use; `None` without an estimate, or
    /// if no match is within [`SCREEN_PX`] of its row with the estimate.
    fn row_offsets(&self, set: &Dataset) -> Result<Option<RowOffsets>> {
        let Some(fused) = self.fused() else { return Ok(None) };
        let factory = set.meta.calibration(self.factory(), &LensCorrection::NONE)?;
        let in_use = calibration_in_use(set, self)?;
        RowOffsets::over(set, &[factory, fused.calibration(set)?, in_use])
    }
}

/// Row offsets, px, of every correspondence of a data set under a calibration, pair by pair. `None` if a pixel has no
/// ray, or its ray points behind the rectified camera.
pub fn row_offsets_px(set: &Dataset, calibration: &Calibration<f64>) -> Vec<Vec<Option<f64>>> {
    let Calibration { cameras, extrinsics, .. } = calibration;
    let rotations = RectifyingRotations::from(extrinsics);
    let offset = |rays: &RayPair<f64>| Some(row_offset(&rotations, rays)? * cameras.mean_focal());
    let of_pair = |pair: &Vec<Match>| {
        let rays = pair.iter().map(|m| cameras.rays(&m.correspondence()).ok());
        rays.map(|rays| offset(&rays?)).collect()
    };
    set.pairs.iter().map(of_pair).collect()
}

/// Row offsets over a whole data set: before (factory extrinsics), after (estimate), and with the calibration in use.
#[derive(Debug, Clone, Copy)]
struct RowOffsets {
    /// RMS before, after and in use, px, over the matches within [`SCREEN_PX`] of their row after.
    rms_px: [f64; 3],
    /// Shares of all matches within [`SCREEN_PX`] of their row, before and after.
    in_row: [f64; 2],
}

impl RowOffsets {
    /// `None` if no match is within [`SCREEN_PX`] of its row after.
    ///
    /// * `calibrations`: before, after, in use.
    fn over(set: &Dataset, calibrations: &[Calibration<f64>; 3]) -> Result<Option<Self>> {
        let [before, after, in_use] = calibrations.each_ref().map(|c| row_offsets_px(set, c));
        let both = before.concat().into_iter().zip(after.concat()).zip(in_use.concat());
        let all: Vec<_> = both.map(|((before, after), used)| [before, after, used]).collect();
        let near = |px: Option<f64>| px.is_some_and(|px| px.abs() <= SCREEN_PX);
        let screened: Vec<[f64; 3]> = all
            .iter()
            .filter(|[_, after, _]| near(*after))
            .filter_map(|&[before, after, in_use]| Some([before?, after?, in_use?]))
            .collect();
        let [Some(before), Some(after), Some(in_use)] =
            [0, 1, 2].map(|i| rms(screened.iter().map(|px| px[i])))
        else {
            return Ok(None);
        };
        let count = |n: usize| Ok::<f64, anyhow::Error>(u32::try_from(n)?.into());
        let whole = count(all.len())?;
        let in_row = |i: usize| count(all.iter().filter(|e| near(e[i])).count());
        let in_row = [in_row(0)? / whole, in_row(1)? / whole];
        Ok(Some(Self { rms_px: [before, after, in_use], in_row }))
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "pairs fused        {} of {} ({})", self.accepted, self.pairs, self.state)?;
        if !self.rejected_pairs.is_empty() {
            writeln!(f, "pairs not fused    {}", refused::in_words(&self.rejected_pairs))?;
        }
        if !self.refused_matches.is_empty() {
            let refused: usize = self.refused_matches.values().sum();
            let why = refused::in_words(&self.refused_matches);
            writeln!(f, "matches refused    {refused} of {}: {why}", self.matches)?;
        }
        if self.reference == Reference::None {
            writeln!(f, "reference          none: no errors")?;
        }
        self.write_pose(f)?;
        if self.reference == Reference::None {
            let Self { sigma_pairs, pairs, .. } = self;
            writeln!(f, "pairs alone        {sigma_pairs} of {pairs} have an estimate")?;
        } else {
            self.write_errors(f)?;
        }
        // The tables in `golden` have these words.
        write_angle(f, "sd of t, claimed", "as the estimate reports", self.sd_translation)?;
        write_angle(f, "sd of R, claimed", "as the estimate reports", self.sd_rotation)?;
        if !self.correction.is_none() {
            writeln!(f, "cameras corrected  {}", in_words(&self.correction))?;
        }
        self.write_rows(f)?;
        for (name, counts) in
            [("range readings", &self.witnesses.ranges), ("tracked motion", &self.witnesses.motion)]
        {
            if !counts.is_empty() {
                write!(f, "\n{name:<19}{}", refused::in_words(counts))?;
            }
        }
        if let Some(share) = self.behind_infinity.filter(|share| *share > 0.0) {
            write!(
                f,
                "\nbehind infinity    {:.1} % of the matches in row: disparity -1 px or less, in use",
                100.0 * share
            )?;
        }
        if let Some(expected) = self.depth_expected {
            let ExpectedDepth { before_px, estimate_px, in_use_px, in_use_m, .. } = expected;
            write!(
                f,
                "\ndepth, expected    {before_px:.3} px before, {estimate_px:.3} px with the estimate, {in_use_px:.3} px in use",
            )?;
            if let Some([near, far]) = in_use_m {
                let [z, far_z] = DEPTHS_M;
                write!(f, ": {near:.3} m at {z} m, {far:.3} m at {far_z} m")?;
            }
        }
        if let Some(DepthErrors { before_px, in_use_px, reference_px, .. }) = self.depth {
            write!(f, "\ndepth error        {before_px:.3} px before, {in_use_px:.3} px in use")?;
            if let Some(px) = reference_px {
                write!(f, ", {px:.3} px with the reference")?;
            }
        }
        if let Some(px) = self.grid_step_px.filter(|px| *px >= NAMED_STEP_PX) {
            write!(f, "\ngrid of the rows   {px:.2} px, stated or found, mean over the last pair")?;
        }
        self.verdict.as_ref().map_or(Ok(()), |verdict| write!(f, "\nverdict            {verdict}"))
    }
}

impl Summary {
    fn write_errors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = self.reference.words();
        write_angle(f, "e_t", &format!("fused baseline direction {from}"), self.e_t)?;
        write_angle(f, "e_theta", &format!("fused rotation {from}"), self.e_theta)?;
        let alone = format!("pairs alone, RMS over {} of {}", self.sigma_pairs, self.pairs);
        write_angle(f, "sigma_t", &alone, self.sigma_t)?;
        write_angle(f, "sigma_theta", &alone, self.sigma_theta)?;
        write_angle(f, "tracked t", "pairs as solved in the run, RMS", self.tracked_t)?;
        write_angle(f, "tracked R", "pairs as solved in the run, RMS", self.tracked_theta)
    }

    fn write_pose(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(r) = self.r {
            let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&r));
            let [x, y, z] = so3::log(&rotation).map(f64::to_degrees).into();
            writeln!(f, "R                  ({x:.4}, {y:.4}, {z:.4}) deg, a rotation vector")?;
        }
        if let Some([x, y, z]) = self.t {
            writeln!(f, "t                  ({x:.6}, {y:.6}, {z:.6})")?;
        }
        Ok(())
    }

    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pairs, rms_pairs, .. } = self;
        let over = if rms_pairs < pairs {
            format!(", over {rms_pairs} of {pairs} pairs")
        } else {
            String::new()
        };
        match self.rms_px_before.zip(self.rms_px_after) {
            Some((before, after)) => {
                writeln!(f, "RMS row offset     {before:.3} px before, {after:.3} px after{over}")?;
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

fn write_angle(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    what: &str,
    angle: Option<f64>,
) -> fmt::Result {
    match angle {
        Some(rad) => {
            writeln!(f, "{name:<18} {rad:>9.6} rad  {:>8.4} deg   {what}", rad.to_degrees())
        }
        None => writeln!(f, "{name:<18} {:>9}                     {what}", "-"),
    }
}
