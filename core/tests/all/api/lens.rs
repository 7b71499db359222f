//! Wrong lens models: their estimate, and the deviations with the lens uncertain.

use crate::api::presets::{robust, with};
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Config, ConfigError, Correspondence, Extrinsics, LensPrior, Reason, State,
};

const CENTRE: [f32; 2] = [959.5, 599.5];

fn truth() -> Extrinsics<f64> {
    rig([1.0, -0.5, 0.8], [0.5, -0.4])
}

fn single() -> Extrinsics<f32> {
    rig([1.0, -0.5, 0.8], [0.5, -0.4])
}

/// A pair whose right camera has another lens than given.
///
/// * `focal`: relative error of the focal length.
/// * `k1`: error of the radial coefficient.
pub(crate) fn pair(focal: f32, k1: f32, seed: u64) -> Vec<Correspondence<f32>> {
    pair_of(&truth(), focal, k1, seed)
}

/// The pair of [`pair`] for another rig.
pub(crate) fn pair_of(
    rig: &Extrinsics<f64>,
    focal: f32,
    k1: f32,
    seed: u64,
) -> Vec<Correspondence<f32>> {
    let mut matches = correspondences(rig, 250, 0.5, seed);
    for c in &mut matches {
        let [x, y] = [0, 1].map(|i| (c.right[i] - CENTRE[i]) / 1400.0);
        let scale = (1.0 + focal) * (1.0 + k1 * (x * x + y * y));
        c.right = [x, y].map(|x| x * scale * 1400.0);
        (c.right[0], c.right[1]) = (c.right[0] + CENTRE[0], c.right[1] + CENTRE[1]);
    }
    matches
        .retain(|c| (0.0..=1919.0).contains(&c.right[0]) && (0.0..=1199.0).contains(&c.right[1]));
    matches
}

fn after(mut calibrator: Calibrator<f32, 256>, focal: f32, k1: f32) -> Calibrator<f32, 256> {
    for seed in 0..60 {
        take(&mut calibrator, &pair(focal, k1, seed)).unwrap();
    }
    assert_eq!(calibrator.state(), State::Locked);
    calibrator
}

#[test]
fn a_wrong_focal_length_is_found_named_and_covered_by_the_deviations() {
    let mut calibrator = after(robust(), 0.002, 0.0);
    let proposal = calibrator.proposal().unwrap();
    let lens = proposal.lens.unwrap();
    assert!((lens.focal.value - 0.002).abs() < 3.0 * lens.focal.sd, "{lens:?}");
    assert!(lens.focal.is_significant() && !lens.k1.is_significant(), "{lens:?}");
    assert!(lens.to_string().starts_with("focal lengths differ by 0.1"), "{lens}");
    let error = Deviation::between(&proposal.extrinsics, &single());
    let [given, wide] = [proposal.sd, proposal.sd_lens];
    assert!(error.translation > 2.0 * given.translation, "{error:?} {given:?}");
    assert!(error.translation < 2.0 * wide.translation, "{error:?} {wide:?}");
    assert!(error.rotation < 2.0 * wide.rotation, "{error:?} {wide:?}");
    assert!(calibrator.apply().is_ok());
    assert!(calibrator.proposal().unwrap().to_string().contains("focal lengths differ"));
    assert!(calibrator.verdict().reasons.contains(Reason::Lens));
}

#[test]
fn a_wrong_distortion_is_found() {
    let lens = after(robust(), 0.0, 0.003).proposal().unwrap().lens.unwrap();
    assert!(
        (lens.k1.value - 0.003).abs() < 3.0 * lens.k1.sd && lens.k1.is_significant(),
        "{lens:?}"
    );
    assert!(!lens.focal.is_significant(), "{lens:?}");
}

#[test]
fn a_right_lens_is_reported_as_given_and_its_uncertainty_only_widens_the_deviations() {
    let proposal = after(robust(), 0.0, 0.0).proposal().unwrap();
    assert_eq!(proposal.lens.unwrap().to_string(), "as given");
    assert!(proposal.sd_lens.rotation > proposal.sd.rotation);
    assert!(proposal.sd_lens.translation > proposal.sd.translation);
}

#[test]
fn an_exact_lens_has_no_estimate_and_the_same_extrinsics_and_deviations() {
    let exact = with(Config::robust().without_lens_prior());
    let exact = after(exact, 0.0, 0.0).proposal().unwrap();
    let uncertain = after(robust(), 0.0, 0.0).proposal().unwrap();
    assert_eq!((exact.lens, exact.sd_lens), (None, exact.sd));
    assert_eq!(exact.covariance_lens, exact.covariance);
    assert_eq!((exact.extrinsics, exact.sd), (uncertain.extrinsics, uncertain.sd));
}

#[test]
fn deviations_of_the_lens_that_are_out_of_range_are_refused() {
    let with = |prior| Config::robust().with_lens_prior(prior);
    assert!(with(LensPrior::WIDE).is_ok() && with(LensPrior::NONE).is_ok());
    for prior in [
        LensPrior { focal: -1e-3, ..LensPrior::WIDE },
        LensPrior { k1: f32::NAN, ..LensPrior::WIDE },
        LensPrior { principal_px: 1e3, ..LensPrior::WIDE },
        LensPrior { p1: 0.2, ..LensPrior::WIDE },
        LensPrior { p2: f32::INFINITY, ..LensPrior::WIDE },
    ] {
        assert_eq!(with(prior), Err(ConfigError::LensPrior), "{prior:?}");
    }
}
