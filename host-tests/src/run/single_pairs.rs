//! Single pairs, each solved alone: times and errors.

use std::fmt;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use serde::Serialize;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration,
    Intrinsics, Lens, Scalar,
};

use crate::data::{PairFile, TruePair, in_f64};
use crate::stats::{mean, quantile, rms_deviation};

/// Error of the rotation above which a pair counts as failed, degrees.
pub const FAILURE_DEG: f64 = 1.0;

/// Largest `|x|` or `|y|` of a ray at unit depth that the benchmark accepts.
const WIDEST: f64 = 10.0;

/// Times and errors over the pairs of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SinglePairStats {
    /// Number of pairs.
    pub pairs: usize,
    /// Number of correspondences of each pair.
    pub matches: usize,
    /// Time to solve a pair that is in the batch, median, microseconds.
    pub median_us: f64,
    /// 99th percentile of the same time.
    pub p99_us: f64,
    /// Time to take a pair into the batch, median, microseconds.
    pub push_median_us: f64,
    /// RMS angle between estimated and true `t`, over the pairs with an estimate, degrees.
    pub e_t_deg: f64,
    /// RMS distance between estimated and true rotation vector, over the same pairs, degrees.
    pub e_theta_deg: f64,
    /// Number of pairs without an estimate, or with a rotation off by more than [`FAILURE_DEG`].
    pub failures: usize,
    /// Number of pairs without an estimate: the calibrator did not solve them.
    pub refused: usize,
    /// Number of passes over the batch, mean over the pairs with an estimate.
    pub passes: f64,
}

impl fmt::Display for SinglePairStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} pairs of {} correspondences", self.pairs, self.matches)?;
        let Self { median_us, p99_us, push_median_us, passes, .. } = self;
        writeln!(
            f,
            "time      {median_us:.1} us a pair median, {p99_us:.1} us p99; {passes:.1} passes; \
             pushed in {push_median_us:.1} us"
        )?;
        writeln!(f, "error     e_t {:.4}, e_theta {:.4} deg RMS", self.e_t_deg, self.e_theta_deg)?;
        let Self { failures, refused, .. } = self;
        write!(f, "failures  {failures}: e_theta above {FAILURE_DEG} deg, or refused ({refused})")
    }
}

/// One pair solved.
struct TimedPair {
    push: Duration,
    solve: Duration,
    found: Option<(Deviation<f64>, u16)>,
}

/// Solves each pair alone, from `R = I`, `t = (-1, 0, 0)`.
///
/// * `focal`: focal length of the calibrator's camera, px.
/// * `rounds`: number of timed rounds over the file; an untimed round comes first.
/// * `each`: called after each pair of each round.
///
/// # Errors
/// If a ray has a coordinate above 10 at unit depth (84 degrees from the axis), the image at this focal length is too
/// large, the focal length is out of range, or the pairs are longer than the capacity.
pub fn run<T: Scalar, const N: usize>(
    file: &PairFile,
    config: Config,
    focal: f64,
    rounds: u32,
    mut each: impl FnMut(),
) -> Result<SinglePairStats> {
    ensure!(file.matches() <= N, "pairs of {} are longer than {N}", file.matches());
    let bench = BenchCamera::of(file, focal)?;
    let factory = FactoryCalibration::guess(bench.cameras()?);
    let mut calibrator = Box::new(Calibrator::<T, N>::new(config, &factory));
    let batches: Vec<_> = file.pairs.iter().map(|pair| bench.pixels::<T>(pair)).collect();
    let mut solved = Vec::new();
    let [mut pushes, mut solves] = [const { Vec::new() }; 2];
    for round in 0..=rounds {
        solved.clear();
        for (pair, batch) in file.pairs.iter().zip(&batches) {
            let one = solve(&mut calibrator, batch, &pair.truth)?;
            if round > 0 {
                pushes.push(one.push);
                solves.push(one.solve);
            }
            solved.push(one);
            each();
        }
    }
    let found: Vec<_> = solved.iter().filter_map(|one| one.found).collect();
    let rms = rms_deviation(found.iter().map(|(error, _)| *error));
    let failed = |error: &Deviation<f64>| error.rotation.to_degrees() > FAILURE_DEG;
    let refused = solved.len() - found.len();
    Ok(SinglePairStats {
        pairs: file.pairs.len(),
        matches: file.matches(),
        median_us: quantile_us(&solves, 0.5),
        p99_us: quantile_us(&solves, 0.99),
        push_median_us: quantile_us(&pushes, 0.5),
        e_t_deg: rms.translation.to_degrees(),
        e_theta_deg: rms.rotation.to_degrees(),
        failures: refused + found.iter().filter(|(error, _)| failed(error)).count(),
        refused,
        passes: mean(found.iter().map(|(_, passes)| f64::from(*passes))).unwrap_or(f64::NAN),
    })
}

/// Pushes one pair into the batch, solves it alone, and measures both times.
fn solve<T: Scalar, const N: usize>(
    calibrator: &mut Calibrator<T, N>,
    batch: &[Correspondence<T>],
    truth: &Extrinsics<f64>,
) -> Result<TimedPair> {
    calibrator.reset();
    let started = Instant::now();
    for correspondence in batch {
        calibrator.push(correspondence)?;
    }
    let push = started.elapsed();
    let started = Instant::now();
    let outcome = calibrator.solve_pair();
    let solve = started.elapsed();
    let error = |found: &Extrinsics<T>| Deviation::between(&in_f64(found), truth);
    let found = outcome.pair.map(|report| (error(&report.extrinsics), report.passes));
    Ok(TimedPair { push, solve, found })
}

/// A pinhole camera whose image is just large enough for all rays, with the principal point in its middle.
struct BenchCamera {
    focal: f64,
    centre: [f64; 2],
}

impl BenchCamera {
    fn of(file: &PairFile, focal: f64) -> Result<Self> {
        let rays = || file.pairs.iter().flat_map(|pair| &pair.rays);
        let widest = |x: fn(&[f64; 4]) -> [f64; 2]| {
            rays().flat_map(x).fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        let [x, y] = [widest(|r| [r[0], r[2]]), widest(|r| [r[1], r[3]])];
        ensure!(x.max(y) <= WIDEST, "a ray is further out than {WIDEST} at unit depth: {x}, {y}");
        let centre = [x, y].map(|tangent| (tangent * focal).ceil() + 1.0);
        let most = f64::from(u16::MAX);
        ensure!(2.0 * centre[0].max(centre[1]) < most, "at {focal} px the image is too large");
        Ok(Self { focal, centre })
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within u16, see `of`"
    )]
    fn cameras<T: Scalar>(&self) -> Result<Cameras<T>> {
        let intrinsics = Intrinsics {
            focal: [T::lit(self.focal); 2],
            principal: self.centre.map(T::lit),
            size: self.centre.map(|c| (2.0 * c) as u16 + 1),
        };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
        Ok(Cameras { left: camera, right: camera })
    }

    fn pixels<T: Scalar>(&self, pair: &TruePair) -> Vec<Correspondence<T>> {
        let pixel = |x: f64, y: f64| {
            let [cx, cy] = self.centre;
            [T::lit(x * self.focal + cx), T::lit(y * self.focal + cy)]
        };
        let correspondence = |&[x_l, y_l, x_r, y_r]: &[f64; 4]| Correspondence {
            left: pixel(x_l, y_l),
            right: pixel(x_r, y_r),
            score: T::ONE,
            grid_step: T::ZERO,
        };
        pair.rays.iter().map(correspondence).collect()
    }
}

/// Quantile of times, microseconds; NaN without a time.
fn quantile_us(times: &[Duration], share: f64) -> f64 {
    quantile(times.iter().map(|time| time.as_secs_f64() * 1e6), share).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{ScenarioKind, Scene, rig};

    fn generated(matches: usize) -> PairFile {
        let rig = rig([3.0, -2.0, 4.0], [3.0, -3.0]).unwrap();
        let scene = Scene { rig, matches, outliers: 0.3, ..ScenarioKind::Near.scene() };
        PairFile::of(&scene.dataset(20, 1).unwrap()).unwrap()
    }

    #[test]
    fn every_pair_is_solved_alone_and_counted_once() {
        let file = generated(128);
        let mut calls = 0;
        let all = run::<f32, 128>(&file, Config::robust(), 1400.0, 2, || calls += 1).unwrap();
        assert_eq!((all.pairs, all.matches, all.failures, all.refused), (20, 128, 0, 0));
        assert_eq!(calls, 60);
        assert!(all.e_t_deg < 0.3 && all.e_theta_deg < 0.1, "{all}");
        assert!(all.median_us > 0.0 && all.p99_us >= all.median_us, "{all}");
        let backwards = PairFile { pairs: file.pairs.iter().rev().cloned().collect() };
        let again = run::<f32, 128>(&backwards, Config::robust(), 1400.0, 1, || ()).unwrap();
        assert!((again.e_t_deg - all.e_t_deg).abs() < 1e-12, "the order of the pairs matters");
    }

    #[test]
    fn a_pair_without_an_estimate_is_a_failure_and_enters_no_mean() {
        let mut file = generated(64);
        file.pairs[3].rays.fill([0.1, 0.1, 0.1, 0.1]);
        let all = run::<f64, 64>(&file, Config::robust(), 1400.0, 1, || ()).unwrap();
        assert_eq!((all.failures, all.refused), (1, 1));
        assert!(all.e_t_deg.is_finite());
    }

    #[test]
    fn a_truth_that_is_off_by_more_than_a_degree_is_a_failure() {
        let mut file = generated(128);
        file.pairs[0].truth = rig([3.0, -2.0, 5.5], [3.0, -3.0]).unwrap();
        let all = run::<f32, 128>(&file, Config::robust(), 1400.0, 1, || ()).unwrap();
        assert_eq!((all.failures, all.refused), (1, 0));
    }

    #[test]
    fn pairs_that_do_not_fit_are_refused() {
        let file = generated(128);
        let said = |file: &PairFile, focal| {
            format!("{:#}", run::<f32, 64>(file, Config::robust(), focal, 1, || ()).unwrap_err())
        };
        assert!(said(&file, 1400.0).contains("longer than 64"));
        let mut wide = generated(64);
        wide.pairs[0].rays[0][0] = 11.0;
        assert!(said(&wide, 1400.0).contains("further out"));
        assert!(said(&generated(64), 1e6).contains("too large"));
    }
}
