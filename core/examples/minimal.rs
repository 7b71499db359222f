//! A complete calibration of a synthetic rig: cameras, pairs, verdict, apply.
//!
//! ```sh
//! cargo run -p stereo-selfcal --example minimal
//! ```

use core::error::Error;

use stereo_selfcal::geometry::{metrics, so3};
use stereo_selfcal::nalgebra::Vector3;
use stereo_selfcal::{
    ApplyError, Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics,
    FactoryCalibration, Intrinsics, Lens, State,
};

/// Correspondences that a batch holds.
const CAPACITY: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let intrinsics =
        Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
    let cameras = Cameras { left: camera, right: camera };

    // Side by side. `FactoryCalibration::new` takes the extrinsics of a calibration and holds their yaw.
    let factory = FactoryCalibration::guess(cameras);
    let mut calibrator = Calibrator::<f32, CAPACITY>::new(Config::robust(), &factory);
    let mut loaded = calibrator.in_use(); // the rectifier's

    // The rig has moved since: R by 1.4 degrees, t by 0.8 degrees.
    let turn = so3::exp(&Vector3::new(0.010, -0.015, 0.017)).ok_or("no rotation")?;
    let truth = Extrinsics::try_new(turn.matrix(), &Vector3::new(-1.0, 0.010, -0.010))?;
    let mut matcher = Matcher { cameras, truth, random: 1 };

    for pair in 0..12 {
        let outcome = calibrator.take_pair(matcher.matches(300));
        println!("pair {pair}: {outcome}"); // the calibration in use is unchanged
        println!("        {}", calibrator.verdict());
        match calibrator.apply() {
            Ok(new) if new.generation != loaded.generation => {
                println!("        in use: {new}");
                loaded = new;
            }
            Ok(_) | Err(ApplyError::NoProposal | ApplyError::NotLocked(_)) => {}
            Err(error) => println!("        not applied: {error}"),
        }
    }

    let (rectified, [left, right]) = loaded.homographies(0.0)?;
    println!("rectified camera: {rectified}\nH_l ={left}H_r ={right}");

    let found = loaded.extrinsics;
    let off_r = metrics::rotation_angle(found.rotation(), truth.rotation());
    let off_t = metrics::baseline_angle(found.translation(), truth.translation());
    println!("off the truth: R {off_r:.5} rad, t {off_t:.5} rad");
    if calibrator.state() == State::Locked && off_r < 1e-3 && off_t < 2e-3 {
        Ok(())
    } else {
        Err("the rig was not found".into())
    }
}

/// In place of a matcher: points 3 to 60 baselines away, 0.3 px of noise, a third of the matches wrong.
struct Matcher {
    cameras: Cameras<f32>,
    truth: Extrinsics<f32>,
    random: u64,
}

impl Matcher {
    fn matches(&mut self, count: usize) -> Vec<Correspondence<f32>> {
        let mut found = Vec::new();
        while found.len() < count {
            found.extend(self.point());
        }
        found
    }

    /// A point in the left image, if the right camera sees it.
    fn point(&mut self) -> Option<Correspondence<f32>> {
        let left = [self.uniform() * 1919.0, self.uniform() * 1199.0];
        let ray = self.cameras.left.ray(left).ok()?;
        let depth = 3.0 * 20.0_f32.powf(self.uniform());
        let p_l = Vector3::new(ray.x, ray.y, 1.0) * depth;
        let p_r = self.truth.rotation() * p_l + self.truth.translation().into_inner();
        let mut right = self.cameras.right.pixel(p_r.xy() / p_r.z).ok()?;
        if self.uniform() < 0.33 {
            right = [self.uniform() * 1919.0, self.uniform() * 1199.0];
        }
        let mut noisy = |p: [f32; 2]| p.map(|x| x + (self.uniform() - 0.5) * 1.04);
        let [left, right] = [noisy(left), noisy(right)];
        let inside = |[u, v]: [f32; 2]| (0.0..1920.0).contains(&u) && (0.0..1200.0).contains(&v);
        (inside(left) && inside(right)).then_some(Correspondence {
            left,
            right,
            score: 1.0,
            grid_step: 0.0,
        })
    }

    /// From 0 up to 1; a linear congruential generator.
    fn uniform(&mut self) -> f32 {
        self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let [a, b, ..] = self.random.to_be_bytes();
        f32::from(u16::from_be_bytes([a, b])) / 65_536.0
    }
}

#[cfg(test)]
#[test]
fn finds_the_rig() {
    main().unwrap();
}
