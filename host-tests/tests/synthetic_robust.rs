//! The robust preset on generated scenes with mismatches: against the Cramer-Rao bound of the true
//! inliers (one pair) and against the joint fit of all true inliers (fused). `f32`.

use host_tests::evaluation::in_f64;
use host_tests::oracle::{self, Rays};
use host_tests::synth::{Scene, SynthPair, rig};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, PairError};

const TRIALS: u16 = 1000;

/// 5 degrees off about every axis, `t` 5 degrees off.
fn scene(outliers: f64) -> Scene {
    let rig = rig([5.0, 5.0, 5.0], [3.5, 3.5]).unwrap();
    Scene { rig, outliers, ..Scene::default() }
}

fn calibrator(scene: &Scene) -> Calibrator<f32, 256> {
    let mut calibrator = Calibrator::new(Config::robust());
    calibrator.set_cameras(scene.dataset(0, 0).unwrap().cameras().unwrap());
    calibrator
}

fn push(calibrator: &mut Calibrator<f32, 256>, pair: &SynthPair) {
    for m in &pair.matches {
        calibrator.push(&m.correspondence()).unwrap();
    }
}

fn rms(deviations: impl IntoIterator<Item = Deviation<f64>>) -> Deviation<f64> {
    Deviation::root_mean_square(deviations).unwrap()
}

struct Single {
    /// RMS error over RMS bound, of `t` and of `R`, over the trials that succeeded.
    ratio: [f64; 2],
    /// Share of the trials within four times the bound.
    success: f64,
    /// Mean squared error of `t` over its predicted variance.
    chi2_t: f64,
}

fn single_pairs(scene: &Scene, seed: u64) -> Single {
    let mut calibrator = calibrator(scene);
    let [mut errors, mut bounds] = [Vec::new(), Vec::new()];
    let mut chi2 = 0.0;
    for pair in scene.pairs(seed).take(TRIALS.into()) {
        push(&mut calibrator, &pair);
        let report = calibrator.solve_pair();
        calibrator.clear_pair();
        let inliers = pair.clean.iter().zip(&pair.inlier).filter(|(_, inlier)| **inlier);
        let clean: Vec<Rays> = inliers.map(|(&pixels, _)| scene.rays(pixels)).collect();
        let bound = oracle::cramer_rao(&scene.rig, clean.iter(), scene.noise_px / scene.focal);
        let Ok(report) = report else { continue };
        let error = Deviation::between(&in_f64(&report.extrinsics), &scene.rig);
        let success =
            error.translation < 4.0 * bound.translation && error.rotation < 4.0 * bound.rotation;
        if success {
            let sd = report.information.standard_deviations().unwrap();
            chi2 += (error.translation / f64::from(sd.translation)).powi(2);
            errors.push(error);
            bounds.push(bound);
        }
    }
    let count = f64::from(u16::try_from(errors.len()).unwrap());
    let [error, bound] = [rms(errors), rms(bounds)];
    Single {
        ratio: [error.translation / bound.translation, error.rotation / bound.rotation],
        success: count / f64::from(TRIALS),
        chi2_t: chi2 / count,
    }
}

#[test]
fn a_single_pair_is_near_the_cramer_rao_bound_whatever_the_mismatches() {
    for (outliers, limit) in [(0.0, 1.10), (0.3, 1.10), (0.5, 1.15)] {
        let Single { ratio: [t, r], success, chi2_t } = single_pairs(&scene(outliers), 31);
        println!(
            "{outliers} mismatches: sigma_t {t:.3}, sigma_theta {r:.3} of the bound, \
             success {success:.3}, squared error of t over prediction {chi2_t:.2}"
        );
        assert!(t <= limit && r <= limit, "{outliers}: {t} {r}");
        assert!(success >= 0.99, "{outliers}: {success}");
        assert!((0.8..1.3).contains(&chi2_t), "{outliers}: {chi2_t}");
    }
}

#[test]
fn six_in_ten_mismatches_from_5_degrees_off_are_survived() {
    let single = single_pairs(&scene(0.6), 32);
    println!("success {:.3}", single.success);
    assert!(single.success >= 0.95);
}

#[test]
fn fused_pairs_are_near_the_joint_fit_of_all_true_inliers() {
    let scene = scene(0.3);
    let [mut fused, mut joint] = [Vec::new(), Vec::new()];
    for seed in 0..100 {
        let mut calibrator = calibrator(&scene);
        let mut inliers: Vec<Rays> = Vec::new();
        for pair in scene.pairs(5000 + seed).take(50) {
            push(&mut calibrator, &pair);
            let report = calibrator.solve_pair().unwrap();
            calibrator.fuse(&report).unwrap();
            calibrator.clear_pair();
            let matches = pair.matches.iter().zip(&pair.inlier).filter(|(_, inlier)| **inlier);
            inliers.extend(matches.map(|(m, _)| scene.rays([m.ul, m.vl, m.ur, m.vr])));
        }
        let estimate = calibrator.estimate().unwrap();
        fused.push(Deviation::between(&in_f64(&estimate.extrinsics), &scene.rig));
        joint.push(Deviation::between(&oracle::joint_fit(&scene.rig, &inliers), &scene.rig));
    }
    let [fused, joint] = [rms(fused), rms(joint)];
    let [t, r] = [fused.translation / joint.translation, fused.rotation / joint.rotation];
    println!("over the joint fit: e_t {t:.3}, e_theta {r:.3}");
    assert!(t <= 1.25 && r <= 1.25, "{t} {r}");
}

#[test]
fn nothing_but_mismatches_is_refused() {
    let scene = scene(0.0);
    let mut calibrator = calibrator(&scene);
    let mut solved = 0;
    for mut pair in scene.pairs(77).take(1000) {
        // Every left point with the right one of another.
        let mut right: Vec<[f64; 2]> = pair.matches.iter().map(|m| [m.ur, m.vr]).collect();
        right.rotate_left(1);
        for (m, [ur, vr]) in pair.matches.iter_mut().zip(right) {
            (m.ur, m.vr) = (ur, vr);
        }
        push(&mut calibrator, &pair);
        solved += u32::from(calibrator.solve_pair() != Err(PairError::NoConsensus));
        calibrator.clear_pair();
    }
    println!("{solved} of 1000 pairs of mismatches were taken for a rig");
    assert_eq!(solved, 0);
}
