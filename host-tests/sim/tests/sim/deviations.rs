//! Recorded pairs: reported deviations against the difference of two halves of the pairs, and the rating of the
//! calibration in use for any order of the pairs.

use rigs::data::{Dataset, Match};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, Proposal};

fn set(name: &str) -> Dataset {
    Dataset::load(&Dataset::shipped().join(name)).unwrap()
}

/// Estimate from pairs of a set, and whether to apply it after the last pair. The estimate is never
/// applied.
fn over<'a>(set: &Dataset, pairs: impl Iterator<Item = &'a Vec<Match>>) -> (Proposal<f32>, bool) {
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    let mut calibrator = Box::new(Calibrator::<f32, 2048>::new(Config::robust(), &factory));
    for pair in pairs {
        let _ = calibrator.take_pair(pair.iter().map(Match::correspondence));
    }
    (calibrator.proposal().unwrap(), calibrator.verdict().should_apply)
}

fn of_every_second(set: &Dataset, first: usize) -> Extrinsics<f64> {
    let (proposal, _) = over(set, set.pairs.iter().skip(first).step_by(2));
    rigs::data::in_f64(&proposal.extrinsics)
}

#[test]
fn reported_deviations_match_the_difference_of_two_halves_of_the_pairs() {
    // If the estimate from all pairs has the variance v, each half has 2 v, and their difference 4 v.
    let set = set("oak_sift");
    let [even, odd] = [0, 1].map(|first| of_every_second(&set, first));
    let shown = Deviation::between(&even, &odd).translation / 2.0;
    let (proposal, _) = over(&set, set.pairs.iter());
    let reported = f64::from(proposal.sd.translation);
    assert!(reported < 2.0 * shown && reported > shown / 2.0, "{reported} {shown}");
    // An error of the lens adds to the difference from the truth.
    let error = Deviation::between(&proposal.extrinsics, &set.truth().unwrap()).translation;
    assert!(error < 2.5 * proposal.sd_lens.translation, "{error} {:?}", proposal.sd_lens);
}

#[test]
fn the_order_of_pairs_does_not_decide_the_verdict() {
    let set = set("oak_sift");
    let (_, applies) = over(&set, set.pairs.iter());
    assert_eq!(over(&set, set.pairs.iter().rev()).1, applies);
    for first in 1..set.pairs.len() {
        let rotated = set.pairs.iter().cycle().skip(first).take(set.pairs.len());
        assert_eq!(over(&set, rotated).1, applies, "from pair {first} on");
    }
}
