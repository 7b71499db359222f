//! Figures over many runs.

use sim::run::monte_carlo::Run;
use sim::stats::{mean, rms_deviation};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Fused, State};

/// Mean and largest number of passes of the pairs that started and ended in such a state.
pub(super) fn passes(runs: &[Run], state: impl Fn(State) -> bool) -> [f64; 2] {
    let mut all = Vec::new();
    for run in runs {
        let mut before = State::Acquiring;
        for after_pair in run.pairs.iter().flatten() {
            // A rejected pair takes more passes, and makes the state suspect.
            if state(before) && state(after_pair.state) {
                all.extend(after_pair.passes.map(f64::from));
            }
            before = after_pair.state;
        }
    }
    let most = all.iter().copied().fold(0.0, f64::max);
    [mean(all).unwrap_or(f64::NAN), most]
}

/// Changes of the estimate by change detection or by a challenger.
pub(super) fn changes(run: &Run, pairs: std::ops::Range<usize>) -> usize {
    let changed = |fused: Option<Fused>| matches!(fused, Some(Fused::Renewed | Fused::TookOver));
    run.pairs[pairs].iter().flatten().filter(|m| changed(m.fused)).count()
}

pub(super) fn alarms(runs: &[Run], from: usize) -> usize {
    runs.iter().map(|run| changes(run, from..run.pairs.len())).sum()
}

/// Pairs from a step to the first change of the estimate.
pub(super) fn found_after(run: &Run, step: usize) -> Option<usize> {
    (step..run.pairs.len()).find(|&at| changes(run, at..at + 1) > 0).map(|at| at - step + 1)
}

/// RMS error in use after so many pairs, and the worst error of an estimate over its reported sd.
pub(super) fn after(runs: &[Run], pairs: usize) -> Option<(Deviation<f64>, f64)> {
    let at: Vec<_> = runs.iter().filter_map(|run| *run.pairs.get(pairs.checked_sub(1)?)?).collect();
    let worst = at.iter().map(|m| m.error_in_sd).fold(0.0, f64::max);
    (!at.is_empty()).then(|| (rms_deviation(at.iter().map(|m| m.in_use)), worst))
}
