//! Lens correction of the rays, and knowledge of the lens from dropped sums (`ESTIMATOR.md`, section 17).
//!
//! Compensation of a difference of focal length or `k1` needs corrected rays: weights that were computed with the rays
//! of a wrong lens hide a part of the error. The sums before a change of the correction contain such weights, so the
//! estimate restarts. The measured differences are kept, even after a change of the rig, because the lens does not
//! change with the rig.

use crate::algebra::lens_terms::{LensEquations, LensValues};
use crate::geometry::lens_correction::LensCorrection;
use crate::scalar::Scalar;

/// Lens correction of the rays, and knowledge of the lens from sums that were dropped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LensReference<T> {
    pub(super) correction: LensCorrection<T>,
    /// Differences of focal length and `k1` between the cameras, right minus left, that pairs in dropped sums have
    /// measured; relative to the given lens.
    pub(super) known: LensCorrection<T>,
    /// Information on the two differences: inverse variances; 0 if unknown.
    pub(super) weights: [T; 2],
    /// Number of changes of the correction so far. With 0 changes there is no correction.
    pub(super) changes: u32,
    /// Whether pairs have contradicted the knowledge, and nothing has been learnt since.
    pub(super) is_doubted: bool,
}

impl<T: Scalar> LensReference<T> {
    /// The lens as given, without further knowledge.
    pub(crate) const GIVEN: Self = Self {
        correction: LensCorrection::NONE,
        known: LensCorrection::NONE,
        weights: [T::ZERO; 2],
        changes: 0,
        is_doubted: false,
    };

    /// Returns the lens correction of the rays.
    pub(crate) fn correction(&self) -> &LensCorrection<T> {
        &self.correction
    }

    /// Returns whether the lens is compensated: the estimated extrinsics belong to corrected cameras.
    pub(super) fn compensates(&self) -> bool {
        self.changes > 0
    }

    /// Multiplies the weight of the knowledge by the factor that fades the sums, because a lens changes with
    /// temperature.
    pub(super) fn fade(&mut self, fading: T) {
        self.weights.iter_mut().for_each(|weight| *weight *= fading);
    }

    /// Adds the knowledge to the equations of the lens, which are relative to the correction of the rays.
    pub(super) fn add_known(&self, equations: &mut LensEquations<'_, T>) {
        let [focal, k1] = self.weights;
        let [pull_focal, pull_k1] = [
            (self.known.focal - self.correction.focal) * focal,
            (self.known.k1 - self.correction.k1) * k1,
        ];
        let pulls = LensValues::from(equations.gradient.each_mut());
        for ([left, right], pull) in [(pulls.focal, pull_focal), (pulls.k1, pull_k1)] {
            *left += pull;
            *right -= pull;
        }
        let rows = LensValues::from(equations.information.each_mut());
        let of_focal = rows.focal.map(|row| LensValues::from(row.each_mut()).focal);
        let of_k1 = rows.k1.map(|row| LensValues::from(row.each_mut()).k1);
        for ([[ll, lr], [rl, rr]], weight) in [(of_focal, focal), (of_k1, k1)] {
            for (own, mixed) in [(ll, lr), (rr, rl)] {
                *own += weight;
                *mixed -= weight;
            }
        }
    }

    /// Moves the gradient of the equations from the correction of the rays to the known lens.
    pub(super) fn move_to_known(&self, equations: &mut LensEquations<'_, T>) {
        let focal = (self.known.focal - self.correction.focal) * T::HALF;
        let k1 = (self.known.k1 - self.correction.k1) * T::HALF;
        for (g, row) in equations.gradient.iter_mut().zip(equations.information.iter()) {
            let LensValues { focal: [focal_l, focal_r], k1: [k1_l, k1_r], .. } = (*row).into();
            *g += (focal_r - focal_l) * focal + (k1_r - k1_l) * k1;
        }
    }

    /// Returns correction, known differences and their information, in the order of a record.
    pub(crate) fn numbers(&self) -> [T; 6] {
        let Self { correction, known, weights: [focal, k1], .. } = *self;
        [correction.focal, correction.k1, known.focal, known.k1, focal, k1]
    }

    /// Restores a reference from the numbers of [`Self::numbers`], whose ranges the caller has checked. `None` if there
    /// is a correction but the number of changes is 0.
    ///
    /// * `changes`: number of changes of the lens so far.
    pub(crate) fn of(
        [focal, k1, known_focal, known_k1, a, b]: [T; 6],
        changes: u8,
    ) -> Option<Self> {
        let read = Self {
            correction: LensCorrection { focal, k1 },
            known: LensCorrection { focal: known_focal, k1: known_k1 },
            weights: [a, b],
            changes: changes.into(),
            is_doubted: false,
        };
        (read.compensates() || read.correction.is_none()).then_some(read)
    }

    /// Returns the number of changes so far, for a record.
    pub(crate) fn changes(&self) -> u8 {
        u8::try_from(self.changes).unwrap_or(u8::MAX)
    }

    pub(super) fn is_valid(&self) -> bool {
        let sane = |weight: &T| *weight >= T::ZERO && weight.is_finite();
        self.correction.is_valid() && self.known.is_valid() && self.weights.iter().all(sane)
    }
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::tests::context;
    use super::*;
    use crate::algebra::lens_terms::LENS_PARAMETERS;
    use crate::config::{Config, Context, LensTracking};

    const P: [f64; LENS_PARAMETERS] = [1.0, 3.0, 9.0, 9.0, 9.0, 9.0, 2.0, 5.0, 9.0];

    /// Returns the cost of the knowledge at `p`, up to a constant, from information and gradient about the correction.
    fn cost(reference: &LensReference<f64>, p: &[f64; LENS_PARAMETERS]) -> f64 {
        let mut information = [[0.0; LENS_PARAMETERS]; LENS_PARAMETERS];
        let (mut gradient, mut mixed) = ([0.0; LENS_PARAMETERS], [[0.0; 5]; LENS_PARAMETERS]);
        reference.add_known(&mut LensEquations {
            mixed: &mut mixed,
            information: &mut information,
            gradient: &mut gradient,
        });
        let rows = information.iter().zip(gradient).zip(p);
        rows.map(|((row, g), p_i)| {
            p_i * (row.iter().zip(p).map(|(h, p_k)| h * p_k).sum::<f64>() / 2.0 + g)
        })
        .sum()
    }

    #[test]
    fn a_reference_with_one_invalid_part_is_not_valid() {
        let given = LensReference::<f64>::GIVEN;
        let far = LensCorrection { focal: 1.0, k1: 0.0 };
        assert!(given.is_valid());
        assert!(!LensReference { correction: far, ..given }.is_valid());
        assert!(!LensReference { known: far, ..given }.is_valid());
        for weight in [-1.0, f64::INFINITY, f64::NAN] {
            assert!(!LensReference { weights: [1.0, weight], ..given }.is_valid());
        }
    }

    #[test]
    fn the_gradient_moves_from_the_correction_to_the_known_lens_with_the_information() {
        let reference = LensReference::<f64> {
            correction: LensCorrection { focal: 0.01, k1: 0.02 },
            known: LensCorrection { focal: 0.05, k1: -0.06 },
            ..LensReference::GIVEN
        };
        let units: [f64; LENS_PARAMETERS] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let mut information = units.map(|a| units.map(|b| a * b * b));
        let (mut gradient, mut mixed) = (units, [[0.0; 5]; LENS_PARAMETERS]);
        reference.move_to_known(&mut LensEquations {
            mixed: &mut mixed,
            information: &mut information,
            gradient: &mut gradient,
        });
        // From the correction to the known lens the left and right parameters move by -+0.02 and +-0.04.
        for ((moved, given), row) in gradient.iter().zip(units).zip(&information) {
            let expected = given + 0.02 * (row[1] - row[0]) - 0.04 * (row[7] - row[6]);
            assert!((moved - expected).abs() < 1e-12, "{moved} {expected}");
        }
    }

    #[test]
    fn a_correction_is_awaited_after_a_contradiction_where_lenses_are_compensated() {
        let mut context = context::<f64>();
        let mut reference = LensReference { weights: [1.0; 2], changes: 3, ..LensReference::GIVEN };
        let awaits = |reference: &LensReference<f64>, context: &_| {
            [16, 17].map(|pairs| reference.awaits_correction(pairs, context))
        };
        let compensates = Config::robust().with_lens_tracking(LensTracking::Compensate);
        assert_eq!(awaits(&reference, &Context { config: &compensates, ..context }), [false; 2]);
        reference.forget_known();
        assert_eq!((reference.weights, reference.changes), ([0.0; 2], 1));
        context.config = &compensates;
        assert_eq!(awaits(&reference, &context), [true, false]);
        let reports = Config::robust();
        context.config = &reports;
        assert_eq!(awaits(&reference, &context), [false; 2]);
    }

    #[test]
    fn the_knowledge_is_information_on_the_differences_alone_and_fades() {
        let mut reference = LensReference::<f64> {
            correction: LensCorrection { focal: 0.01, k1: 0.02 },
            known: LensCorrection { focal: 0.51, k1: -0.98 },
            weights: [4.0, 2.0],
            changes: 1,
            is_doubted: false,
        };
        // The cost is ((s_r - s_l) - 0.5)^2 4 / 2 + ((k1_r - k1_l) + 1)^2 2 / 2, minus its value at 0.
        let expected = 2.0 * (1.5 * 1.5 - 0.25) + (16.0 - 1.0);
        assert!((cost(&reference, &P) - expected).abs() < 1e-12);
        reference.fade(0.5);
        assert!((cost(&reference, &P) - expected / 2.0).abs() < 1e-12);
        assert!(cost(&LensReference::GIVEN, &P).abs() < 1e-12);
    }
}
