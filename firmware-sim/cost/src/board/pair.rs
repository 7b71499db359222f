//! Processes one pair and measures every call.

use stereo_selfcal::link::MatchRecord;
use stereo_selfcal::{Correspondence, Scalar, State};

use crate::calls::{self, CalibratorOf};
use crate::probe::{Probe, Sample};
use crate::scene::HEADER;

/// Largest number of calls per pair, more than any pair takes.
const MAX_CALLS: usize = 256;

/// Largest instructions and stack of each call.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Calls {
    pub(crate) push: Sample,
    pub(crate) begin: Sample,
    /// Calls between the first one and the last three.
    pub(crate) advance: Sample,
    /// The third last call: it takes the last pass, which evaluates the pair.
    pub(crate) last: Sample,
    /// The call before the last one.
    pub(crate) fuse: Sample,
    /// The last call, which forms the verdict.
    pub(crate) judge: Sample,
    pub(crate) details: Sample,
    pub(crate) proposal: Sample,
    pub(crate) apply: Sample,
}

impl Calls {
    pub(crate) fn named(&self) -> [(&'static str, Sample); 9] {
        [
            ("push", self.push),
            ("advance_pair that begins", self.begin),
            ("advance_pair", self.advance),
            ("advance_pair that evaluates", self.last),
            ("advance_pair that fuses", self.fuse),
            ("advance_pair that judges", self.judge),
            ("details", self.details),
            ("proposal", self.proposal),
            ("apply", self.apply),
        ]
    }

    /// The larger value of each.
    pub(crate) fn max(&self, other: &Self) -> Self {
        Self {
            push: self.push.max(other.push),
            begin: self.begin.max(other.begin),
            advance: self.advance.max(other.advance),
            last: self.last.max(other.last),
            fuse: self.fuse.max(other.fuse),
            judge: self.judge.max(other.judge),
            details: self.details.max(other.details),
            proposal: self.proposal.max(other.proposal),
            apply: self.apply.max(other.apply),
        }
    }
}

/// Cost of one pair.
pub(crate) struct PairCost {
    /// State before the pair.
    pub(crate) state: State,
    /// Instructions of all calls of `advance_pair`.
    pub(crate) update: u32,
    /// Instructions of the second pass, the first without the start of the pair.
    pub(crate) second: u32,
    pub(crate) calls: Calls,
}

/// Fills the batch. Returns the largest cost of a `push`.
///
/// # Panics
/// If a match is refused. All matches of the scene are inside both images.
pub(crate) fn fill<T: Scalar>(
    probe: &Probe,
    calibrator: &mut CalibratorOf<T>,
    records: &[MatchRecord],
) -> Sample {
    calibrator.discard_pair();
    records.iter().fold(Sample::default(), |largest, record| {
        let c = converted(&record.decode(&HEADER));
        let (pushed, sample) = probe.run(|| calls::push(calibrator, &c));
        pushed.expect("the match is inside both images");
        largest.max(sample)
    })
}

/// Fills the batch, processes the pair and applies the proposal where possible.
pub(crate) fn process<T: Scalar>(
    probe: &Probe,
    calibrator: &mut CalibratorOf<T>,
    records: &[MatchRecord],
) -> PairCost {
    let push = fill(probe, calibrator, records);
    let mut cost = update(probe, calibrator);
    cost.calls.push = push;
    cost
}

/// Processes the batch, and applies the proposal if possible.
pub(crate) fn update<T: Scalar>(probe: &Probe, calibrator: &mut CalibratorOf<T>) -> PairCost {
    let state = calibrator.state();
    let mut calls = Calls::default();
    let (mut outcome, sample) = probe.run(|| calls::advance(calibrator));
    calls.begin = sample;
    let mut update = sample.instructions;
    let mut second = 0;
    for call in 0..MAX_CALLS {
        if outcome.is_some() {
            break;
        }
        let (advanced, sample) = probe.run(|| calls::advance(calibrator));
        update += sample.instructions;
        if call == 0 {
            second = sample.instructions;
        }
        outcome = advanced;
        calls.advance = calls.advance.max(calls.last);
        (calls.last, calls.fuse, calls.judge) = (calls.fuse, calls.judge, sample);
    }
    if outcome.is_none_or(|outcome| outcome.pair.is_none()) {
        // A pair without a solution ends after a pass with the verdict.
        calls.advance = calls.advance.max(calls.last).max(calls.fuse);
        (calls.last, calls.fuse) = Default::default();
    }
    calls.details = probe.run(|| calls::details(calibrator)).1;
    calls.proposal = probe.run(|| calls::proposal(calibrator)).1;
    calls.apply = probe.run(|| calls::apply(calibrator)).1;
    PairCost { state, update, second, calls }
}

/// Converts a match to the measured scalar, exactly.
pub(crate) fn converted<T: Scalar>(c: &Correspondence<f32>) -> Correspondence<T> {
    let lit = |x: f32| T::lit(x.into());
    Correspondence {
        left: c.left.map(lit),
        right: c.right.map(lit),
        score: lit(c.score),
        grid_step: lit(c.grid_step),
    }
}

/// Instructions of one pair of the published method.
pub(crate) struct PublishedCost {
    /// All calls of `advance_pair`.
    pub(crate) update: u32,
    /// The second pass, the first without the start of the pair.
    pub(crate) second: u32,
    /// The last call, which evaluates and fuses the pair.
    pub(crate) last: u32,
}

/// Fills the batch of the published method and processes the pair.
///
/// # Panics
/// If a match is refused. All matches of the scene are inside both images.
pub(crate) fn published<T: Scalar>(probe: &Probe, records: &[MatchRecord]) -> PublishedCost {
    let mut calibrator = calls::published::<T>();
    for record in records {
        let pushed = calibrator.push(&converted(&record.decode(&HEADER)));
        pushed.expect("the match is inside both images");
    }
    let mut cost = PublishedCost { update: 0, second: 0, last: 0 };
    for call in 0..MAX_CALLS {
        let (outcome, sample) = probe.run(|| calls::advance_published(&mut calibrator));
        cost.update += sample.instructions;
        cost.last = sample.instructions;
        if call == 1 {
            cost.second = sample.instructions;
        }
        if outcome.is_some() {
            break;
        }
    }
    cost
}
