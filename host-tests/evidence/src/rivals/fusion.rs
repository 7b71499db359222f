//! Fusion of the estimates of single pairs: mean directions as in Zhao et al., and the chordal mean.

use nalgebra::{Matrix3, Rotation3, Vector3};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::so3;

use super::pose::Pose;

/// Sums over pairs.
pub(super) trait Fusion: Default {
    /// Adds the estimate of one pair.
    fn add(&mut self, pair: &Pose);

    /// The fused estimate of all pairs so far; `None` before the first.
    fn estimate(&self) -> Option<Pose>;
}

/// The estimate after each pair, from the estimates of single pairs; a pair without an estimate
/// changes nothing.
pub(super) fn running<F: Fusion>(
    singles: impl Iterator<Item = Option<Pose>>,
) -> Vec<Option<Extrinsics<f64>>> {
    let mut fusion = F::default();
    let fused = singles.map(|single| {
        if let Some(pose) = single.filter(|pose| pose.extrinsics().is_some()) {
            fusion.add(&pose);
        }
        fusion.estimate()?.extrinsics()
    });
    fused.collect()
}

/// `t* = normalize(sum t^k)`, `v* = normalize(sum v^k)`, `R* = exp([s* v*]x)`, `s*` the mean of the
/// angles (Zhao et al., eqs 20-22).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeanDirection {
    translations: Vector3<f64>,
    axes: Vector3<f64>,
    angles: f64,
    pairs: f64,
}

impl Fusion for MeanDirection {
    fn add(&mut self, pair: &Pose) {
        let turn = so3::log(&pair.r);
        self.translations += pair.t;
        // An angle of 0 has no axis (erratum 6).
        self.axes += turn.try_normalize(0.0).unwrap_or_default();
        self.angles += turn.norm();
        self.pairs += 1.0;
    }

    fn estimate(&self) -> Option<Pose> {
        let t = self.translations.try_normalize(0.0)?;
        let axis = self.axes.try_normalize(0.0).unwrap_or_default();
        Some(Pose { r: Rotation3::new(axis * (self.angles / self.pairs)), t })
    }
}

/// The rotation nearest to `sum R^k` in the Frobenius norm, and `normalize(sum t^k)`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chordal {
    rotations: Matrix3<f64>,
    translations: Vector3<f64>,
}

/// Largest number of iterations of a singular value decomposition.
const SWEEPS: usize = 100;

impl Fusion for Chordal {
    fn add(&mut self, pair: &Pose) {
        self.rotations += pair.r.matrix();
        self.translations += pair.t;
    }

    fn estimate(&self) -> Option<Pose> {
        let t = self.translations.try_normalize(0.0)?;
        let svd = self.rotations.try_svd(true, true, f64::EPSILON, SWEEPS)?;
        let (u, v_t) = (svd.u?, svd.v_t?);
        let sign = (u * v_t).determinant().signum();
        let proper = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign));
        Some(Pose { r: Rotation3::from_matrix_unchecked(u * proper * v_t), t })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(x: f64) -> Pose {
        Pose {
            r: Rotation3::new(Vector3::new(x, 0.0, 0.0)),
            t: Vector3::new(-x.cos(), x.sin(), 0.0),
        }
    }

    fn middle<F: Fusion>() -> Pose {
        let mut fusion = F::default();
        assert!(fusion.estimate().is_none());
        for x in [0.1, 0.2, 0.3] {
            fusion.add(&turned(x));
        }
        fusion.estimate().unwrap()
    }

    #[test]
    fn both_means_of_turns_about_one_axis_are_the_middle_one() {
        for pose in [middle::<MeanDirection>(), middle::<Chordal>()] {
            let off = pose.r.matrix() - turned(0.2).r.matrix();
            assert!(off.norm() < 1e-12 && (pose.t - turned(0.2).t).norm() < 1e-12, "{pose:?}");
        }
    }

    #[test]
    fn a_pair_without_an_estimate_changes_nothing() {
        let found = running::<Chordal>([None, Some(turned(0.2)), None].into_iter());
        assert_eq!(found[0], None);
        assert_eq!(found[1], found[2]);
        assert!(found[2].is_some());
    }
}
