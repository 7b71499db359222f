//! One pair through the calibrator, every call measured.

use stereo_selfcal::link::MatchRecord;
use stereo_selfcal::{Correspondence, PairReport, Scalar, State};

use crate::calls::{self, Calibrated};
use crate::probe::{Probe, Sample};
use crate::scene::HEADER;
use crate::table::remark;

/// More calls than any pair takes.
const MAX_CALLS: usize = 256;

/// The dearest and the deepest of each call.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Calls {
    pub(crate) push: Sample,
    pub(crate) begin: Sample,
    /// But for the last of a pair.
    pub(crate) advance: Sample,
    /// The last of a pair: it judges.
    pub(crate) last: Sample,
    pub(crate) fuse: Sample,
    pub(crate) health: Sample,
    pub(crate) proposal: Sample,
    pub(crate) apply: Sample,
}

impl Calls {
    pub(crate) fn named(&self) -> [(&'static str, Sample); 8] {
        [
            ("push", self.push),
            ("begin_pair", self.begin),
            ("advance_pair", self.advance),
            ("advance_pair that judges", self.last),
            ("fuse", self.fuse),
            ("health", self.health),
            ("proposal", self.proposal),
            ("apply", self.apply),
        ]
    }

    /// The larger of each.
    pub(crate) fn most(&self, other: &Self) -> Self {
        Self {
            push: self.push.most(other.push),
            begin: self.begin.most(other.begin),
            advance: self.advance.most(other.advance),
            last: self.last.most(other.last),
            fuse: self.fuse.most(other.fuse),
            health: self.health.most(other.health),
            proposal: self.proposal.most(other.proposal),
            apply: self.apply.most(other.apply),
        }
    }
}

/// What one pair took.
pub(crate) struct PairCost {
    /// Before the pair.
    pub(crate) state: State,
    /// From `begin_pair` to `fuse`, instructions.
    pub(crate) update: u32,
    /// The second pass, instructions: the first that only adds up and steps.
    pub(crate) second: u32,
    pub(crate) calls: Calls,
}

/// Fills the batch; the dearest `push`.
///
/// # Panics
/// If a match is refused: the scene makes none that would be.
pub(crate) fn fill<T: Scalar>(
    probe: &Probe,
    calibrator: &mut Calibrated<T>,
    records: &[MatchRecord],
) -> Sample {
    calibrator.clear_pair();
    records.iter().fold(Sample::default(), |most, record| {
        let c = converted(&record.decode(&HEADER));
        let (pushed, sample) = probe.run(|| calls::push(calibrator, &c));
        pushed.expect("the match is inside both images");
        most.most(sample)
    })
}

/// Takes one pair in, and puts what is proposed into use where it may be.
pub(crate) fn take<T: Scalar>(
    probe: &Probe,
    calibrator: &mut Calibrated<T>,
    records: &[MatchRecord],
) -> PairCost {
    let state = calibrator.state();
    let mut calls = Calls { push: fill(probe, calibrator, records), ..Calls::default() };
    let (begun, sample) = probe.run(|| calls::begin(calibrator));
    calls.begin = sample;
    let mut update = sample.instructions;
    let mut second = 0;
    remark(format_args!("{state} {} begin {update}", records.len()));
    let report = begun.is_ok().then(|| {
        for call in 0..MAX_CALLS {
            let (advanced, sample) = probe.run(|| calls::advance(calibrator));
            remark(format_args!("  advance {}", sample.instructions));
            update += sample.instructions;
            if call == 0 {
                second = sample.instructions;
            }
            match advanced {
                Ok(None) => calls.advance = calls.advance.most(sample),
                Ok(Some(report)) => {
                    calls.last = sample;
                    return Some(report);
                }
                Err(error) => {
                    calls.last = sample;
                    remark(format_args!("  {error}"));
                    return None;
                }
            }
        }
        None
    });
    if let Some(report) = report.flatten() {
        calls.fuse = fused(probe, calibrator, &report);
        update += calls.fuse.instructions;
    }
    calls.health = probe.run(|| calls::health(calibrator)).1;
    calls.proposal = probe.run(|| calls::proposal(calibrator)).1;
    calls.apply = probe.run(|| calls::apply(calibrator)).1;
    remark(format_args!("  update {update}, {} after it", calibrator.state()));
    PairCost { state, update, second, calls }
}

fn fused<T: Scalar>(
    probe: &Probe,
    calibrator: &mut Calibrated<T>,
    report: &PairReport<T>,
) -> Sample {
    let (fused, sample) = probe.run(|| calls::fuse(calibrator, report));
    remark(format_args!("  fuse {}, taken in: {}", sample.instructions, fused.is_ok()));
    sample
}

/// The same in the scalar at hand, exact.
pub(crate) fn converted<T: Scalar>(c: &Correspondence<f32>) -> Correspondence<T> {
    let lit = |x: f32| T::lit(x.into());
    Correspondence {
        left: c.left.map(lit),
        right: c.right.map(lit),
        score: lit(c.score),
        grid_step: lit(c.grid_step),
    }
}
