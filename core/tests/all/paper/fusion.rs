//! Fusion of many pairs in the published method: the incremental sums against the formulas over all pairs at once.

use super::published;
use crate::api::scene::{correspondences, rig};
use nalgebra::Vector3;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::paper::{Central, MeanDirection};
use stereo_selfcal::{Extrinsics, PairReport, Scalar};

const FAR_FROM_IDENTITY: [f64; 3] = [2.0, -3.0, 1.0];

fn reports<T: Scalar>(rotation_deg: [f64; 3], pairs: u64) -> Vec<PairReport<T>> {
    let truth = rig(rotation_deg, [1.0, -2.0]);
    let mut calibrator = published::<T>();
    let mut solve = |seed| {
        for c in correspondences(&truth, 64, 1.0, seed) {
            calibrator.push(&c).unwrap();
        }
        let report = calibrator.solve_pair().pair.unwrap();
        calibrator.discard_pair();
        report
    };
    (0..pairs).map(&mut solve).collect()
}

fn fused<T: Scalar>(central: Central, reports: &[PairReport<T>]) -> MeanDirection<T> {
    let mut fusion = MeanDirection::new(central);
    for r in reports {
        fusion.add(r);
    }
    fusion
}

/// Eqs 20-22 as printed, over all pairs at once.
fn batch(reports: &[PairReport<f64>], angle: impl Fn(Vec<f64>) -> f64) -> Extrinsics<f64> {
    let rotations: Vec<Vector3<f64>> =
        reports.iter().map(|r| so3::log(r.extrinsics.rotation())).collect();
    let t: Vector3<f64> = reports.iter().map(|r| r.extrinsics.translation().into_inner()).sum();
    let axis: Vector3<f64> = rotations.iter().map(Vector3::normalize).sum();
    let angle = angle(rotations.iter().map(Vector3::norm).collect());
    let r = so3::exp(&(axis.normalize() * angle)).unwrap();
    Extrinsics::try_new(r.matrix(), &t).unwrap()
}

fn mean(angles: Vec<f64>) -> f64 {
    let n = angles.len() as f64;
    angles.into_iter().sum::<f64>() / n
}

fn median(mut angles: Vec<f64>) -> f64 {
    angles.sort_by(f64::total_cmp);
    angles[angles.len() / 2]
}

#[test]
fn incremental_sums_equal_the_batch_formulas() {
    let reports = reports::<f64>(FAR_FROM_IDENTITY, 31);
    for (central, expected) in
        [(Central::Mean, batch(&reports, mean)), (Central::Median, batch(&reports, median))]
    {
        let estimate = fused(central, &reports).estimate().unwrap();
        let gap = Deviation::between(&estimate.extrinsics, &expected);
        assert!(gap.translation < 1e-14 && gap.rotation < 1e-14, "{gap:?}");
        assert!(estimate.axis_is_meaningful);
        assert_eq!(estimate.pairs, 31);
    }
}

#[test]
fn reported_deviation_is_the_standard_error_of_the_pairs() {
    let reports = reports::<f32>(FAR_FROM_IDENTITY, 100);
    let estimate = fused(Central::Mean, &reports).estimate().unwrap();
    let scatter = Deviation::root_mean_square(
        reports.iter().map(|r| Deviation::between(&r.extrinsics, &estimate.extrinsics)),
    )
    .unwrap();
    assert!((estimate.sd.translation / (scatter.translation / 10.0) - 1.0).abs() < 0.02);
    assert!((estimate.sd.rotation / (scatter.rotation / 10.0) - 1.0).abs() < 0.02);
}

#[test]
fn one_pair_is_its_own_estimate_and_claims_its_own_deviation() {
    let [report] = reports::<f32>(FAR_FROM_IDENTITY, 1).try_into().unwrap();
    let estimate = fused(Central::Mean, &[report]).estimate().unwrap();
    let gap = Deviation::between(&estimate.extrinsics, &report.extrinsics);
    assert!(gap.translation < 3e-7 && gap.rotation < 3e-7, "{gap:?}");
    assert_eq!(Some(estimate.sd), report.information.standard_deviations());
    assert_eq!(MeanDirection::<f32>::new(Central::Mean).estimate(), None);
}

#[test]
fn fusing_a_million_equal_pairs_moves_nothing() {
    let [report] = reports::<f32>(FAR_FROM_IDENTITY, 1).try_into().unwrap();
    for central in [Central::Mean, Central::Median] {
        let mut fusion = MeanDirection::new(central);
        for _ in 0..1_000_000 {
            fusion.add(&report);
        }
        let estimate = fusion.estimate().unwrap();
        let gap = Deviation::between(&estimate.extrinsics, &report.extrinsics);
        assert!(gap.translation < 3e-7 && gap.rotation < 3e-7, "{central:?} {gap:?}");
        assert_eq!(estimate.pairs, 1_000_000);
    }
}

#[test]
fn a_million_pairs_in_f32_give_the_estimate_of_f64() {
    let cycle = 100;
    let singles = reports::<f32>(FAR_FROM_IDENTITY, cycle);
    let mut fusion = MeanDirection::new(Central::Mean);
    for _ in 0..1_000_000 / cycle {
        for r in &singles {
            fusion.add(r);
        }
    }
    let estimate = fusion.estimate().unwrap();
    let once = fused(Central::Mean, &reports::<f64>(FAR_FROM_IDENTITY, cycle)).estimate().unwrap();
    let [r, t] = [
        estimate.extrinsics.rotation_row_major(),
        once.extrinsics.rotation_row_major().map(f32::lit),
    ];
    let gap = r.iter().zip(t).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(gap < 2e-6, "{gap:e}");
    let t = once.extrinsics.translation().map(f32::lit);
    assert!((estimate.extrinsics.translation().into_inner() - t).amax() < 2e-6);
    let shrunk = estimate.sd.translation / f32::lit(once.sd.translation) * 1e4_f32.sqrt();
    assert!((shrunk - 1.0).abs() < 0.02, "{shrunk}");
}

#[test]
fn near_the_identity_the_axis_is_reported_as_meaningless() {
    let estimate = fused(Central::Mean, &reports::<f32>([0.0; 3], 50)).estimate().unwrap();
    assert!(!estimate.axis_is_meaningful, "{estimate:?}");
    assert!(estimate.axis_concentration < 0.9);
    let far = fused(Central::Mean, &reports::<f32>(FAR_FROM_IDENTITY, 50)).estimate().unwrap();
    assert!(far.axis_is_meaningful && far.axis_concentration > 0.99, "{far:?}");
}
