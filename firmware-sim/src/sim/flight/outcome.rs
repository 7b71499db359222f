//! Summary of a flight: delays after the knock, and errors of the extrinsics in use.

use std::fmt;

use sim::run::Verdict;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Fused, State};

use super::Moment;

/// The figures of a flight. Angles in rad.
#[derive(Debug, PartialEq)]
pub(super) struct Outcome {
    /// Number of pairs until locked for the first time.
    locked: Option<usize>,
    /// Number of pairs from the knock until the state is no longer locked.
    detected: Option<usize>,
    /// Number of pairs from the knock until the estimate follows it.
    took_over: Option<usize>,
    /// Largest errors in use: from the first lock to the knock, from the knock to the take-over, and from the take-over
    /// on.
    worst: [Option<Deviation<f64>>; 3],
    last: Option<Last>,
}

/// The calibration after the last pair.
#[derive(Debug, PartialEq)]
struct Last {
    error: Deviation<f64>,
    sd: Option<Deviation<f64>>,
    rows_px: Option<f32>,
}

impl Outcome {
    /// Returns the figures of a flight.
    ///
    /// * `knock`: index of the first pair after the knock.
    pub(super) fn of(moments: &[Moment], knock: usize) -> Self {
        let locked = moments.iter().position(|m| m.state == State::Locked);
        let (before, after) = moments.split_at(knock.min(moments.len()));
        let took_over =
            after.iter().position(|m| m.verdict == Some(Verdict::Accepted(Fused::TookOver)));
        let detected = after.iter().position(|m| m.state != State::Locked);
        let settled = before.get(locked.unwrap_or(before.len())..).unwrap_or_default();
        let (between, recovered) = after.split_at(took_over.unwrap_or(after.len()));
        let last = moments.last();
        Self {
            locked: locked.map(|i| i + 1),
            detected: detected.map(|i| i + 1),
            took_over: took_over.map(|i| i + 1),
            worst: [settled, between, recovered].map(worst),
            last: last.map(|m| Last { error: m.error, sd: m.sd, rows_px: m.rows_px }),
        }
    }
}

fn worst(moments: &[Moment]) -> Option<Deviation<f64>> {
    moments.iter().map(|m| m.error).reduce(|a, b| Deviation {
        translation: a.translation.max(b.translation),
        rotation: a.rotation.max(b.rotation),
    })
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut pairs = |name: &str, count: Option<usize>, since: &str| match count {
            Some(count) => writeln!(f, "{name:<18} with pair {count} after {since}"),
            None => writeln!(f, "{name:<18} never after {since}"),
        };
        pairs("locked", self.locked, "take-off")?;
        pairs("knock detected", self.detected, "the knock")?;
        pairs("new rig taken over", self.took_over, "the knock")?;
        let degrees = |d: &Deviation<f64>| {
            format!("R {:.4} deg, t {:.4} deg", d.rotation.to_degrees(), d.translation.to_degrees())
        };
        let spans = ["locked, before the knock", "knock to take-over", "after take-over"];
        for (i, (worst, span)) in self.worst.iter().zip(spans).enumerate() {
            let name = if i == 0 { "worst error in use" } else { "" };
            writeln!(f, "{name:<18} {}  {span}", worst.as_ref().map_or("-".into(), degrees))?;
        }
        let Some(Last { error, sd, rows_px }) = &self.last else { return Ok(()) };
        write!(f, "final error in use {}", degrees(error))?;
        if let Some(sd) = sd {
            let [r, t] = [error.rotation / sd.rotation, error.translation / sd.translation];
            write!(f, "  {r:.1} and {t:.1} reported sd of {}", degrees(sd))?;
        }
        if let Some(px) = rows_px {
            write!(f, "\nrow offset in use  {px:.3} px RMS over the last pair's matches that fit")?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "the maximum is one of the numbers")]
mod tests {
    use super::*;

    fn moment(state: State, fused: Fused, error: f64) -> Moment {
        let error = Deviation { translation: 2.0 * error, rotation: error };
        Moment { verdict: Some(Verdict::Accepted(fused)), state, error, sd: None, rows_px: None }
    }

    #[test]
    fn pairs_are_counted_from_the_knock_and_errors_split_at_it() {
        let moments = [
            moment(State::Acquiring, Fused::Added, 9.0),
            moment(State::Locked, Fused::Added, 1.0),
            moment(State::Suspect, Fused::KeptApart, 5.0),
            moment(State::Suspect, Fused::KeptApart, 4.0),
            moment(State::Locked, Fused::TookOver, 2.0),
            moment(State::Locked, Fused::Added, 0.5),
        ];
        let outcome = Outcome::of(&moments, 2);
        assert_eq!([outcome.locked, outcome.detected, outcome.took_over], [2, 1, 3].map(Some));
        assert_eq!(outcome.worst.map(|worst| worst.unwrap().rotation), [1.0, 5.0, 2.0]);
    }

    #[test]
    fn events_that_never_happened_are_printed_as_never() {
        let outcome = Outcome::of(&[moment(State::Acquiring, Fused::Added, 1.0)], 1);
        let text = outcome.to_string();
        assert_eq!(text.matches("never").count(), 3, "{text}");
        assert!(Outcome::of(&[], 0).to_string().contains("never"));
    }
}
