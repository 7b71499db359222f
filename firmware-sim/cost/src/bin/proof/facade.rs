//! The calibrator.

use core::hint::black_box;

use stereo_selfcal::outcome::{Change, Event, History};
use stereo_selfcal::{Calibrator, Cameras, Config, Reason, has_valid_lengths};

use crate::{memory, number, show, solver, store, witness};

pub(crate) fn all(config: Config, cameras: Cameras<f32>) {
    let made = memory::made(cameras);
    let mut calibrator = Calibrator::<f32, 256>::new(config, &made);
    while black_box(true) {
        for _ in 0..black_box(0) {
            show(calibrator.push(&solver::correspondence()));
        }
        pair(&mut calibrator);
        judge(&mut calibrator);
        witness::all(&mut calibrator);
        memory::all(&mut calibrator);
        store::all(&mut calibrator);
        if black_box(false) {
            calibrator.reset();
        }
    }
}

fn pair(calibrator: &mut Calibrator<f32, 256>) {
    let outcome = calibrator.solve_pair();
    show(outcome.pair.map(|report| report.stop.code()));
    show(outcome.fused.map_err(|error| error.code()));
    show(calibrator.advance_pair());
    let matches = black_box([solver::correspondence(); 16]);
    let length = black_box(0);
    show(calibrator.take_pair(matches.get(..length).unwrap_or_default().iter().copied()));
}

fn judge(calibrator: &mut Calibrator<f32, 256>) {
    show(calibrator.state());
    if let Some(proposal) = calibrator.proposal() {
        show(proposal.weakest());
        show(proposal.reasons().bits());
        show(proposal.correction.is_none());
        show(calibrator.in_use().cameras.corrected(&proposal.correction));
        if let Some(lens) = &proposal.lens {
            show((lens.is_significant(), lens.focal.is_significant()));
        }
        show(proposal);
    }
    if let Some(details) = calibrator.details() {
        show(details.depth_errors(number()));
        show(details);
    }
    let verdict = calibrator.verdict();
    let reasons = verdict.reasons;
    show((reasons.contains(Reason::Lens), reasons.is_empty(), reasons.bits()));
    show(reasons.iter().next());
    show(verdict);
    note(calibrator);
    show(calibrator.apply());
    show(calibrator.undo());
    calibrator.set_frozen(black_box(false));
    show(has_valid_lengths(calibrator));
    show(calibrator.in_use());
    show(calibrator.in_use().homographies(number()));
    show(calibrator.batch());
    show(calibrator.clone());
    calibrator.discard_pair();
}

fn note(calibrator: &Calibrator<f32, 256>) {
    let mut history = black_box(History::<f32, 8>::new());
    let (time, pair) = black_box((0, 0));
    let generation = calibrator.in_use().generation;
    show(Event::START.next(time, pair, calibrator.verdict(), generation));
    if let Some(event) = history.note(time, pair, calibrator.verdict(), generation) {
        let changes = event.changes;
        show((changes.is_empty(), changes.contains(Change::State), changes.bits()));
        show(changes.iter().next().map(|change| change.code()));
    }
    history.events().for_each(show);
    show(history.total());
}
