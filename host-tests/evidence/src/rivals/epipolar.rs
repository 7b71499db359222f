//! The epipolar constraint `e = p_r^T E p_l` in the scalings of the publications, and derivatives.
//!
//! `a`, `b`: squared lengths of the normals `(E p_l)_xy` and `(E^T p_r)_xy` of the epipolar lines in
//! the right and the left image.

use nalgebra::Vector5;

use super::pose::Essential;
use rigs::data::Rays;

/// Factor of the constraint.
#[derive(Debug, Clone, Copy)]
pub(super) enum Scaling {
    /// 1: the algebraic residual.
    Algebraic,
    /// `sqrt(1/a + 1/b)`: the root of the sum of the squared distances of both points to their epipolar lines.
    Distances,
    /// `1 / sqrt(a + b)`: the constraint divided by its deviation for equal noise of all coordinates (Sampson).
    Sampson,
}

impl Scaling {
    /// Signed residual, unit depth.
    pub(super) fn residual(self, essential: &Essential, [p_l, p_r]: &Rays) -> f64 {
        let (n_r, n_l) = (essential.e * p_l, essential.e.tr_mul(p_r));
        let (factor, ..) = self.factor(n_r.xy().norm_squared(), n_l.xy().norm_squared());
        p_r.dot(&n_r) * factor
    }

    /// The signed residual, and its derivative by the five unknowns of the pose.
    pub(super) fn linearised(
        self,
        essential: &Essential,
        [p_l, p_r]: &Rays,
    ) -> (f64, Vector5<f64>) {
        let (n_r, n_l) = (essential.e * p_l, essential.e.tr_mul(p_r));
        let (factor, by_a, by_b) = self.factor(n_r.xy().norm_squared(), n_l.xy().norm_squared());
        let e = p_r.dot(&n_r);
        let j = Vector5::from_fn(|i, _| {
            let (m_r, m_l) = (essential.by[i] * p_l, essential.by[i].tr_mul(p_r));
            let (a, b) = (2.0 * n_r.xy().dot(&m_r.xy()), 2.0 * n_l.xy().dot(&m_l.xy()));
            p_r.dot(&m_r) * factor + e * (by_a * a + by_b * b)
        });
        (e * factor, j)
    }

    /// The factor, and its derivatives by `a` and `b`.
    fn factor(self, a: f64, b: f64) -> (f64, f64, f64) {
        match self {
            Self::Algebraic => (1.0, 0.0, 0.0),
            Self::Distances => {
                let factor = (1.0 / a + 1.0 / b).sqrt();
                (factor, -0.5 / (factor * a * a), -0.5 / (factor * b * b))
            }
            Self::Sampson => {
                let factor = 1.0 / (a + b).sqrt();
                let by = -0.5 * factor / (a + b);
                (factor, by, by)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::rivals::pose::Pose;
    use sim::synth;

    #[test]
    fn derivatives_of_all_scalings_match_central_differences() {
        let pose = Pose::of(&synth::rig([4.0, -3.0, 2.0], [6.0, -5.0]).unwrap());
        let rays = [Vector3::new(0.3, -0.2, 1.0), Vector3::new(0.1, 0.25, 1.0)];
        for scaling in [Scaling::Algebraic, Scaling::Distances, Scaling::Sampson] {
            let (e, j) = scaling.linearised(&pose.essential(), &rays);
            assert_eq!(e.to_bits(), scaling.residual(&pose.essential(), &rays).to_bits());
            let numeric = Vector5::from_fn(|i, _| {
                let at = |h| scaling.residual(&pose.moved(&Vector5::ith(i, h)).essential(), &rays);
                (at(1e-5) - at(-1e-5)) / 2e-5
            });
            assert!((numeric - j).norm() < 1e-8, "{scaling:?}: {numeric} {j}");
        }
    }
}
