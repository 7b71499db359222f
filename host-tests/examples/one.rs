use clap::ValueEnum;
use host_tests::campaign::*;
use host_tests::scenario::{Kind, Scenario};
use stereo_selfcal::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let kind = Kind::from_str(&a[1], true).unwrap();
    let mut s = Scenario::new(kind, 5);
    s.scene.outliers = a[2].parse().unwrap();
    s.scene.rig = five_degrees_off();
    for f in s.frames(a[3].parse().unwrap()).unwrap() {
        let c = f.scene.size.map(|n| f64::from(n - 1) / 2.0);
        let i = Intrinsics { focal: [f.scene.focal; 2], principal: c, size: f.scene.size };
        let cam = Camera::try_new(i, Lens::Pinhole).unwrap();
        let mut cal = Calibrator::<f64, 512>::new(Config::robust());
        cal.set_cameras(Cameras { left: cam, right: cam });
        for m in &f.pair.matches {
            let _ = cal.push(&m.correspondence());
        }
        match cal.solve_pair() {
            Ok(r) => println!(
                "{:?} noise {:.3} passes {} {:?} sd {:?}",
                metrics::Deviation::between(&r.extrinsics, &f.scene.rig),
                r.noise_px,
                r.passes,
                r.stop,
                r.information.standard_deviations()
            ),
            Err(e) => println!("{e}"),
        }
    }
}
