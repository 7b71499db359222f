//! Wide-angle lenses, in `f32`: single pairs and fused estimates against the Cramer-Rao bound with the noise of the
//! pixels, which are larger parts of the plane at unit depth towards the border.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rigs::data::in_f64;
use sim::bounds::cramer_rao_through;
use sim::stats::rms_deviation;
use sim::synth::rig;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{Fisheye, RadialTangential, Rational};
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration,
    Intrinsics, Lens, Scalar,
};
use test_support::runs;

const SIZE: [u16; 2] = [1280, 960];
const FOCAL: f64 = 400.0;
const NOISE_PX: f64 = 0.3;
const MATCHES: usize = 400;
/// Share of wrong matches: the right pixel is anywhere in the image.
const WRONG: f64 = 0.1;
/// Depths, in baselines.
const DEPTHS: [f64; 2] = [3.0, 80.0];
/// Pairs of a fused estimate.
const PAIRS: usize = 20;

/// A lens, in either number type.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Pinhole,
    Fisheye([f64; 4]),
    RadialTangential([f64; 5]),
    Rational([f64; 8]),
}

fn cameras<T: Scalar>(kind: Kind) -> Cameras<T> {
    let lens = match kind {
        Kind::Pinhole => Lens::Pinhole,
        Kind::Fisheye(k) => Lens::Fisheye(Fisheye::try_new(k.map(T::lit)).unwrap()),
        Kind::RadialTangential(k) => {
            Lens::RadialTangential(RadialTangential::try_new(k.map(T::lit)).unwrap())
        }
        Kind::Rational(k) => Lens::Rational(Rational::try_new(k.map(T::lit)).unwrap()),
    };
    let principal = SIZE.map(|n| T::lit(f64::from(n - 1) / 2.0));
    let intrinsics = Intrinsics { focal: [T::lit(FOCAL); 2], principal, size: SIZE };
    let camera = Camera::try_new(intrinsics, lens).unwrap();
    Cameras { left: camera, right: camera }
}

/// A rig that sees points up to an angle from the axes.
struct View {
    kind: Kind,
    degrees: f64,
    rig: Extrinsics<f64>,
}

/// Matches, and the noise-free pixels of the true ones.
struct Pair {
    matches: Vec<Correspondence<f32>>,
    clean: Vec<[f64; 4]>,
}

impl View {
    fn new(kind: Kind, degrees: f64, rng: &mut ChaCha8Rng) -> Self {
        let turn = [0.0; 3].map(|_: f64| rng.random_range(-3.0..3.0));
        let baseline = [0.0; 2].map(|_: f64| rng.random_range(-3.0..3.0));
        Self { kind, degrees, rig: rig(turn, baseline).unwrap() }
    }

    fn pair(&self, rng: &mut ChaCha8Rng) -> Pair {
        let cameras = cameras::<f64>(self.kind);
        let mut pair = Pair { matches: Vec::new(), clean: Vec::new() };
        while pair.matches.len() < MATCHES {
            let Some(clean) = self.point(&cameras, rng) else { continue };
            let mut pixels = clean;
            let is_wrong = rng.random_bool(WRONG);
            if is_wrong {
                let last = SIZE.map(|n| f64::from(n - 1));
                [pixels[2], pixels[3]] = last.map(|last| rng.random_range(0.0..last));
            }
            for x in &mut pixels {
                let noise: f64 = StandardNormal.sample(rng);
                *x += NOISE_PX * noise;
            }
            let [ul, vl, ur, vr] = pixels.map(f32::lit);
            let (left, right) = ([ul, vl], [ur, vr]);
            pair.matches.push(Correspondence { left, right, score: 1.0, grid_step: 0.0 });
            if !is_wrong {
                pair.clean.push(clean);
            }
        }
        pair
    }

    /// Pixels of a point that both cameras see within the angle.
    fn point(&self, cameras: &Cameras<f64>, rng: &mut ChaCha8Rng) -> Option<[f64; 4]> {
        const BORDER: f64 = 3.0;
        let last = SIZE.map(|n| f64::from(n - 1) - BORDER);
        let left @ [ul, vl] = last.map(|last| rng.random_range(BORDER..last));
        let most = self.degrees.to_radians().tan();
        let ray = cameras.left.ray(left).ok().filter(|ray| ray.norm() < most)?.push(1.0);
        let [nearest, farthest] = DEPTHS;
        // Along the ray, because a depth of 80 baselines at 85 degrees would be 900 baselines away.
        let away = nearest * (farthest / nearest).powf(rng.random());
        let seen =
            self.rig.rotation() * (ray.normalize() * away) + self.rig.translation().into_inner();
        let right = Some(seen.xy() / seen.z).filter(|ray| seen.z > 0.0 && ray.norm() < most)?;
        let [ur, vr] = cameras.right.pixel(right).ok()?;
        let inside = |x: f64, last: f64| (BORDER..last).contains(&x);
        (inside(ur, last[0]) && inside(vr, last[1])).then_some([ul, vl, ur, vr])
    }
}

/// RMS error of `t` and of `R` over the bound, and over the reported deviation.
#[derive(Debug, Clone, Copy)]
struct Ratios {
    of_bound: [f64; 2],
    of_sd: [f64; 2],
}

#[derive(Default)]
struct Sample {
    errors: Vec<Deviation<f64>>,
    bounds: Vec<Deviation<f64>>,
    sds: Vec<Deviation<f64>>,
}

impl Sample {
    fn ratios(self) -> Ratios {
        let [error, bound, sd] = [self.errors, self.bounds, self.sds].map(rms_deviation);
        let over = |other: Deviation<f64>| {
            [error.translation / other.translation, error.rotation / other.rotation]
        };
        Ratios { of_bound: over(bound), of_sd: over(sd) }
    }
}

/// Ratios of single pairs, and of estimates over [`PAIRS`] pairs, over some rigs.
fn measured(kind: Kind, degrees: f64, rigs: u64) -> [Ratios; 2] {
    let [mut single, mut fused] = [Sample::default(), Sample::default()];
    let through = cameras::<f64>(kind);
    for seed in 0..rigs {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let view = View::new(kind, degrees, rng);
        let factory = FactoryCalibration::guess(cameras::<f32>(kind));
        let mut calibrator = Box::new(Calibrator::<f32, MATCHES>::new(Config::robust(), &factory));
        let mut all = Vec::new();
        for _ in 0..PAIRS {
            let Pair { matches, clean } = view.pair(rng);
            let outcome = calibrator.take_pair(matches);
            let report = outcome.pair.unwrap_or_else(|| panic!("{kind:?} {seed}: {outcome:?}"));
            let sd = report.information.standard_deviations().unwrap();
            let [translation, rotation] = [sd.translation, sd.rotation].map(f64::from);
            single.errors.push(Deviation::between(&in_f64(&report.extrinsics), &view.rig));
            single.sds.push(Deviation { translation, rotation });
            single.bounds.push(cramer_rao_through(&through, &view.rig, clean.iter(), NOISE_PX));
            all.extend(clean);
        }
        let proposal = calibrator.proposal().unwrap();
        let [translation, rotation] =
            [proposal.sd.translation, proposal.sd.rotation].map(f64::from);
        fused.errors.push(Deviation::between(&in_f64(&proposal.extrinsics), &view.rig));
        fused.sds.push(Deviation { translation, rotation });
        fused.bounds.push(cramer_rao_through(&through, &view.rig, all.iter(), NOISE_PX));
    }
    [single, fused].map(Sample::ratios)
}

#[test]
fn wide_lenses_are_near_the_cramer_rao_bound_and_report_true_deviations() {
    let all = [
        (Kind::Fisheye([0.0; 4]), 72.0, 1.15),
        (Kind::Rational([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]), 55.0, 1.10),
        (Kind::Pinhole, 50.0, 1.10),
        (Kind::Fisheye([0.0; 4]), 60.0, 1.10),
        (Kind::Fisheye([0.0; 4]), 84.0, 1.25),
        (Kind::RadialTangential([-0.12, 0.012, 0.0, 0.0, 0.0]), 55.0, 1.10),
    ];
    let (lenses, rigs) = runs((2, 12), (all.len(), 100));
    for (kind, degrees, limit) in all.into_iter().take(lenses) {
        let [single, fused] = measured(kind, degrees, rigs);
        println!("{kind:?} to {degrees} degrees:\n  single {single:.2?}\n  fused  {fused:.2?}");
        // The pairs of a wide lens share a bias of up to 0.7 times the bound of 20 pairs.
        for (of, most, sds) in [(single, limit, 0.8..1.2), (fused, 1.35, 0.7..1.3)] {
            assert!(of.of_bound.iter().all(|ratio| *ratio < most), "{of:?}");
            assert!(of.of_sd.iter().all(|ratio| sds.contains(ratio)), "{of:?}");
        }
    }
}
