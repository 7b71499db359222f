//! Origin of the errors of a run.

use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::metrics::Deviation;

/// Largest distance of a reference from a start that is the same rig, rad: a run rounds its start to its number type.
const ROUNDING_RAD: f64 = 1e-6;

/// Origin of the errors of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// There is no reference.
    None,
    /// The run started from the reference, so its errors are distances from the start.
    Start,
    /// The reference is another rig than the start.
    Known,
}

impl Reference {
    pub(super) fn of(truth: Option<&Extrinsics<f64>>, start: &Extrinsics<f64>) -> Self {
        let Some(truth) = truth else { return Self::None };
        let off = Deviation::between(start, truth);
        let is_start = off.rotation.max(off.translation) < ROUNDING_RAD;
        if is_start { Self::Start } else { Self::Known }
    }

    /// Ends the name of an error.
    pub fn words(self) -> &'static str {
        if self == Self::Start { "from the start" } else { "against the reference" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stereo_selfcal::nalgebra::{Rotation3, Vector3};

    #[test]
    fn a_start_that_was_rounded_is_the_reference() {
        let turned = |rad| {
            let r = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.3 + rad);
            Extrinsics::try_new(r.matrix(), &-Vector3::x()).unwrap()
        };
        let of = |rad| Reference::of(Some(&turned(0.0)), &turned(rad));
        assert_eq!([1e-7, 1e-5].map(of), [Reference::Start, Reference::Known]);
        assert_eq!(Reference::of(None, &turned(0.0)), Reference::None);
    }
}
