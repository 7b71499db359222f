//! Mueller and Wuensche, "Continuous stereo camera calibration in urban scenarios", ITSC 2017.
//!
//! An extended Kalman filter over the extrinsics and the points observed in a pair. A point is in the state for one
//! pair only. Its four image coordinates measure the point and the extrinsics. Before the next pair its block is
//! marginalised by the Schur complement of its three unknowns. The update by a pair is iterated; outliers are rejected
//! block by block.
//!
//! Filled in: points as left coordinates and inverse depth; the prior of the inverse depth; rejection, prior and
//! process noise (`filter`). Left out: intrinsics, and points tracked over time.

use nalgebra::{
    Matrix2x3, Matrix3, Matrix4x3, Matrix5, Matrix5x3, SMatrix, Vector3, Vector4, Vector5,
};
use stereo_selfcal::Extrinsics;

use super::filter::{self, Belief, limit};
use super::method::{Method, Setting};
use super::pose::Pose;
use rigs::data::Rays;

/// Standard deviation of the prior of an inverse depth, in units of 1 / baseline.
const INVERSE_DEPTH_SD: f64 = 1.0;

/// The method.
#[derive(Debug, Clone, Copy)]
pub struct MuellerBlock;

impl Method for MuellerBlock {
    fn name(&self) -> &'static str {
        "mueller-block"
    }

    fn source(&self) -> &'static str {
        "Mueller and Wuensche, ITSC 2017: iterated extended Kalman filter over extrinsics and observed \
         points, points marginalised block by block. Extrinsics only, no tracks. Filled in: inverse \
         depth, rejection by the median, prior 0.1 rad, process noise"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        filter::iterated(pairs, setting, |prior, about, rays| {
            updated(prior, &about.pose, rays, setting.noise())
        })
    }
}

/// The measurement of the extrinsics by a block whose point is marginalised, for noise of standard deviation 1 at unit
/// depth.
struct Block {
    information: Matrix5<f64>,
    gradient: Vector5<f64>,
    /// Distance of the four measured coordinates from the coordinates of the best point, unit depth.
    miss: f64,
}

/// `prior` updated by the blocks of a pair, without the outliers, linearised at `at`. `None` if a covariance is not
/// positive definite.
fn updated(prior: &Belief, at: &Pose, rays: &[Rays], noise: f64) -> Option<Belief> {
    let blocks: Vec<Block> = rays.iter().filter_map(|rays| block(at, rays, noise)).collect();
    let limit = limit(blocks.iter().map(|block| block.miss), noise);
    let (mut information, mut gradient) = (Matrix5::zeros(), Vector5::zeros());
    for block in blocks.iter().filter(|block| block.miss <= limit) {
        information += block.information;
        gradient += block.gradient;
    }
    let variance = noise * noise;
    prior.corrected(at, information / variance, gradient / variance)
}

/// The block of one correspondence. `None` if the depth of its point in the right camera, divided by the depth in the
/// left camera, is below 0.1, or if the information on the point is singular.
fn block(at: &Pose, [p_l, p_r]: &Rays, noise: f64) -> Option<Block> {
    let turned = at.r * p_l;
    let inverse_depth = inverse_depth(at, &turned, p_r);
    // The point in the right camera frame, divided by its depth in the left camera.
    let p = turned + at.t * inverse_depth;
    if p.z < 0.1 {
        return None;
    }
    let projection = Matrix2x3::new(1.0, 0.0, -p.x / p.z, 0.0, 1.0, -p.y / p.z) / p.z;
    // The point is taken on the left ray, so its left coordinates equal their measurements.
    let miss = Vector4::new(0.0, 0.0, p.x / p.z - p_r.x, p.y / p.z - p_r.y);
    let r = at.r.matrix();
    // Derivatives by the left coordinates and the inverse depth.
    let by_point = Matrix3::from_columns(&[r.column(0).into(), r.column(1).into(), at.t]);
    let mut j_point = Matrix4x3::identity();
    j_point.fixed_rows_mut::<2>(2).copy_from(&(projection * by_point));
    let [b, c] = at.across();
    let mut by_pose = SMatrix::<f64, 3, 5>::zeros();
    by_pose.fixed_columns_mut::<3>(0).copy_from(&-turned.cross_matrix());
    by_pose.set_column(3, &(b * inverse_depth));
    by_pose.set_column(4, &(c * inverse_depth));
    let mut j_pose = SMatrix::<f64, 4, 5>::zeros();
    j_pose.fixed_rows_mut::<2>(2).copy_from(&(projection * by_pose));

    let mut point = j_point.tr_mul(&j_point);
    point[(2, 2)] += (noise / INVERSE_DEPTH_SD).powi(2);
    let inverse = point.try_inverse()?;
    let cross: Matrix5x3<f64> = j_pose.tr_mul(&j_point);
    let towards: Vector3<f64> = inverse * j_point.tr_mul(&miss);
    let information = j_pose.tr_mul(&j_pose) - cross * inverse * cross.transpose();
    let gradient = j_pose.tr_mul(&miss) - cross * towards;
    let left = miss - j_point * towards;
    Some(Block { information, gradient, miss: left.norm() })
}

/// The inverse depth `rho` at which `turned + t rho` is nearest to the right ray; 0 for a right ray along `t`.
fn inverse_depth(at: &Pose, turned: &Vector3<f64>, p_r: &Vector3<f64>) -> f64 {
    let across = p_r.cross(&at.t);
    let squared = across.norm_squared();
    if squared > 0.0 { -across.dot(&p_r.cross(turned)) / squared } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::tests::{NOISE, assert_covariance_is_the_bound, clean_pair};

    #[test]
    fn with_its_points_marginalised_a_pair_reaches_its_cramer_rao_bound() {
        let (rig, rays) = clean_pair();
        let prior = Belief { pose: Pose::of(&rig), covariance: Matrix5::identity() };
        let updated = updated(&prior, &prior.pose, &rays, NOISE).unwrap();
        assert_covariance_is_the_bound(&updated.covariance, &rig, &rays);
        assert!(prior.pose.step_to(&updated.pose).norm() < 1e-12);
    }
}
