//! The gate of the published method, for every method that estimates pair by pair.
//!
//! A pair is refused if its estimate is further than 0.5 rad from the start, in `R` or in `t`, or if its
//! most uncertain direction has a standard deviation above 0.12 rad: the limits of `paper::Settings::DEFAULT`.

use nalgebra::Matrix5;

use super::epipolar::Scaling;
use super::filter::limit;
use super::method::Setting;
use super::pose::Pose;
use rigs::data::Rays;

/// Largest distance of `R` and `t` from the start, rad, as in the core.
pub(super) const FURTHEST: f64 = 0.5;

/// Largest standard deviation of any direction, rad.
const MOST_UNCERTAIN: f64 = 0.12;

/// The estimate of a pair, if the setting has no gate or the pair passes it.
///
/// * `rays`: rays that it was estimated from.
pub(super) fn passed(pose: Option<Pose>, rays: &[Rays], setting: &Setting) -> Option<Pose> {
    let admitted = |pose: &Pose| {
        !setting.tuning.gated
            || (is_near(pose, &Pose::of(&setting.start)) && is_certain(pose, rays, setting.noise()))
    };
    pose.filter(admitted)
}

/// Whether `R` and `t` of a pose are within [`FURTHEST`] of `start`.
pub(super) fn is_near(pose: &Pose, start: &Pose) -> bool {
    let turned = (pose.r * start.r.inverse()).angle();
    turned <= FURTHEST && pose.t.dot(&start.t) >= FURTHEST.cos()
}

fn is_certain(pose: &Pose, rays: &[Rays], noise: f64) -> bool {
    let least = information(pose, rays, noise).symmetric_eigenvalues().min();
    // False for NaN.
    least >= 1.0 / (MOST_UNCERTAIN * MOST_UNCERTAIN)
}

/// Inverse of the Cramer-Rao bound of a pair, from the matches that fit it.
///
/// * `noise`: least standard deviation of a coordinate, unit depth. The scatter of the matches counts if it is larger.
pub(super) fn information(pose: &Pose, rays: &[Rays], noise: f64) -> Matrix5<f64> {
    let essential = pose.essential();
    let rows: Vec<_> =
        rays.iter().map(|rays| Scaling::Sampson.linearised(&essential, rays)).collect();
    let limit = limit(rows.iter().map(|(e, _)| e.abs()), noise);
    let fit = || rows.iter().filter(|(e, _)| e.abs() <= limit);
    let squares: f64 = fit().map(|(e, _)| e * e).sum();
    let count: f64 = fit().map(|_| 1.0).sum();
    let variance = (squares / count).max(noise * noise);
    fit().map(|(_, j)| j * j.transpose()).sum::<Matrix5<f64>>() / variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::Tuning;
    use crate::rivals::tests::setting;
    use crate::rivals::tests::{NOISE, assert_covariance_is_the_bound, clean_pair};
    use nalgebra::Vector5;

    #[test]
    fn a_pair_without_noise_is_measured_with_its_cramer_rao_bound() {
        let (rig, rays) = clean_pair();
        let covariance = information(&Pose::of(&rig), &rays, NOISE).try_inverse().unwrap();
        assert_covariance_is_the_bound(&covariance, &rig, &rays);
    }

    #[test]
    fn far_and_uncertain_pairs_are_refused_where_there_is_a_gate() {
        let (rig, rays) = clean_pair();
        let gated = Setting { tuning: Tuning { gated: true, ..Tuning::default() }, ..setting() };
        let pose = Pose::of(&rig);
        let far = pose.moved(&Vector5::new(0.0, 0.6, 0.0, 0.0, 0.0));
        let kept =
            |pose, rays: &[Rays], setting: Setting| passed(Some(pose), rays, &setting).is_some();
        assert!(kept(pose, &rays, gated) && kept(far, &rays, setting()));
        assert!(!kept(far, &rays, gated));
        assert!(!kept(pose, &rays[..5], Setting { noise_px: 100.0, ..gated }));
        assert!(passed(None, &rays, &gated).is_none());
    }
}
