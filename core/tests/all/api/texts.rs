//! Texts of the results: one line each, with units.

use crate::api::presets::robust;
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::batch::Pushed;
use stereo_selfcal::geometry::{ExtrinsicsError, so3};
use stereo_selfcal::outcome::Stop;
use stereo_selfcal::{Extrinsics, Fused, State};

#[test]
fn results_are_one_line_with_units() {
    let mut calibrator = robust::<f32>();
    let truth = rig([1.0, -0.5, 0.8], [0.5, -0.4]);
    let matches = |seed| correspondences(&truth, 250, 0.5, seed);
    for seed in 0..4 {
        take(&mut calibrator, &matches(seed)).unwrap();
    }
    let outcome = calibrator.take_pair(matches(4));
    assert_eq!(outcome.to_string(), "added");
    let verdict = calibrator.verdict().to_string();
    let proposal = calibrator.proposal().unwrap().to_string();
    let pair = outcome.pair.unwrap().to_string();
    assert!(verdict.starts_with("rows "), "{verdict}");
    assert!(verdict.contains(" px, coverage 0.00: must not arm, should apply, "), "{verdict}");
    assert!(verdict.contains("against it: in use not confirmed by the last pairs"), "{verdict}");
    assert!(
        proposal.starts_with("locked: R 0.017") && proposal.contains(", 5 pairs, weakest "),
        "{proposal}"
    );
    assert!(pair.ends_with("0 skipped, 4 passes"), "{pair}");
    assert_eq!(outcome.pair.unwrap().stop, Stop::PassesSpent);
    for (text, unit) in [(verdict, " px"), (proposal, " rad"), (pair, " rad")] {
        assert!(text.contains(unit) && !text.contains('\n'), "{text}");
    }
}

#[test]
fn names_are_padded_like_other_text() {
    let texts =
        [State::Lost.to_string(), Fused::KeptApart.to_string(), Stop::NoDescent.to_string()];
    assert_eq!(texts, ["lost", "kept apart", "no descent"]);
    assert_eq!(format!("{:>8}|{:<8}|", Pushed::Kept, State::Locked), "    kept|locked  |");
}

#[test]
fn extrinsics_from_rows_match_the_matrix() {
    let given: Extrinsics<f64> = rig([3.0, -2.0, 4.0], [3.0, -3.0]);
    let t = given.translation().into_inner() * 0.12;
    let r = given.rotation_row_major();
    let found = Extrinsics::from_row_major(r, t.into()).unwrap();
    let off = so3::log(&(found.rotation().inverse() * given.rotation())).norm();
    assert!(off < 1e-15 && (found.translation().into_inner() * 0.12 - t).norm() < 1e-15);
    let [a, b, c, d, e, f, g, h, i] = r;
    let transposed = Extrinsics::from_row_major([a, d, g, b, e, h, c, f, i], t.into()).unwrap();
    assert!(so3::log(&(transposed.rotation() * given.rotation())).norm() < 1e-15);
    let reflected = Extrinsics::from_row_major([-a, -b, -c, d, e, f, g, h, i], t.into());
    assert_eq!(reflected, Err(ExtrinsicsError::NotARotation));
}
