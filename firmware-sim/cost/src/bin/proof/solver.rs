//! The batch, and the published solver and fusion, apart from the calibrator.

use core::hint::black_box;

use stereo_selfcal::batch::{Batch, RayPair};
use stereo_selfcal::outcome::Information;
use stereo_selfcal::paper::{Central, HuberSolver, MeanDirection, PaperCalibrator, Settings};
use stereo_selfcal::{Cameras, ConfigError, Correspondence, Extrinsics, PairReport};

use crate::{geometry, number, numbers, show};

pub(crate) fn all(cameras: &Cameras<f32>) {
    let mut batch = batch(cameras);
    let start = geometry::extrinsics().unwrap_or(Extrinsics::SIDE_BY_SIDE);
    let settings = settings().unwrap_or_default();
    facade(PaperCalibrator::new(settings, *cameras, start));
    if let Ok(mut solver) = HuberSolver::begin(&settings, number(), &start, batch.matches()) {
        while !solver.is_done() {
            show(solver.advance(batch.matches()));
        }
        if let Ok(report) = solver.report(batch.matches()) {
            information(&report.information);
            fusion(&report);
        }
    }
    batch.clear();
    show(batch.matches());
}

fn settings() -> Result<Settings, ConfigError> {
    Settings::DEFAULT
        .with_angle(central())
        .with_huber_threshold_px(number())?
        .with_max_passes(black_box(0))?
        .with_min_correspondences(black_box(0))?
        .with_noise_floor_px(number())?
        .with_step_tolerance_rad(number())?
        .with_max_sd_rad(number())?
        .with_max_correction_rad(number())
}

fn central() -> Central {
    if black_box(false) { Central::Mean } else { Central::Median }
}

fn facade(mut calibrator: PaperCalibrator<f32, 256>) {
    for _ in 0..black_box(0) {
        show(calibrator.push(&correspondence()));
        show(calibrator.take_pair([correspondence()]));
        show(calibrator.solve_pair());
        show(calibrator.advance_pair());
        show(calibrator.estimate());
        show(calibrator.has_valid_lengths());
        show(calibrator.batch().matches());
        calibrator.discard_pair();
        calibrator.reset();
    }
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
    let mut fusion = MeanDirection::new(central());
    for _ in 0..black_box(0) {
        fusion.add(report);
    }
    show(fusion.pairs());
    show(fusion.estimate());
}
