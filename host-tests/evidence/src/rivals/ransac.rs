//! Five-point RANSAC with refinement, as is common practice.
//!
//! M. A. Fischler and R. C. Bolles, 1981, with minimal samples by `five_point`. The score is the sum of truncated
//! squares of Sampson residuals (Torr and Zisserman, MSAC, 2000). Samples are drawn until one of them has only true
//! matches with a probability of 0.999. The best `E` gives the pose with most points in front of both cameras, which is
//! then refined twice on its inliers. Each pair is solved alone; the estimates are fused by the chordal mean of `R` and
//! the mean direction of `t`. The start only serves to refuse poses that are far from it. The matches of a plane fit
//! two poses, and the wrong one is far from the start.
//!
//! It is written here, because the crate `eight-point` (2020) needs an old nalgebra, and `kornia-3d`, which has all of
//! it, brings 165 crates.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::SeedableRng;
use rand::seq::index::sample_array;
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::five_point::five_point;
use super::fusion::{Chordal, running};
use super::gate;
use super::method::{Method, Setting, usable};
use super::minimise::{FEWEST, Loss, minimise};
use super::pose::{Essential, Pose};
use rigs::data::Rays;

/// A match is an inlier within so many deviations of the noise.
const INLIER_SD: f64 = 3.0;

/// The search ends once the probability that every sample has a false match is at most this.
const MISSED: f64 = 1e-3;

/// Largest number of samples: enough for 60 % of outliers.
const MOST_SAMPLES: f64 = 700.0;

/// Rounds of refinement, each on the inliers of the previous one.
const REFINEMENTS: usize = 2;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct Ransac;

impl Method for Ransac {
    fn name(&self) -> &'static str {
        "ransac"
    }

    fn source(&self) -> &'static str {
        "common practice: five-point RANSAC (Stewenius, Engels and Nister 2006), MSAC score at 3 noise \
         deviations, Sampson refinement of the inliers, poses further than 0.5 rad \
         from the start refused, pair by pair; chordal mean of R, mean direction of t"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        let (start, limit) = (Pose::of(&setting.start), INLIER_SD * setting.noise());
        let single = |(rays, seed): (&Vec<Rays>, u64)| {
            let rays = usable(rays);
            gate::passed(Search { rays: &rays, limit, start }.refined(seed), &rays, setting)
        };
        running::<Chordal>(pairs.iter().zip(0..).map(single))
    }
}

/// The refined pose of a pair, and its inliers; `None` if no sample gives a pose, or if the refinement fails.
///
/// * `noise`: standard deviation of a coordinate, unit depth.
/// * `seed`: seed of the samples.
pub(super) fn inliers(
    rays: &[Rays],
    setting: &Setting,
    noise: f64,
    seed: u64,
) -> Option<(Pose, Vec<Rays>)> {
    let search = Search { rays, limit: INLIER_SD * noise, start: Pose::of(&setting.start) };
    let pose = search.refined(seed)?;
    Some((pose, search.inliers(&pose.essential().e)))
}

/// RANSAC on one pair.
struct Search<'a> {
    rays: &'a [Rays],
    /// Largest Sampson residual of an inlier, unit depth.
    limit: f64,
    start: Pose,
}

impl Search<'_> {
    /// The best pose of all samples, refined; `None` if there is no pose, or the refinement fails.
    fn refined(&self, seed: u64) -> Option<Pose> {
        let mut pose = self.best(seed)?;
        for _ in 0..REFINEMENTS {
            // Quadratic on all inliers; linear on matches that stop being inliers on the way.
            let inliers = self.inliers(&pose.essential().e);
            pose = minimise(&pose, &inliers, Scaling::Sampson, Loss::Huber(self.limit))?;
        }
        Some(pose)
    }

    /// The pose with the least score among the poses of all samples that are near the start. `None` without such a
    /// pose, and for [`FEWEST`] rays or fewer.
    fn best(&self, seed: u64) -> Option<Pose> {
        if self.rays.len() <= FEWEST {
            return None;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut least, mut best) = (f64::INFINITY, None);
        let (mut drawn, mut needed) = (0.0, MOST_SAMPLES);
        while drawn < needed {
            drawn += 1.0;
            let sample: [usize; 5] = sample_array(&mut rng, self.rays.len())?;
            for e in five_point(&sample.map(|i| self.rays[i])) {
                let (score, inliers) = self.score(&e);
                if score < least
                    && let Some(pose) = self.near_the_start(&e)
                {
                    (least, best) = (score, Some(pose));
                    let all_true: f64 = inliers.powi(5);
                    needed = (MISSED.ln() / (-all_true).ln_1p()).min(MOST_SAMPLES);
                }
            }
        }
        best
    }

    /// Sum of `min((residual / limit)^2, 1)`, and share of inliers.
    fn score(&self, e: &Matrix3<f64>) -> (f64, f64) {
        let (mut score, mut inliers, mut all) = (0.0, 0.0, 0.0);
        for rays in self.rays {
            let over = sampson(e, rays) / self.limit;
            score += (over * over).min(1.0);
            inliers += f64::from(u8::from(over.abs() <= 1.0));
            all += 1.0;
        }
        (score, inliers / all)
    }

    fn inliers(&self, e: &Matrix3<f64>) -> Vec<Rays> {
        let rays = self.rays.iter();
        rays.filter(|rays| sampson(e, rays).abs() <= self.limit).copied().collect()
    }

    /// The pose of a matrix, if it is near the start ([`gate::is_near`]).
    fn near_the_start(&self, e: &Matrix3<f64>) -> Option<Pose> {
        let pose = decomposed(e, &self.inliers(e))?;
        gate::is_near(&pose, &self.start).then_some(pose)
    }
}

pub(super) fn sampson(e: &Matrix3<f64>, rays: &Rays) -> f64 {
    Scaling::Sampson.residual(&Essential { e: *e, by: [Matrix3::zeros(); 5] }, rays)
}

/// The pose of an essential matrix with most points in front of both cameras, out of four.
fn decomposed(e: &Matrix3<f64>, rays: &[Rays]) -> Option<Pose> {
    let svd = e.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let (u, v_t) = (u * u.determinant().signum(), v_t * v_t.determinant().signum());
    let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let turns = [quarter, quarter.transpose()].map(|w| u * w * v_t);
    let t: Vector3<f64> = u.column(2).into();
    let poses = turns.iter().flat_map(|r| {
        let r = Rotation3::from_matrix_unchecked(*r);
        [Pose { r, t }, Pose { r, t: -t }]
    });
    let in_front = |pose: &Pose| rays.iter().filter(|rays| is_in_front(pose, rays)).count();
    poses.max_by_key(in_front)
}

/// Whether `z_r p_r = z_l R p_l + t` has both depths above 0.
fn is_in_front(pose: &Pose, [p_l, p_r]: &Rays) -> bool {
    let turned = pose.r * p_l;
    let across = turned.cross(p_r);
    across.dot(&p_r.cross(&pose.t)) > 0.0 && across.dot(&turned.cross(&pose.t)) > 0.0
}
