//! The batch, and the published solver and fusion, apart from the calibrator.

use core::hint::black_box;

use stereo_selfcal::batch::{Batch, RayPair};
use stereo_selfcal::outcome::Information;
use stereo_selfcal::paper::{Central, HuberSolver, MeanDirection};
use stereo_selfcal::{Cameras, Config, Correspondence, Extrinsics, PairReport};

use crate::{geometry, number, numbers, show};

pub(crate) fn all(config: Config, cameras: &Cameras<f32>) {
    let mut batch = batch(cameras);
    let start = geometry::extrinsics().unwrap_or(Extrinsics::SIDE_BY_SIDE);
    if let Ok(mut solver) = HuberSolver::begin(&config, number(), &start, batch.pairs()) {
        while !solver.is_done() {
            show(solver.advance(batch.pairs()));
        }
        if let Ok(report) = solver.report(batch.pairs()) {
            information(&report.information);
            fusion(&report);
        }
    }
    batch.clear();
    show(batch.pairs());
}

pub(crate) fn correspondence() -> Correspondence<f32> {
    Correspondence { left: numbers(), right: numbers(), score: number(), grid_step: number() }
}

fn batch(cameras: &Cameras<f32>) -> Batch<f32, 256> {
    let mut batch = if black_box(false) { Batch::new() } else { Batch::default() };
    for _ in 0..black_box(0) {
        show(batch.push(cameras, &correspondence()));
    }
    show(batch.offered());
    show(batch.left_out());
    show(batch.refused());
    if let Ok(pair) = cameras.rays(&correspondence()) {
        of_rays(&pair);
    }
    if let Some(pair) = RayPair::try_new(numbers(), numbers()) {
        of_rays(&pair);
    }
    batch
}

fn of_rays(pair: &RayPair<f32>) {
    show(pair.left());
    show(pair.right());
    show(pair.score());
    show(pair.grid_step());
}

fn information(information: &Information<f32>) {
    show(information.matrix());
    show(information.covariance());
    show(information.standard_deviations());
    show(information.weakest());
    show(Information::<f32>::default());
}

fn fusion(report: &PairReport<f32>) {
    let mut fusion =
        MeanDirection::new(if black_box(false) { Central::Mean } else { Central::Median });
    for _ in 0..black_box(0) {
        fusion.add(report);
    }
    show(fusion.pairs());
    show(fusion.estimate());
}
