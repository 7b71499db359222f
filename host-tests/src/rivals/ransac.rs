//! Five-point RANSAC with refinement: what is used where nothing is known of the rig.
//!
//! M. A. Fischler and R. C. Bolles, 1981; minimal samples by `five_point`; truncated squares of
//! Sampson residuals as the score (Torr and Zisserman, MSAC, 2000); samples until an all-true one was
//! drawn with a probability of 0.999. The best `E` is decomposed by the side the points are on, then
//! refined on its inliers twice. Each pair by itself, the start unused; over pairs the chordal mean of
//! `R` and the mean direction of `t`.
//!
//! Written here: of the crates, `eight-point` is of 2020 and needs a nalgebra of its time, and
//! `kornia-3d`, which has all of it, brings 165 crates.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::SeedableRng;
use rand::seq::index::sample_array;
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Extrinsics;

use super::epipolar::Scaling;
use super::five_point::five_point;
use super::fusion::{Chordal, running};
use super::minimise::{Loss, minimise};
use super::pose::{Essential, Pose};
use super::{Method, Setting, usable};
use crate::oracle::Rays;

/// A match is an inlier within so many deviations of the noise.
const INLIER_SD: f64 = 3.0;

/// Chance that no sample was of true matches only.
const MISSED: f64 = 1e-3;

/// Samples drawn at most: enough for 60 % of mismatches.
const MOST_SAMPLES: f64 = 700.0;

/// Rounds of refinement, each on the inliers of the one before.
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
         deviations, Sampson refinement of the inliers, pair by pair without the start; chordal mean \
         of R, mean direction of t"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        running::<Chordal>(
            pairs
                .iter()
                .zip(0..)
                .map(|(rays, seed)| single(&usable(rays), INLIER_SD * setting.noise(), seed)),
        )
    }
}

/// One pair.
///
/// * `limit`: what a Sampson residual of an inlier is at most.
fn single(rays: &[Rays], limit: f64, seed: u64) -> Option<Pose> {
    let e = search(rays, limit, seed)?;
    let inliers = |e: Matrix3<f64>| -> Vec<Rays> {
        rays.iter().filter(|rays| sampson(&e, rays).abs() <= limit).copied().collect()
    };
    let mut inside = inliers(e);
    let mut pose = decomposed(&e, &inside)?;
    for _ in 0..REFINEMENTS {
        // Quadratic on all that are inliers; linear on what leaves them on the way.
        pose = minimise(&pose, &inside, Scaling::Sampson, Loss::Huber(limit))?;
        inside = inliers(pose.essential().e);
    }
    Some(pose)
}

fn sampson(e: &Matrix3<f64>, rays: &Rays) -> f64 {
    Scaling::Sampson.residual(&Essential { e: *e, by: [Matrix3::zeros(); 5] }, rays)
}

/// The best matrix of all samples, by truncated squares.
fn search(rays: &[Rays], limit: f64, seed: u64) -> Option<Matrix3<f64>> {
    if rays.len() < 6 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best = (f64::INFINITY, None);
    let (mut drawn, mut needed) = (0.0, MOST_SAMPLES);
    while drawn < needed {
        drawn += 1.0;
        let chosen: [usize; 5] = sample_array(&mut rng, rays.len())?;
        for e in five_point(&chosen.map(|i| rays[i])) {
            let (mut score, mut inliers, mut all) = (0.0, 0.0, 0.0);
            for rays in rays {
                let over = sampson(&e, rays) / limit;
                all += 1.0;
                inliers += f64::from(u8::from(over.abs() <= 1.0));
                score += (over * over).min(1.0);
            }
            if score < best.0 {
                best = (score, Some(e));
                let true_sample: f64 = f64::powi(inliers / all, 5);
                needed = (MISSED.ln() / (-true_sample).ln_1p()).min(MOST_SAMPLES);
            }
        }
    }
    best.1
}

/// Of the four poses of an essential matrix, that with most points in front of both cameras.
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
