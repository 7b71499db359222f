use host_tests::campaign::*;
use host_tests::scenario::{Kind, Scenario};
use stereo_selfcal::*;
use clap::ValueEnum;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let kind = Kind::from_str(&a[1], true).unwrap();
    let mut sums = [0.0; 6];
    for seed in 0..60 {
    let mut s = Scenario::new(kind, 60);
    s.scene.outliers = a[2].parse().unwrap();
    if a[3] != "0" { s.scene.matches = a[3].parse().unwrap(); }
    s.scene.rig = five_degrees_off();
        let mut cal = Calibrator::<f32, 512>::new(Config::robust());
    for f in s.frames(seed).unwrap() {
        let c = f.scene.size.map(|n| (n - 1) as f32 / 2.0);
        let i = Intrinsics { focal: [f.scene.focal as f32; 2], principal: c, size: f.scene.size };
        let cam = Camera::try_new(i, Lens::Pinhole).unwrap();
        if cal.cameras().is_none() { cal.set_cameras(Cameras { left: cam, right: cam }); }
        for m in &f.pair.matches { let _ = cal.push(&m.correspondence()); }
        if let Ok(r) = cal.solve_pair() {
            if cal.state() == State::Locked { sums[0] += 1.0; sums[1] += r.noise_px as f64; sums[2] += (r.noise_px as f64).powi(2);
               }
            let _ = cal.fuse(&r);
        }
        cal.clear_pair();
    }
    if let Some(p) = cal.proposal() { let _ = p; }
    }
    println!("noise mean {} rms {}", sums[1] / sums[0], (sums[2] / sums[0]).sqrt());
}
