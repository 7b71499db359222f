use host_tests::campaign::*;
use host_tests::scenario::{Kind, Scenario};
use stereo_selfcal::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let trials: u64 = a[1].parse().unwrap();
    let pairs: usize = a[2].parse().unwrap();
    let out: f64 = a[3].parse().unwrap();
    for deg in [5.0, 2.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01] {
        let mut s = Scenario::new(Kind::Step, pairs);
        s.scene.outliers = out;
        s.turn_deg = deg;
        let runs = runs::<f32>(
            &s,
            Config::robust().with_automatic_apply(true),
            30000..30000 + trials,
            || (),
        )
        .unwrap();
        let k = pairs.div_ceil(2);
        // detection: first Renewed or TookOver at/after k
        let det: Vec<Option<usize>> = runs
            .iter()
            .map(|r| {
                r.moments[k..]
                    .iter()
                    .position(|m| {
                        m.is_some_and(|m| matches!(m.fused, Some(Fused::Renewed | Fused::TookOver)))
                    })
                    .map(|x| x + 1)
            })
            .collect();
        let missed = det.iter().filter(|d| d.is_none()).count();
        let mut d: Vec<usize> = det.iter().flatten().copied().collect();
        d.sort();
        let falses = runs
            .iter()
            .flat_map(|r| r.moments[..k].iter().flatten())
            .filter(|m| matches!(m.fused, Some(Fused::Renewed | Fused::TookOver)))
            .count();
        let e = |i: usize| {
            rms(runs.iter().filter_map(|r| r.moments.get(i).copied().flatten()).map(|m| m.in_use))
        };
        let w = |i: usize| {
            runs.iter()
                .filter_map(|r| r.moments.get(i).copied().flatten())
                .filter(|m| m.state == State::Locked)
                .map(|m| m.over_claim)
                .fold(0.0, f64::max)
        };
        let back = (k..pairs)
            .rev()
            .find(|&i| e(i).rotation > 2.5 * 3.3e-4 / ((i - k + 1).min(100) as f64).sqrt())
            .map_or(0, |i| i - k + 1);
        println!(
            "{deg}: detected median {:?} max {:?} missed {missed} false {falses}; e before {:.1e} {:.1e} after 1 {:.1e} 3 {:.1e}/{:.1e} 4 {:.1e}/{:.1e} 10 {:.1e}/{:.1e} 15 {:.1e}/{:.1e} 30 {:.1e}/{:.1e} end {:.1e}/{:.1e}; back after {back}; over-claim worst at +4 {:.1} +10 {:.1} +20 {:.1} end {:.1}",
            d.get(d.len() / 2),
            d.last(),
            e(k - 1).translation,
            e(k - 1).rotation,
            e(k).rotation,
            e(k + 2).translation,
            e(k + 2).rotation,
            e(k + 3).translation,
            e(k + 3).rotation,
            e(k + 9).translation,
            e(k + 9).rotation,
            e(k + 14).translation,
            e(k + 14).rotation,
            e(k + 29).translation,
            e(k + 29).rotation,
            e(pairs - 1).translation,
            e(pairs - 1).rotation,
            w(k + 3),
            w(k + 9),
            w(k + 19),
            w(pairs - 1)
        );
    }
    let mut s = Scenario::new(Kind::Drift, 100);
    s.scene.outliers = out;
    s.turn_deg = 0.01;
    let runs =
        runs::<f32>(&s, Config::robust().with_automatic_apply(true), 30000..30000 + trials, || ())
            .unwrap();
    for i in [9, 19, 49, 99] {
        let e = rms(runs.iter().filter_map(|r| r.moments[i]).map(|m| m.error));
        println!(
            "drift pair {i}: {:.1e} {:.1e} worst over {:.1} states {:?}",
            e.translation,
            e.rotation,
            runs.iter().filter_map(|r| r.moments[i]).map(|m| m.over_claim).fold(0.0, f64::max),
            runs.iter().filter_map(|r| r.moments[i]).filter(|m| m.state == State::Locked).count()
        );
    }
}
