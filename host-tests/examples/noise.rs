use clap::ValueEnum;
use host_tests::campaign::*;
use host_tests::scenario::{Kind, Scenario};
use stereo_selfcal::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let kind = Kind::from_str(&a[1], true).unwrap();
    let mut s = Scenario::new(kind, 8);
    s.scene.outliers = a[2].parse().unwrap();
    if a[3] != "0" {
        s.scene.matches = a[3].parse().unwrap();
    }
    if a[4] == "c" {
        s.scene.rig = five_degrees_off();
    }
    let mut cal = Calibrator::<f64, 512>::new(Config::robust());
    let clean = a.len() > 6;
    for f in s.frames(a[5].parse().unwrap()).unwrap() {
        let c = f.scene.size.map(|n| (n - 1) as f64 / 2.0);
        let i = Intrinsics { focal: [f.scene.focal; 2], principal: c, size: f.scene.size };
        let cam = Camera::try_new(i, Lens::Pinhole).unwrap();
        if cal.cameras().is_none() {
            cal.set_cameras(Cameras { left: cam, right: cam });
        }
        for (m, ok) in f.pair.matches.iter().zip(&f.pair.inlier) {
            if *ok || !clean {
                let _ = cal.push(&m.correspondence());
            }
        }
        if let Ok(r) = cal.solve_pair() {
            let u = |e: &Extrinsics<f64>| {
                let v = RectifyingRotations::from(&f.scene.rig)
                    .unknowns_to(&RectifyingRotations::from(e));
                v.as_slice().iter().map(|x| format!("{:.5}", x)).collect::<Vec<_>>().join(" ")
            };
            let sd = r.information.covariance().map(|c| {
                c.diagonal()
                    .map(f64::sqrt)
                    .as_slice()
                    .iter()
                    .map(|x| format!("{:.5}", x))
                    .collect::<Vec<_>>()
                    .join(" ")
            });
            print!(
                "own {} sd {:?} noise {:.3} usable {} screened {}  ",
                u(&r.extrinsics),
                sd,
                r.noise_px,
                r.usable,
                r.screened
            );
            let fu = cal.fuse(&r);
            let p = cal.proposal().unwrap();
            println!(
                "{:?} fused {} sd {:?}",
                fu,
                u(&p.extrinsics),
                p.covariance.unwrap().diagonal().map(f64::sqrt).as_slice()
            );
        }
        cal.clear_pair();
    }
}
