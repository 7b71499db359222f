//! The published method through its facade, on generated rigs.

mod bad_input;
mod fusion;
mod solver;
// As the traces of the calibrator, this one holds for glibc.
#[cfg(target_env = "gnu")]
mod trace;

use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Correspondence, Extrinsics, Outcome, Scalar};

use crate::api::scene::cameras;

/// Calibrator of the published method that starts from a guess.
fn published<T: Scalar>() -> PaperCalibrator<T, 256> {
    with(Settings::DEFAULT)
}

/// As [`published`], with other settings.
fn with<T: Scalar>(settings: Settings) -> PaperCalibrator<T, 256> {
    PaperCalibrator::new(settings, cameras(), Extrinsics::SIDE_BY_SIDE)
}

/// Takes a pair, each of whose correspondences is valid.
fn take<T: Scalar>(
    calibrator: &mut PaperCalibrator<T, 256>,
    matches: &[Correspondence<T>],
) -> Outcome<T> {
    let outcome = calibrator.take_pair(matches.iter().copied());
    assert_eq!(calibrator.batch().refused(), 0);
    outcome
}

#[cfg(feature = "serde")]
#[test]
fn settings_come_back_and_are_checked() {
    let good = serde_json::to_string(&Settings::DEFAULT).unwrap();
    assert_eq!(serde_json::from_str::<Settings>(&good).unwrap(), Settings::DEFAULT);
    for (number, absurd, named) in [
        ("0.12", "-0.12", "standard deviation"),
        (":100,", ":1,", "pass"),
        ("0.5", "1.6", "correction"),
    ] {
        assert!(good.contains(number), "{good}");
        let bad = good.replacen(number, absurd, 1);
        let message = serde_json::from_str::<Settings>(&bad).unwrap_err().to_string();
        assert!(message.contains(named), "{message}");
    }
}
