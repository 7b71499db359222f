//! One pair: where it ends, what it reports, and that it can be taken a pass at a time.

use crate::scene::{calibrator, cameras, correspondences, rig};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, PairError, PairReport, Scalar, Stop};

const ROTATION: [f64; 3] = [3.0, -2.5, 4.0];
const BASELINE: [f64; 2] = [4.0, -3.0];

fn solved<T: Scalar>(noise_px: f64) -> PairReport<T> {
    let mut calibrator = calibrator::<T>();
    for c in correspondences(&rig(ROTATION, BASELINE), 256, noise_px, 1) {
        calibrator.push(&c).unwrap();
    }
    calibrator.solve_pair().unwrap()
}

#[test]
fn exact_correspondences_give_the_exact_rig() {
    let report = solved::<f64>(0.0);
    let error = Deviation::between(&report.extrinsics, &rig(ROTATION, BASELINE));
    assert!(error.translation < 1e-9 && error.rotation < 1e-9, "{error:?}");
    assert_eq!(report.stop, Stop::Converged);
    let error = Deviation::between(&solved::<f32>(0.0).extrinsics, &rig(ROTATION, BASELINE));
    assert!(error.translation < 2e-5 && error.rotation < 1e-5, "{error:?}");
}

#[test]
fn converges_in_few_passes_from_5_degrees_off_all_axes() {
    let report = solved::<f32>(0.5);
    assert_eq!(report.stop, Stop::Converged);
    assert!(report.passes <= 12, "{}", report.passes);
    assert!(report.cost_after < report.cost_before);
    assert!(report.rms_px_before > 50.0 && report.rms_px_after < 0.6, "{report:?}");
    // Uniform noise of +-0.5 px on two rows.
    assert!((report.noise_px / (0.5 * (2.0_f32 / 3.0).sqrt()) - 1.0).abs() < 0.15);
    assert_eq!([report.usable, report.skipped, report.screened], [256, 0, 256]);
}

#[test]
fn pass_by_pass_gives_the_same_bits_as_one_call() {
    let mut calibrator = calibrator::<f32>();
    for c in correspondences(&rig(ROTATION, BASELINE), 256, 0.5, 1) {
        calibrator.push(&c).unwrap();
    }
    assert_eq!(calibrator.advance_pair(), Err(PairError::NotBegun));
    let whole = calibrator.solve_pair().unwrap();
    calibrator.begin_pair().unwrap();
    let stepped = (0..101).find_map(|_| calibrator.advance_pair().unwrap()).unwrap();
    assert_eq!(stepped, whole);
    assert_eq!(calibrator.advance_pair(), Err(PairError::NotBegun));
}

#[test]
fn passes_are_bounded_and_what_they_reach_is_reported() {
    let config = Config::paper().with_max_passes(3).unwrap();
    let mut calibrator = Calibrator::<f32, 256>::new(config);
    calibrator.set_cameras(cameras());
    for c in correspondences(&rig(ROTATION, BASELINE), 256, 0.5, 1) {
        calibrator.push(&c).unwrap();
    }
    let report = calibrator.solve_pair().unwrap();
    assert_eq!((report.stop, report.passes), (Stop::PassLimit, 3));
    assert!(report.cost_after < report.cost_before);
}

#[test]
fn predicted_deviations_cover_the_errors() {
    let truth = rig::<f64>(ROTATION, BASELINE);
    let mut calibrator = calibrator::<f32>();
    let [mut chi2, trials] = [0.0, 200.0];
    for seed in 0..200 {
        for c in correspondences(&truth, 256, 0.5, seed) {
            calibrator.push(&c).unwrap();
        }
        let report = calibrator.solve_pair().unwrap();
        calibrator.clear_pair();
        let sd = report.information.standard_deviations().unwrap();
        let error = Deviation::between(&report.extrinsics, &rig(ROTATION, BASELINE));
        chi2 += f64::from((error.translation / sd.translation).powi(2)) / 2.0;
        chi2 += f64::from((error.rotation / sd.rotation).powi(2)) / 2.0;
    }
    // Mean of squared errors over predicted variances: 1 within sampling.
    assert!((chi2 / trials - 1.0).abs() < 0.2, "{}", chi2 / trials);
}

#[test]
fn a_calibrator_of_256_correspondences_fits_8_kib() {
    let bytes = size_of::<Calibrator<f32, 256>>();
    println!("Calibrator<f32, 256>: {bytes} bytes");
    assert!(bytes <= 8192);
}
