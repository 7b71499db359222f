//! `R` and `t` as five unknowns: a turn of `R` and two directions across `t`, in the right camera frame.

use nalgebra::{Matrix3, Rotation3, Vector3, Vector5};
use stereo_selfcal::Extrinsics;

/// `R`, `t` of `p_r = R p_l + t`, `|t| = 1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    /// `R`, left to right.
    pub(super) r: Rotation3<f64>,
    /// Unit `t`.
    pub(super) t: Vector3<f64>,
}

/// `E = [t]x R`, and its derivatives by the five unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Essential {
    /// `E`.
    pub(super) e: Matrix3<f64>,
    /// `dE / dd_i`.
    pub(super) by: [Matrix3<f64>; 5],
}

impl Pose {
    pub(super) fn of(extrinsics: &Extrinsics<f64>) -> Self {
        Self { r: *extrinsics.rotation(), t: extrinsics.translation().into_inner() }
    }

    /// `None` if it is not finite, or `t` is within 6 degrees of an optical axis.
    pub(super) fn extrinsics(&self) -> Option<Extrinsics<f64>> {
        Extrinsics::try_new(self.r.matrix(), &self.t).ok()
    }

    /// The pose after a step `d = [w, a]`, rad: `exp([w]x) R` and `normalize(t + B a)`, with `B` of [`Self::across`].
    pub(super) fn moved(&self, d: &Vector5<f64>) -> Self {
        let [b, c] = self.across();
        Self {
            r: Rotation3::new(d.fixed_rows::<3>(0).into_owned()) * self.r,
            t: (self.t + b * d[3] + c * d[4]).normalize(),
        }
    }

    /// The step `d` with which [`Self::moved`] reaches `other`, if the angle between both `t` is below 90 degrees.
    pub(super) fn step_to(&self, other: &Self) -> Vector5<f64> {
        let w = stereo_selfcal::geometry::so3::log(&(other.r * self.r.inverse()));
        let along = self.t.dot(&other.t);
        let [b, c] = self.across().map(|b| b.dot(&other.t) / along);
        Vector5::new(w.x, w.y, w.z, b, c)
    }

    pub(super) fn essential(&self) -> Essential {
        let (t, r) = (self.t.cross_matrix(), self.r.matrix());
        let turn = |axis: Vector3<f64>| t * axis.cross_matrix() * r;
        let [b, c] = self.across().map(|b| b.cross_matrix() * r);
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(turn);
        Essential { e: t * r, by: [x, y, z, b, c] }
    }

    /// `B`: two unit directions, perpendicular to `t` and to each other.
    pub(super) fn across(&self) -> [Vector3<f64>; 2] {
        let aside = if self.t.z.abs() < 0.7 { Vector3::z() } else { Vector3::x() };
        let b = self.t.cross(&aside).normalize();
        [b, self.t.cross(&b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::synth;

    fn pose() -> Pose {
        Pose::of(&synth::rig([4.0, -3.0, 2.0], [6.0, -5.0]).unwrap())
    }

    #[test]
    fn the_step_to_a_moved_pose_is_what_it_was_moved_by() {
        let d = Vector5::new(0.05, -0.02, 0.04, 0.03, -0.06);
        let found = pose().step_to(&pose().moved(&d));
        assert!((found - d).norm() < 1e-12, "{found}");
    }

    #[test]
    fn derivatives_of_the_essential_matrix_match_central_differences() {
        let essential = pose().essential();
        for (i, by) in essential.by.iter().enumerate() {
            let at = |h: f64| pose().moved(&Vector5::ith(i, h)).essential().e;
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((numeric - by).norm() < 1e-9, "{i}: {numeric} {by}");
        }
    }
}
