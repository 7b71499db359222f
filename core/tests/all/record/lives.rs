//! Every snapshot of a locked estimate restores it: at each focal length, and in random lives.

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{Fisheye, RadialTangential, Rational, RectifyingRotations, so3};
use stereo_selfcal::{
    Camera, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration, Intrinsics, Lens,
    LensPrior, LensTracking, Proposal, Scalar, State,
};
use test_support::{is_campaign, runs};

use super::{BASELINE, ROTATION, Record, Tested};
use crate::api::scene::rig;

/// Scenes of a made rig with two equal cameras.
#[derive(Debug, Clone, Copy)]
struct View {
    camera: Camera<f64>,
    /// Range of the depths, in baselines.
    depths: [f64; 2],
    noise_px: f64,
    /// Share of wrong matches: the right point is anywhere in the image.
    wrong: f64,
    matches: usize,
}

type Pair<T> = Vec<Correspondence<T>>;

fn camera(focal: f64, size: [u16; 2], lens: Lens<f64>) -> Camera<f64> {
    let principal = size.map(|n| 0.5 * (f64::from(n) - 1.0));
    Camera::try_new(Intrinsics { focal: [focal; 2], principal, size }, lens).unwrap()
}

fn cast<T: Scalar, const K: usize>(x: [f64; K]) -> [T; K] {
    x.map(T::lit)
}

impl View {
    /// Draws a pair; it may have fewer matches if most rays leave the right image.
    fn pair<T: Scalar>(&self, rig: &Extrinsics<f64>, rng: &mut ChaCha8Rng) -> Pair<T> {
        (0..4 * self.matches).filter_map(|_| self.one(rig, rng)).take(self.matches).collect()
    }

    fn one<T: Scalar>(
        &self,
        rig: &Extrinsics<f64>,
        rng: &mut ChaCha8Rng,
    ) -> Option<Correspondence<T>> {
        let size = self.camera.intrinsics().size.map(|n| f64::from(n) - 1.0);
        let mut any = || size.map(|n| rng.random_range(0.0..n));
        let [left, wrong] = [any(), any()];
        let ray = self.camera.ray(left).ok()?.push(1.0);
        let [nearest, farthest] = self.depths;
        let depth = nearest * (farthest / nearest).powf(rng.random());
        let p_r = rig.rotation() * (ray * depth) + rig.translation().into_inner();
        let right = self.camera.pixel(p_r.xy() / p_r.z).ok().filter(|_| p_r.z > 0.0)?;
        let right = if rng.random_bool(self.wrong) { wrong } else { right };
        // The sum of four uniform numbers is nearly normal.
        let mut noise = || {
            let sum: f64 = (0..4).map(|_| rng.random_range(-1.0..1.0)).sum();
            sum * self.noise_px * 0.75_f64.sqrt()
        };
        let points = [left, right].map(|p| p.map(|x| x + noise()));
        let inside = |p: &[f64; 2]| p.iter().zip(size).all(|(x, n)| (0.0..=n).contains(x));
        let [left, right] = points.map(cast);
        let found = Correspondence { left, right, score: T::ONE, grid_step: T::ZERO };
        points.iter().all(inside).then_some(found)
    }

    fn cameras<T: Scalar>(&self) -> Cameras<T> {
        let Intrinsics { focal, principal, size } = *self.camera.intrinsics();
        let lens = match self.camera.lens() {
            Lens::RadialTangential(lens) => Lens::RadialTangential(
                RadialTangential::try_new(cast(lens.coefficients())).unwrap(),
            ),
            Lens::Fisheye(lens) => {
                Lens::Fisheye(Fisheye::try_new(cast(lens.coefficients())).unwrap())
            }
            Lens::Rational(lens) => {
                Lens::Rational(Rational::try_new(cast(lens.coefficients())).unwrap())
            }
            Lens::Pinhole => Lens::Pinhole,
        };
        let intrinsics = Intrinsics { focal: cast(focal), principal: cast(principal), size };
        let camera = Camera::try_new(intrinsics, lens).unwrap();
        Cameras { left: camera, right: camera }
    }
}

fn take<T: Scalar>(calibrator: &mut Tested<T>, pair: &[Correspondence<T>]) {
    calibrator.discard_pair();
    for c in pair {
        let _ = calibrator.push(c);
    }
    let _ = calibrator.solve_pair();
}

/// Restores a snapshot of a calibrator. Returns its estimate, and that of the copy; `None` if the calibrator reports no
/// estimate, because its lens has no plausible solution.
fn restored<T: Scalar>(
    calibrator: &Tested<T>,
    copy: &mut Tested<T>,
    at: &str,
) -> Option<[Proposal<T>; 2]> {
    assert_eq!(copy.restore(&calibrator.snapshot()), Ok(()), "{at}");
    let old = calibrator.proposal()?;
    Some([old, copy.proposal().unwrap_or_else(|| panic!("{at}: no estimate"))])
}

/// Standard deviations of the copy over those of the estimate.
fn widened<T: Scalar>([old, new]: &[Proposal<T>; 2]) -> [f64; 2] {
    [new.sd.rotation / old.sd.rotation, new.sd.translation / old.sd.translation].map(T::to_f64)
}

/// Difference of `R`, apart from the yaw, and of `t`, in standard deviations of the copy with an uncertain lens. How the
/// yaw of the rows is split between mount and lens also depends on earlier rows, which a record does not have.
fn apart<T: Scalar>([old, new]: &[Proposal<T>; 2]) -> [f64; 2] {
    let one = old.extrinsics;
    let turn = so3::log(&(new.extrinsics.rotation() * one.rotation().inverse()));
    let turn = RectifyingRotations::from(&one).right() * turn;
    let Deviation { translation, .. } = Deviation::between(&new.extrinsics, &one);
    [turn.xz().norm() / new.sd_lens.rotation, translation / new.sd_lens.translation].map(T::to_f64)
}

/// Focal lengths of a campaign, px.
const FOCAL_LENGTHS: [f64; 6] = [300.0, 1000.0, 3000.0, 4000.0, 6000.0, 8000.0];

/// Made pairs of a pinhole rig, 10 % of whose matches are wrong.
fn pinhole(focal: f64, noise_px: f64) -> View {
    let size = match focal {
        ..500.0 => [640, 480],
        ..2000.0 => [1920, 1200],
        _ => [4096, 3000],
    };
    let camera = camera(focal, size, Lens::Pinhole);
    View { camera, depths: [3.0, 80.0], noise_px, wrong: 0.1, matches: 256 }
}

/// Checks each snapshot of a locked estimate in a run of pairs, and that the next pair locks every twentieth copy.
fn steady(focal: f64, noise_px: f64, pairs: u32) {
    let (view, mut rng) = (pinhole(focal, noise_px), ChaCha8Rng::seed_from_u64(1));
    let rig = rig(ROTATION, BASELINE);
    let factory = FactoryCalibration::<f32>::guess(view.cameras());
    let new = || Box::new(Tested::new(Config::robust(), &factory));
    let (mut calibrator, mut last) = (new(), None::<Box<Tested<f32>>>);
    let (mut locked, mut compared) = (0, 0);
    for number in 1..=pairs {
        let (at, pair) = (format!("f {focal}, {noise_px} px: {number}"), view.pair(&rig, &mut rng));
        take(&mut calibrator, &pair);
        if let Some(mut copy) = last.take_if(|_| number % 20 == 0) {
            take(&mut copy, &pair);
            assert_eq!(copy.state(), State::Locked, "{at}");
            if let [Some(old), Some(new)] = [&calibrator, &copy].map(|c| c.proposal()) {
                assert!(apart(&[old, new]).iter().all(|x| *x < 0.1), "{at}");
                compared += 1;
            }
        }
        if calibrator.state() == State::Locked {
            let mut copy = new();
            if let Some(both) = restored(&calibrator, &mut copy, &at) {
                let (off, sd) = (apart(&both), widened(&both));
                assert!(off.iter().all(|x| *x < 0.02), "{at}: {off:?}");
                assert!(sd.iter().all(|x| (0.999..1.01).contains(x)), "{at}: {sd:?}");
            }
            locked += 1;
            last = Some(copy);
        }
    }
    println!(
        "f {focal}, {noise_px} px: {locked} snapshots restored, {compared} compared after a pair"
    );
    // The lens of some estimates has no plausible solution in `f32`: at 4000 px and 0.1 px, 23 of 250.
    assert!(locked + 3 == pairs && compared >= pairs / 20 * 3 / 4, "{locked} {compared}");
}

#[test]
fn every_snapshot_of_a_locked_estimate_restores_it_at_each_focal_length() {
    // The information on the lens exceeds its range first at the longest focal length, from pair 54 on.
    steady(8000.0, 0.1, 80);
    let focal_lengths = if is_campaign() { &FOCAL_LENGTHS[..] } else { &[] };
    for focal in focal_lengths {
        steady(*focal, 0.3, 5000);
        steady(*focal, 0.1, 5000);
    }
}

fn log_uniform(range: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    range[0] * (range[1] / range[0]).powf(rng.random())
}

fn single(range: [f64; 2], rng: &mut ChaCha8Rng) -> f32 {
    log_uniform(range, rng).to_single()
}

fn any_view(rng: &mut ChaCha8Rng) -> View {
    let size =
        *[[320, 240], [640, 480], [1280, 800], [1920, 1200], [4096, 3000]].choose(rng).unwrap();
    let half = 0.5 * f64::from(size[0]);
    let kind = rng.random_range(0..4);
    let camera = match kind {
        0 => camera(half / log_uniform([0.2, 2.0], rng), size, Lens::Pinhole),
        1 => {
            let k1 = rng.random_range(-0.3..0.1);
            let lens = RadialTangential::try_new([k1, 0.02, 1e-3, -1e-3, 0.0]).unwrap();
            camera(half / log_uniform([0.2, 0.9], rng), size, Lens::RadialTangential(lens))
        }
        2 => {
            let k = rng.random_range(-0.02..0.02);
            let lens = Fisheye::try_new([k, 0.0, 0.0, 0.0]).unwrap();
            // Half the angle of view, rad.
            camera(half / rng.random_range(0.5..1.45), size, Lens::Fisheye(lens))
        }
        _ => {
            let lens = Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]).unwrap();
            camera(half / log_uniform([0.2, 1.2], rng), size, Lens::Rational(lens))
        }
    };
    let nearest = log_uniform([2.0, 1000.0], rng);
    View {
        camera,
        depths: [nearest, nearest * log_uniform([1.1, 100.0], rng)],
        noise_px: log_uniform([0.01, 1.5], rng),
        wrong: rng.random_range(0.0..0.45),
        matches: rng.random_range(20..=256),
    }
}

fn any_config(rng: &mut ChaCha8Rng) -> Config {
    let mut config = Config::robust();
    if rng.random_bool(0.5) {
        config = config.with_memory_pairs(single([20.0, 6e4], rng).to_u16().into()).unwrap();
    }
    if rng.random_bool(0.3) {
        config = config.with_prior_sd_rad(single([1e-2, 1.0], rng)).unwrap();
    }
    if rng.random_bool(0.3) {
        config = config.with_noise_floor_px(single([0.01, 1.0], rng)).unwrap();
    }
    if rng.random_bool(0.3) {
        config = config.with_max_correction_rad(single([0.05, 1.4], rng)).unwrap();
    }
    if rng.random_bool(0.4) {
        config = config.with_lens_tracking(LensTracking::Compensate);
    }
    let mut sd =
        |most: f64| if rng.random_bool(0.3) { 0.0 } else { single([1e-3 * most, most], rng) };
    let [focal, principal_px, k1, p1, p2] = [0.1, 10.0, 0.1, 0.1, 0.1].map(&mut sd);
    match rng.random_range(0..4) {
        0 => config.without_lens_prior(),
        1 => config.with_lens_prior(LensPrior { focal, principal_px, k1, p1, p2 }).unwrap(),
        _ => config,
    }
}

/// A calibrator with its view, and the rig that it sees.
struct Life<T: Scalar> {
    view: View,
    config: Config,
    factory: FactoryCalibration<T>,
    calibrator: Box<Tested<T>>,
    rotation: [f64; 3],
    baseline: [f64; 2],
    vibration_deg: f64,
    frozen: bool,
    saved: Option<Record>,
}

impl<T: Scalar> Life<T> {
    fn new(rng: &mut ChaCha8Rng) -> Self {
        let (view, config) = (any_view(rng), any_config(rng));
        let made = [0.0; 3].map(|_| rng.random_range(-2.0..2.0));
        let factory = if rng.random() {
            FactoryCalibration::guess(view.cameras())
        } else {
            let made = FactoryCalibration::new(view.cameras(), rig(made, BASELINE));
            made.with_yaw_sd_rad(single([1e-5, 0.1], rng)).unwrap()
        };
        let vibration_deg = if rng.random_bool(0.3) { log_uniform([0.005, 0.4], rng) } else { 0.0 };
        let mut off = |x: f64| x + rng.random_range(-0.5..0.5);
        Self {
            rotation: made.map(&mut off),
            baseline: BASELINE.map(off),
            calibrator: Box::new(Tested::new(config, &factory)),
            frozen: false,
            saved: None,
            vibration_deg,
            view,
            config,
            factory,
        }
    }

    fn call(&mut self, rng: &mut ChaCha8Rng) {
        let calibrator = &mut self.calibrator;
        match rng.random_range(0..100) {
            0 => self.rotation = self.rotation.map(|x| x + rng.random_range(-1.0..1.0)),
            1 => self.baseline = self.baseline.map(|x| x + rng.random_range(-1.0..1.0)),
            2 => {
                self.frozen = !self.frozen;
                calibrator.set_frozen(self.frozen);
            }
            3 => calibrator.discard_pair(),
            4..8 => drop(calibrator.apply()),
            8 => drop(calibrator.undo()),
            9 => self.saved = Some(calibrator.snapshot()),
            10 => drop(self.saved.as_ref().map(|saved| calibrator.restore(saved))),
            11 if rng.random_bool(0.3) => calibrator.reset(),
            12 => self.view.noise_px = log_uniform([0.01, 1.5], rng),
            kind => self.pair(kind, rng),
        }
    }

    /// Takes a pair: a good one, or one of wrong, few, far, broken or repeated matches.
    fn pair(&mut self, kind: u32, rng: &mut ChaCha8Rng) {
        let mut view = self.view;
        match kind {
            13 => view.wrong = 1.0,
            14 => view.matches = rng.random_range(0..20),
            15 | 16 => view.depths = [300.0, 3000.0],
            _ => {}
        }
        let turned = self.rotation.map(|x| x + self.vibration_deg * rng.random_range(-1.7..1.7));
        let mut pair = view.pair::<T>(&rig(turned, self.baseline), rng);
        if kind == 17 {
            pair.iter_mut().step_by(3).for_each(|c| c.left[0] = T::lit(f64::NAN));
        }
        take(&mut self.calibrator, &pair);
        if kind == 18 {
            take(&mut self.calibrator, &pair);
        }
    }

    /// Checks the snapshot of a locked estimate.
    fn check(&self, at: &str) {
        if self.calibrator.state() != State::Locked {
            return;
        }
        let mut copy = Tested::new(self.config, &self.factory);
        let Some(both) = restored(&self.calibrator, &mut copy, at) else { return };
        let ([r, t], [sd, sd_t]) = (apart(&both), widened(&both));
        // The weights may hide a part of a lens that is compensated.
        assert!(r < 0.02 && t < 1.5, "{at}: {r} {t}");
        // A record leaves out drift and image halves, which only widen. A vibrating rig whose baseline hardly differs
        // from an error of the lens gets a wider one.
        let [_, Proposal { vibration, .. }] = both;
        let most = if vibration.is_none() { 1.05 } else { 30.0 };
        assert!(sd < 1.1 && sd_t < most, "{at}: {sd} {sd_t}");
    }
}

fn live<T: Scalar>(seed: u64) {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut life = Life::<T>::new(rng);
    for call in 0..60 {
        life.call(rng);
        life.check(&format!("{seed}, {call}"));
    }
}

#[test]
fn every_snapshot_of_a_locked_estimate_restores_it_in_random_lives() {
    // The first 30, and lives with a large response, a lens of rounding errors, and noise of disparities above the
    // information and below zero.
    let seeds = (0..30).chain([78, 466, 681, 1348]).chain(30..runs(30, 1500));
    for seed in seeds {
        if seed % 3 == 0 { live::<f64>(seed) } else { live::<f32>(seed) }
    }
}
