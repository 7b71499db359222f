//! The verdict on a rig, for users and scripts.

use std::fmt;

use anyhow::Result;
use serde::Serialize;
use sim::run::{Estimate, Recommendation, Summary};
use stereo_selfcal::{Cause, Reason, State};

use crate::coverage::Coverage;
use crate::moments;
use crate::session::Session;

/// RMS row offset from which on a matcher that searches along rows misses, px; the same limit as the core's default for
/// `Verdict::rows_px`.
const BAD_PX: f64 = 1.0;

/// The estimate improves the rows if its RMS row offset is below this share of the RMS row offset in use.
const IMPROVEMENT: f64 = 0.9;

/// Share of all matches in row with the estimate, below which the pairs count as fitting no rig.
const IN_ROW: f64 = 0.5;

/// Least number of pairs that must agree before the calibrator confirms an estimate.
const PAIRS_TO_AGREE: usize = 4;

/// Why a verdict is [`Recommendation::Unknown`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// There are fewer pairs than must agree.
    TooFewPairs,
    /// Left and right images show different moments.
    NotOneMoment,
    /// No pair has enough matches for an estimate.
    TooFewMatches,
    /// Most matches fit no rig: the lens is wrong, or pairs are mixed.
    NoRigFits,
    /// The pairs do not agree on an estimate.
    NotConfirmed,
    /// The calibrator names a cause.
    CauseNamed,
    /// The rows are right, but the calibrator would not arm.
    MustNotArm,
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewPairs => "too few pairs",
            Self::NotOneMoment => "left and right not of one moment",
            Self::TooFewMatches => "too few matches",
            Self::NoRigFits => "no rig fits",
            Self::NotConfirmed => "not confirmed",
            Self::CauseNamed => "a cause is named",
            Self::MustNotArm => "must not arm",
        })
    }
}

/// A verdict with its reasons and numbers: the JSON of `selfcal check`.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Recommended action.
    pub verdict: Recommendation,
    /// Why the verdict is unknown; null if it is known.
    pub unknown: Option<Unknown>,
    /// Reasons, the worst first.
    pub reasons: Vec<String>,
    /// Whether the intrinsics are a guess.
    pub rig_guessed: bool,
    /// Numbers of skipped items by reason, in words.
    pub skipped: String,
    /// Matches a pair, mean.
    pub matches_a_pair: f64,
    /// Shares of the matches within 3 px of their rows: in use, and with the estimate.
    pub in_row: Option<[f64; 2]>,
    /// Coverage by the matches, and its gaps.
    pub coverage: Option<Coverage>,
    /// All other numbers; `e_theta` and `e_t` are the distance of the estimate from the rig file, rad.
    #[serde(rename = "run")]
    pub summary: Summary,
}

impl Report {
    /// The verdict on a run.
    ///
    /// # Errors
    /// If the rig is not valid.
    pub fn of(session: &Session, guessed: bool) -> Result<Self> {
        let summary = session.log.summary(&session.set)?;
        let mut reasons = Vec::new();
        let verdict = verdict(session, &summary, &mut reasons);
        if session.pairs < moments::LEAST {
            reasons.push(format!(
                "not tested whether left and right show one moment: the test needs {} pairs",
                moments::LEAST
            ));
        }
        if guessed {
            reasons.push("the intrinsics are a guess: yaw and t cannot be trusted".into());
        }
        Ok(Self {
            verdict: verdict.unwrap_or(Recommendation::Unknown),
            unknown: verdict.err(),
            reasons,
            rig_guessed: guessed,
            skipped: session.skipped_in_words(),
            matches_a_pair: summary.matches as f64 / summary.pairs.max(1) as f64,
            in_row: summary.in_row,
            coverage: session.log.fused().and_then(|fused| Coverage::of(&session.set, fused)),
            summary,
        })
    }
}

fn verdict(
    session: &Session,
    summary: &Summary,
    reasons: &mut Vec<String>,
) -> Result<Recommendation, Unknown> {
    if let Some(shift) = session.shift {
        let pairs = match shift.pairs.abs() {
            1 => "1 pair".to_owned(),
            more => format!("{more} pairs"),
        };
        reasons.push(format!(
            "left and right show different moments: {} matches a pair fit the right image {pairs} {}, {} that of the pair",
            shift.shifted,
            if shift.pairs < 0 { "earlier" } else { "later" },
            shift.matches
        ));
        return Err(Unknown::NotOneMoment);
    }
    let cause = summary.verdict.as_ref().and_then(|judged| judged.cause.as_deref());
    let rows = summary.rms_px_before.zip(summary.rms_px_after).zip(summary.in_row);
    let (Some(fused), Some(((before, after), [_, in_row]))) = (session.log.fused(), rows) else {
        let Some(cause) = cause else {
            reasons.push(
                "no pair could be fused: too few matches, or all on one line or plane".into(),
            );
            return Err(Unknown::TooFewMatches);
        };
        reasons.push(format!("no pair could be fused; likely cause: {cause}"));
        return Err(Unknown::CauseNamed);
    };
    if in_row < IN_ROW {
        let share = 100.0 * in_row;
        reasons.push(format!(
            "only {share:.0} % of the matches fit any one rig: wrong lens, or pairs mixed"
        ));
        return Err(Unknown::NoRigFits);
    }
    if fused.state != State::Locked {
        let pairs = summary.pairs;
        reasons.push(format!(
            "not confirmed: {} after {pairs} pair{}; at least {PAIRS_TO_AGREE} must agree",
            fused.state,
            if pairs == 1 { "" } else { "s" }
        ));
        let few = pairs < PAIRS_TO_AGREE;
        return Err(if few { Unknown::TooFewPairs } else { Unknown::NotConfirmed });
    }
    reasons.extend(doubt_in_words(fused));
    let (verdict, reason) = of_rows(before, after);
    reasons.insert(0, reason);
    if let Some(cause) = cause {
        reasons.insert(0, format!("likely cause: {cause}"));
        let moments = cause == Cause::Moments.to_string();
        return Err(if moments { Unknown::NotOneMoment } else { Unknown::CauseNamed });
    }
    match &summary.verdict {
        // The rows are right, and the core knows why the calibration is not confirmed nevertheless.
        Some(judged) if verdict == Recommendation::Good && !judged.may_arm => {
            reasons.insert(0, judged.reasons.join(", "));
            Err(Unknown::MustNotArm)
        }
        _ => Ok(verdict),
    }
}

/// The doubt about an estimate, in words.
fn doubt_in_words(fused: &Estimate) -> Option<String> {
    match fused.doubt {
        // With a lens prior the disagreement only widens the deviations.
        Some(Reason::ImageHalves) if fused.lens.is_some() => Some(
            "image halves disagree, as with a wrong lens model: the deviations are widened".into(),
        ),
        Some(Reason::Biased) => Some("image halves disagree: the lens model does not fit".into()),
        Some(Reason::ImageHalves) => Some("image halves disagree: t is held".into()),
        Some(doubt) => Some(doubt.to_string()),
        None => None,
    }
}

/// The verdict by the RMS row offsets in use and with the estimate, px, and its reason.
fn of_rows(before: f64, after: f64) -> (Recommendation, String) {
    let both = format!("rows are {before:.2} px off, {after:.2} px with the estimate");
    if before >= BAD_PX {
        (Recommendation::Recalibrate, both)
    } else if after < IMPROVEMENT * before {
        (Recommendation::Improvable, both)
    } else {
        (
            Recommendation::Good,
            format!("rows are {before:.2} px off; the estimate does not improve them"),
        )
    }
}

impl fmt::Display for Report {
    /// The verdict in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { verdict, unknown, reasons, summary, .. } = self;
        let why = unknown.map(|why| format!(" ({why})")).unwrap_or_default();
        write!(f, "{verdict}{why}: {}", reasons.join("; "))?;
        if let Some(judged) = &summary.verdict {
            let arming = if judged.may_arm { "may arm" } else { "must not arm" };
            let px = |px: Option<f64>| px.map_or("-".into(), |px| format!("{px:.1} px"));
            let (rows, depth) = (px(judged.rows_px), px(judged.depth_px));
            write!(
                f,
                "; given rig, last pair: rows {rows}, depth {depth}, coverage {:.2}: {arming}",
                judged.coverage
            )?;
        }
        if let Some((theta, t)) = summary.e_theta.zip(summary.e_t) {
            let [theta, t] = [theta, t].map(f64::to_degrees);
            let sd = |sd: Option<f64>| sd.map_or(f64::NAN, f64::to_degrees);
            let [sd_r, sd_t] = [sd(summary.sd_rotation), sd(summary.sd_translation)];
            write!(
                f,
                "; turned by {theta:.3} deg (sd {sd_r:.3}), baseline by {t:.3} deg (sd {sd_t:.3}); {} of {} pairs",
                summary.accepted, summary.pairs
            )?;
        }
        if !self.skipped.is_empty() {
            write!(f, "; skipped: {}", self.skipped)?;
        }
        Ok(())
    }
}
