//! Far scenes determine `R`, and the baseline only where disparities exceed their noise.

use crate::api::disturbed::with_outliers;
use crate::api::presets::robust;
use crate::api::scene::{correspondences, correspondences_within, rig, take};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Correspondence, Reason, Rejection, State};
use test_support::runs;

/// True rotation, degrees: 1.4 degrees from the factory `R`. The true `t` is half a degree from the factory `t`.
const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.4, -0.3];

type Rig = Calibrator<f32, 256>;

/// `n` matches 1000 to 10,000 baselines away, in random order. One match in `one_in` is an outlier.
fn far(n: usize, one_in: usize, seed: u64) -> Vec<Correspondence<f32>> {
    let rig = rig(ROTATION, BASELINE);
    let matches = correspondences_within(&rig, [1000.0, 10_000.0], n, 0.5, seed);
    let mut matches = with_outliers(matches, one_in);
    matches.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    matches
}

fn off(calibrator: &Rig) -> Deviation<f32> {
    let extrinsics = calibrator.proposal().unwrap().extrinsics;
    Deviation::between(&extrinsics, &rig(ROTATION, BASELINE))
}

#[test]
fn a_far_scene_locks_by_its_rotation_and_keeps_the_baseline_in_use() {
    let mut calibrator = robust::<f32>();
    let factory = calibrator.in_use().extrinsics;
    for seed in 0..30 {
        take(&mut calibrator, &far(250, 4, seed)).unwrap();
        let proposal = calibrator.proposal().unwrap();
        assert!(
            !proposal.baseline_observed && calibrator.verdict().reasons.contains(Reason::Baseline),
            "{seed}"
        );
    }
    assert_eq!(calibrator.state(), State::Locked);
    let sd = calibrator.proposal().unwrap().sd;
    assert!(off(&calibrator).rotation < 4.0 * sd.rotation && sd.rotation < 2e-4, "{sd:?}");
    let applied = calibrator.apply().unwrap().extrinsics;
    assert_eq!(applied.translation(), factory.translation());
    // The applied `R` is the best one for this `t`. In far scenes it is nearly the same for any `t`.
    let rotation = Deviation::between(&applied, &rig(ROTATION, BASELINE)).rotation;
    assert!(rotation < 4.0 * sd.rotation, "{rotation} {sd:?}");
}

/// The baseline is observed up to a standard deviation of half of the factory deviation of an angle (0.05 rad), and
/// applied in any case up to a quarter of it (0.025 rad).
#[test]
fn a_baseline_between_observed_and_certain_is_applied_if_the_one_in_use_differs() {
    for (off_deg, is_applied) in [(8.0, true), (0.4, false)] {
        let truth = rig(ROTATION, [off_deg, BASELINE[1]]);
        let mut calibrator = robust::<f32>();
        for seed in 0..6 {
            take(&mut calibrator, &correspondences_within(&truth, [300.0, 1200.0], 250, 0.5, seed))
                .unwrap();
        }
        let proposal = calibrator.proposal().unwrap();
        assert!((0.025..0.05).contains(&proposal.sd_lens.translation), "{:?}", proposal.sd_lens);
        let in_use = calibrator.in_use().extrinsics;
        let [applicable, best, in_use] =
            [proposal.applicable, proposal.extrinsics, in_use].map(|found| *found.translation());
        assert_eq!([applicable == best, applicable == in_use], [is_applied, !is_applied]);
    }
}

/// The baseline is observed up to a standard deviation of 0.05 rad: here with the given lenses, and not with uncertain
/// ones.
#[test]
fn a_baseline_that_only_the_lens_leaves_unobserved_is_applied_if_it_aligns_the_rows_clearly_better()
{
    for (nearest, off_deg, is_applied) in [(300.0, 25.0, true), (500.0, 8.0, false)] {
        let truth = rig(ROTATION, [off_deg, BASELINE[1]]);
        let mut calibrator = robust::<f32>();
        for seed in 0..4 {
            let matches = correspondences_within(&truth, [nearest, 4.0 * nearest], 250, 0.5, seed);
            take(&mut calibrator, &matches).unwrap();
        }
        let proposal = calibrator.proposal().unwrap();
        let [given, uncertain] = [proposal.sd, proposal.sd_lens].map(|sd| sd.translation);
        assert!(given < 0.045 && uncertain > 0.055, "{given} {uncertain}");
        let in_use = calibrator.in_use().extrinsics;
        let [applicable, best, in_use] =
            [proposal.applicable, proposal.extrinsics, in_use].map(|found| *found.translation());
        assert_eq!([applicable == best, applicable == in_use], [is_applied, !is_applied]);
    }
}

#[test]
fn a_near_scene_observes_the_baseline_and_applies_it() {
    let mut calibrator = robust::<f32>();
    for seed in 0..6 {
        let near = correspondences(&rig(ROTATION, BASELINE), 250, 0.5, seed);
        take(&mut calibrator, &near).unwrap();
    }
    assert!(calibrator.proposal().unwrap().baseline_observed);
    assert!(!calibrator.verdict().reasons.contains(Reason::Baseline));
    let applied = calibrator.apply().unwrap().extrinsics;
    assert!(Deviation::between(&applied, &rig(ROTATION, BASELINE)).translation < 2e-3);
}

#[test]
fn few_near_points_before_a_far_scene_determine_the_baseline() {
    // Some runs take many pairs: 233 of 400 runs observe the baseline after 30 pairs, and 98 of 100 after 150.
    let observes = |run: &u64| {
        let mut calibrator = robust::<f32>();
        let mut fused = 0;
        for seed in run * 2000..run * 2000 + 150 {
            let mut matches = far(230, 4, seed);
            let near = correspondences::<f32>(&rig(ROTATION, BASELINE), 15, 0.5, 1000 + seed);
            matches.extend(near);
            fused += u32::from(take(&mut calibrator, &matches).is_ok());
        }
        assert!(fused >= 145, "{fused}");
        let proposal = calibrator.proposal().unwrap();
        assert_eq!(proposal.state, State::Locked);
        let Deviation { translation, .. } = off(&calibrator);
        assert!(translation < 4.0 * proposal.sd.translation, "{translation} {:?}", proposal.sd);
        assert!(!proposal.baseline_observed || translation < 3e-3, "{translation}");
        proposal.baseline_observed
    };
    let all = runs(5, 10);
    let observed = (0..all).filter(observes).count() as u64;
    assert!(observed >= all - all / 5, "{observed}");
}

#[test]
fn outliers_before_a_far_scene_do_not_observe_the_baseline() {
    let mut calibrator = robust::<f32>();
    for seed in 0..60 {
        let _ = take(&mut calibrator, &far(250, 2, seed));
        let observed = calibrator.proposal().is_some_and(|proposal| proposal.baseline_observed);
        assert!(!observed, "{seed}");
    }
}

/// The matches with outliers in the first half of every `period` consecutive ones.
fn at_regular_places(
    mut matches: Vec<Correspondence<f32>>,
    period: usize,
) -> Vec<Correspondence<f32>> {
    for i in (0..matches.len() - period).filter(|i| i % period < period / 2) {
        matches[i].right = matches[i + period].right;
    }
    matches
}

/// Number of runs of 40 far pairs that observe the baseline after any pair, or are not locked after the last pair.
fn misled(n: usize, scene: impl Fn(Vec<Correspondence<f32>>) -> Vec<Correspondence<f32>>) -> usize {
    let truth = rig(ROTATION, BASELINE);
    let observes = |run: &u64| {
        let mut calibrator = robust::<f32>();
        let mut observed = false;
        for seed in run * 1000..run * 1000 + 40 {
            let matches = correspondences_within(&truth, [1000.0, 10_000.0], n, 0.5, seed);
            let _ = take(&mut calibrator, &scene(matches));
            observed |= calibrator.proposal().is_some_and(|proposal| proposal.baseline_observed);
        }
        observed || calibrator.state() != State::Locked
    };
    (1000..1000 + runs(4, 24)).filter(observes).count()
}

#[test]
fn outliers_at_regular_places_of_a_far_scene_do_not_observe_the_baseline() {
    // A survey reads one match of each of 32 parts, and each part is as long as the period. A step of a track reads
    // half of the matches.
    let mut runs: Vec<_> = (2..=8)
        .map(|period| misled(32 * period, |matches| at_regular_places(matches, period)))
        .collect();
    runs.extend([200, 250, 256].map(|n| misled(n, |matches| at_regular_places(matches, 2))));
    runs.push(misled(250, |matches| with_outliers(with_outliers(matches, 4), 3)));
    assert_eq!(runs, [0; 11]);
}

/// A scene at infinity fits any baseline, also one along the columns or from right to left.
#[test]
fn a_poor_pair_of_the_sky_does_not_name_a_turned_baseline() {
    let truth = rig(ROTATION.map(|degrees| 4.0 * degrees), BASELINE);
    for run in 0..runs(60, 200) {
        let mut calibrator = robust::<f32>();
        for seed in 3 * run..3 * run + 3 {
            let sky = correspondences_within(&truth, [1e4, 1e5], 30, 0.5, seed);
            let mut half_wrong = with_outliers(sky, 2);
            half_wrong.shuffle(&mut ChaCha8Rng::seed_from_u64(run));
            let refused = take(&mut calibrator, &half_wrong).err();
            let turned = [Rejection::Columns, Rejection::Behind].map(Some);
            assert!(!turned.contains(&refused), "{refused:?}, pair {seed}");
        }
    }
}
