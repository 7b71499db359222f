//! The calibrator.

use core::hint::black_box;

use stereo_selfcal::{Calibrator, Cameras, Config, Extrinsics, Reason};

use crate::{geometry, memory, number, show, solver, store, witness};

pub(crate) fn all(config: Config, cameras: Cameras<f32>) {
    let mut calibrator = Calibrator::<f32, 256>::new(config);
    calibrator.set_cameras(cameras);
    calibrator.set_factory(geometry::extrinsics().unwrap_or(Extrinsics::SIDE_BY_SIDE));
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
    match calibrator.solve_pair() {
        Ok(report) => {
            show(report.stop.code());
            show(calibrator.fuse().map_err(|error| error.code()));
        }
        Err(error) => show(error.code()),
    }
    show(calibrator.begin_pair());
    if let Ok(Some(report)) = calibrator.advance_pair() {
        show(report);
        show(calibrator.fuse());
    }
}

fn judge(calibrator: &mut Calibrator<f32, 256>) {
    show(calibrator.state());
    if let Some(proposal) = calibrator.proposal() {
        show(proposal.weakest());
        show(proposal.correction.is_none());
        show(calibrator.cameras().map(|cameras| cameras.corrected(&proposal.correction)));
        if let Some(lens) = &proposal.lens {
            show((lens.is_significant(), lens.focal.is_significant()));
        }
        show(proposal);
    }
    if let Ok(health) = calibrator.health() {
        show(health.depth_errors(number()));
        let reasons = health.reasons;
        show((reasons.contains(Reason::Lens), reasons.is_empty(), reasons.bits()));
        show(reasons.iter().next());
        show(health);
    }
    show(calibrator.likely_cause());
    show(calibrator.apply());
    show(calibrator.undo());
    calibrator.set_frozen(black_box(false));
    calibrator.set_angular_rate(number());
    show(calibrator.is_frozen());
    show(calibrator.has_valid_lengths());
    show(&calibrator.in_use().extrinsics);
    show(calibrator.in_use());
    show(calibrator.in_use().generation);
    show(calibrator.batch());
    show(calibrator.cameras());
    show(calibrator.clone());
    calibrator.discard_pair();
}
