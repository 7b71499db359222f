//! Where sums over many pairs lead, together with what is known of the rig before them.

use nalgebra::Vector5;

use super::Lineage;
use crate::error::Refusal;
use crate::information::Information;
use crate::moments::Moments;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Gauss-Newton steps to the optimum of all sums: each squares the error of the linearisation.
pub(super) const STEPS: usize = 3;

/// A step is the last one if what it leaves is below rounding: its square, rad^2.
const LAST_STEP: f64 = 1e-8;

/// The optimum of sums and the prior, and the information of the sums there.
#[derive(Debug)]
pub(super) struct Optimum<T: Scalar> {
    pub(super) pose: RectifyingRotations<T>,
    pub(super) information: Information<T>,
}

impl<T: Scalar> Optimum<T> {
    pub(super) const NONE: Self =
        Self { pose: RectifyingRotations::SIDE_BY_SIDE, information: Information::ZERO };

    /// Goes there from the pose it is at.
    ///
    /// # Errors
    /// [`Refusal::NoRig`].
    #[inline(never)]
    pub(super) fn descend(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        lineage: &Lineage<T>,
    ) -> Result<(), Refusal> {
        for _ in 0..STEPS {
            let step = self.step(sums, frame, lineage).ok_or(Refusal::NoRig)?;
            if step.norm_squared() <= T::lit(LAST_STEP) {
                break;
            }
        }
        self.pose.extrinsics().map(|_| ()).map_err(|_| Refusal::NoRig)
    }

    /// Takes one Gauss-Newton step; the information is that from where it starts.
    #[inline(never)]
    fn step(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        lineage: &Lineage<T>,
    ) -> Option<Vector5<T>> {
        let mut seen = sums.seen_at(frame, &self.pose);
        self.information = seen.information;
        seen.information.0.add_diagonal(lineage.prior);
        seen.gradient -= self.pose.unknowns_to(&lineage.factory) * lineage.prior;
        let step = seen.step()?;
        self.pose = self.pose.stepped_by(&step)?;
        Some(step)
    }
}
