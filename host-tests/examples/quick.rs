use clap::ValueEnum;
use host_tests::campaign::*;
use host_tests::depth::Depth;
use host_tests::scenario::{Kind, Scenario};
use stereo_selfcal::{Config, State};

fn main() {
    let a: Vec<String> = std::env::args().collect();
    let g = |i: usize, d: &str| a.get(i).cloned().unwrap_or(d.into());
    let kind = Kind::from_str(&g(1, "near"), true).unwrap();
    let pairs: usize = g(2, "20").parse().unwrap();
    let trials: u64 = g(3, "40").parse().unwrap();
    let outliers: f64 = g(4, "0.3").parse().unwrap();
    let n: usize = g(5, "256").parse().unwrap();
    let off = g(6, "c");
    let seed0: u64 = g(7, "50000").parse().unwrap();
    let mut s = Scenario::new(kind, pairs);
    s.scene.outliers = outliers;
    if n > 0 {
        s.scene.matches = n;
    }
    if off == "c" {
        s.scene.rig = five_degrees_off();
    }
    if let Ok(t) = g(8, "x").parse() {
        s.turn_deg = t;
    }
    if let Ok(nz) = g(9, "x").parse() {
        s.scene.noise_px = nz;
    }
    let _ = Depth::LogUniform([1.0, 2.0]);
    let cfg = Config::robust().with_automatic_apply(true);
    let t0 = std::time::Instant::now();
    let runs = if std::env::var("F64").is_ok() {
        runs::<f64>(&s, cfg, seed0..seed0 + trials, || ())
    } else {
        runs::<f32>(&s, cfg, seed0..seed0 + trials, || ())
    }
    .unwrap();
    let e = rms(runs.iter().filter_map(|r| r.last()).map(|m| m.error));
    let o = rms(runs.iter().filter_map(|r| r.oracle));
    let locks: Vec<usize> = runs.iter().filter_map(|r| r.locked_at()).map(|x| x + 1).collect();
    let nees: f64 =
        runs.iter().filter_map(|r| r.last()).map(|m| m.nees).sum::<f64>() / trials as f64;
    let lf = runs.iter().fold([0, 0], |a, r| {
        let b = r.locked_and_false();
        [a[0] + b[0], a[1] + b[1]]
    });
    let false_lock = runs
        .iter()
        .filter(|r| r.locked_at().is_some_and(|i| r.moments[i].unwrap().over_claim > 5.0))
        .count();
    let pass = |locked: bool| {
        let v: Vec<f64> = runs
            .iter()
            .flat_map(|r| r.moments.windows(2))
            .filter_map(|w| {
                let m = w[1]?;
                let before = w[0].map_or(State::Acquiring, |m| m.state);
                let p = m.passes?;
                ((before == State::Locked && m.state == State::Locked) == locked)
                    .then_some(p as f64)
            })
            .collect();
        (v.iter().sum::<f64>() / v.len() as f64, v.iter().cloned().fold(0.0, f64::max))
    };
    let ev = |f: stereo_selfcal::Fused| {
        runs.iter().flat_map(|r| r.moments.iter().flatten()).filter(|m| m.fused == Some(f)).count()
    };
    println!(
        "{kind} M={pairs} o={outliers} N={n}: e_t {:.2e} e_th {:.2e}  /oracle {:.2} {:.2}  lock {}/{} max {:?} median {:?}  nees {:.2} {:?} false {:?} falselock {}  passes locked {:?} else {:?} took {} renewed {} apart {} rep {} worst {:.1} {:.1?}s",
        e.translation,
        e.rotation,
        e.translation / o.translation,
        e.rotation / o.rotation,
        locks.len(),
        trials,
        locks.iter().max(),
        {
            let mut l = locks.clone();
            l.sort();
            l.get(l.len() / 2).copied()
        },
        nees,
        nees_band(trials as usize).map(|x| (x * 100.0).round() / 100.0),
        lf,
        false_lock,
        pass(true),
        pass(false),
        ev(stereo_selfcal::Fused::TookOver),
        ev(stereo_selfcal::Fused::Renewed),
        ev(stereo_selfcal::Fused::KeptApart),
        ev(stereo_selfcal::Fused::Repeated),
        runs.iter().filter_map(|r| r.last()).map(|m| m.over_claim).fold(0.0, f64::max),
        t0.elapsed()
    );
    if std::env::var("V").is_ok() {
        for (i, r) in runs.iter().enumerate() {
            let m = r.last();
            let b = r.bound;
            println!(
                "{i} lock {:?} {:?} bound {:.1e} {:.1e} err {:?}",
                r.locked_at(),
                m.map(|m| (m.state, m.over_claim, m.doubt)),
                b.translation,
                b.rotation,
                m.map(|m| m.error)
            );
        }
        if std::env::var("VV").is_ok() {
            for m in &runs[0].moments {
                println!("{m:?}");
            }
        }
    }
}
