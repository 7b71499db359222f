//! Recorded matches with lens models that are wrong on purpose: the reported deviations cover the error.

use host_tests::data::Dataset;
use host_tests::run::{Apply, RunLog, replay_within};
use stereo_selfcal::{Config, Extrinsics};

/// Largest error in deviations with the lens uncertain.
const MOST_SD: f64 = 2.5;

/// A falsification of the right camera: relative focal length, `k1`, principal column and row, px.
#[derive(Debug, Clone, Copy, Default)]
struct Falsified {
    focal: f64,
    k1: f64,
    cx: f64,
    cy: f64,
}

fn cases() -> Vec<Falsified> {
    let mut cases = vec![Falsified::default()];
    for sign in [1.0, -1.0] {
        cases.extend([0.003, 0.01].map(|f| Falsified { focal: sign * f, ..Falsified::default() }));
        cases.push(Falsified { k1: sign * 0.01, ..Falsified::default() });
        cases.push(Falsified { cx: sign * 3.0, ..Falsified::default() });
        cases.push(Falsified { cy: sign, ..Falsified::default() });
    }
    cases
}

fn run(name: &str, falsified: Falsified) -> RunLog {
    let mut set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
    let Falsified { focal, k1, cx, cy } = falsified;
    let [[fx, _, px], [_, fy, py], _] = &mut set.meta.k_r;
    (*fx, *fy, *px, *py) = (*fx * (1.0 + focal), *fy * (1.0 + focal), *px + cx, *py + cy);
    set.meta.dist_r[0] += k1;
    let start = Extrinsics::SIDE_BY_SIDE;
    replay_within::<f32, 512>(&set, Config::robust(), start, Apply::Each, |_| ()).unwrap()
}

#[test]
fn errors_stay_within_the_deviations_with_the_lens_uncertain_and_nothing_is_armed_beyond_five() {
    for name in ["opencv_chess_corners", "opencv_chess_sift"] {
        for falsified in cases() {
            let log = run(name, falsified);
            for step in log.steps() {
                let (Some(estimate), Some(error)) = (step.estimate, step.running) else { continue };
                let sd = estimate.sd_lens;
                let worst = (error.translation / sd.translation).max(error.rotation / sd.rotation);
                let armed = step.checked.is_some_and(|checked| checked.is_armed());
                assert!(!armed || worst <= 5.0, "{name} {falsified:?}: armed at {worst}");
            }
            let last = log.steps().last().unwrap();
            let (estimate, error) = (last.estimate.unwrap(), last.running.unwrap());
            let sd = estimate.sd_lens;
            let [t, r] = [error.translation / sd.translation, error.rotation / sd.rotation];
            assert!(t <= MOST_SD && r <= MOST_SD, "{name} {falsified:?}: {t} {r}");
        }
    }
}
