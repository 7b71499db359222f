//! Derivatives of the constraint with respect to the lens models of both cameras, from the moments (`ESTIMATOR.md`,
//! section 17).
//!
//! With wrong focal lengths and principal points the constraint is still `b^T X a` with a 3 x 3 matrix `X`, so it
//! remains a linear function of the nine products. Radial and tangential terms have their own coordinates.

use nalgebra::Vector5;

use super::block_variances::BlockVariances;
use super::disparity_noise::BiasedEquations;
use super::framed_moments::FramedMoments;
use super::moments::{COORDINATES, Coefficients, Vector12, add_outer, dot};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3::product;
use crate::scalar::Scalar;

/// Number of lens parameters: focal length (relative error), principal column, principal row (both at unit depth) and
/// `k1`, each for the left, then for the right camera; last, `p1` of the right camera minus `p1` of the left camera.
pub(crate) const LENS_PARAMETERS: usize = 9;

/// A value for each lens parameter, by name; for a parameter of each camera the left value, then the right one.
pub(crate) struct LensValues<V> {
    pub(crate) focal: [V; 2],
    /// Principal column.
    pub(crate) column: [V; 2],
    /// Principal row.
    pub(crate) row: [V; 2],
    pub(crate) k1: [V; 2],
    pub(crate) p1: V,
}

impl<V> From<[V; LENS_PARAMETERS]> for LensValues<V> {
    fn from(values: [V; LENS_PARAMETERS]) -> Self {
        let [focal_l, focal_r, column_l, column_r, row_l, row_r, k1_l, k1_r, p1] = values;
        Self {
            focal: [focal_l, focal_r],
            column: [column_l, column_r],
            row: [row_l, row_r],
            k1: [k1_l, k1_r],
            p1,
        }
    }
}

impl<V> From<LensValues<V>> for [V; LENS_PARAMETERS] {
    fn from(values: LensValues<V>) -> Self {
        let LensValues { focal, column, row, k1, p1 } = values;
        let [[focal_l, focal_r], [column_l, column_r]] = [focal, column];
        let [[row_l, row_r], [k1_l, k1_r]] = [row, k1];
        [focal_l, focal_r, column_l, column_r, row_l, row_r, k1_l, k1_r, p1]
    }
}

/// Normal equations of the lens at a pose, linearised about the lens models by which the rays were computed. They stand
/// in the buffers of their solution, because a copy would take stack.
#[derive(Debug)]
pub(crate) struct LensEquations<'a, T> {
    /// Mixed information of lens and extrinsics, one row for each lens parameter.
    pub(crate) mixed: &'a mut [[T; 5]; LENS_PARAMETERS],
    /// Information on the lens.
    pub(crate) information: &'a mut [[T; LENS_PARAMETERS]; LENS_PARAMETERS],
    pub(crate) gradient: &'a mut [T; LENS_PARAMETERS],
}

impl<T: Scalar> LensEquations<'_, T> {
    pub(crate) fn reborrow(&mut self) -> LensEquations<'_, T> {
        let Self { mixed, information, gradient } = self;
        LensEquations { mixed, information, gradient }
    }

    /// Marginalises over a random scatter of the extrinsics from pair to pair, as if all pairs had the same
    /// information. Changes nothing if numbers overflow.
    ///
    /// * `variances`: variances of the mean over the pairs, rad^2; `extrinsics`: equations of the extrinsics, which
    ///   become marginal too.
    #[inline(never)]
    pub(crate) fn marginalise(
        &mut self,
        variances: &BlockVariances<T>,
        extrinsics: &mut BiasedEquations<T>,
    ) {
        let plain = extrinsics.normal;
        let joint = variances.with_precision(&plain.information);
        let both = joint.factor(T::ZERO).zip(variances.marginal(&plain));
        let Some((factor, marginal)) = both else { return };
        let pull = factor.solve(&plain.gradient);
        let all = *self.mixed;
        let rows = self.mixed.iter_mut().zip(self.information.iter_mut()).zip(&mut *self.gradient);
        for ((own, information), gradient) in rows {
            let mixed = Vector5::from(*own);
            let taken_up = factor.solve(&mixed);
            *gradient -= mixed.dot(&pull);
            let others = information.iter_mut().zip(&all);
            others.for_each(|(i, other)| *i -= Vector5::from(*other).dot(&taken_up));
            *own = variances.precise(&taken_up).into();
        }
        // The noise of disparities is reduced by the same factor as the trace of the information on the baseline.
        let [.., y, z] = plain.information.0.diagonal();
        let [.., left_y, left_z] = marginal.information.0.diagonal();
        let share = ((left_y + left_z) / (y + z).max(T::EPSILON)).min(T::ONE);
        extrinsics.noise.0.iter_mut().for_each(|noise| *noise *= share);
        extrinsics.normal = marginal;
    }
}

impl<T: Scalar> FramedMoments<'_, T> {
    /// Fills the normal equations of the lens at `pose`.
    #[inline(never)]
    pub(crate) fn fill_lens(self, pose: &RectifyingRotations<T>, equations: LensEquations<'_, T>) {
        let Self { moments, frame } = self;
        let mut at_pose = Coefficients::NONE;
        at_pose.add(frame, pose);
        let mut by_lens = [[T::ZERO; COORDINATES]; LENS_PARAMETERS];
        coefficients(frame, pose, &at_pose.of_offset, &mut by_lens);
        let LensEquations { mixed, information, gradient } = equations;
        let rows = mixed.iter_mut().zip(information).zip(gradient).zip(&by_lens);
        for (((mixed, information), gradient), by_parameter) in rows {
            let weighted = moments.times(by_parameter);
            *gradient = dot(&at_pose.of_offset, &weighted);
            let by_unknown = mixed.iter_mut().zip(&at_pose.by_unknown);
            by_unknown.for_each(|(mixed, d)| *mixed = dot(d, &weighted));
            information.iter_mut().zip(&by_lens).for_each(|(i, d)| *i = dot(d, &weighted));
        }
    }
}

/// Fills the coefficients of the coordinates in the derivatives of the constraint with respect to the lens.
///
/// With the relative error `s` of the focal length and the errors `c_x`, `c_y` of the principal point, a given ray
/// `(x, y, 1)` is truly `(x - c_x, y - c_y, 1 + s)`. So each of these parameters moves the ray along an axis of its
/// camera by the value of the parameter. The displacement is multiplied by the ray's depth in its camera, which is 1.
/// This makes it linear in the ray.
///
/// * `of_offset`: the coefficients of the constraint.
fn coefficients<T: Scalar>(
    frame: &RectifyingRotations<T>,
    pose: &RectifyingRotations<T>,
    of_offset: &Vector12<T>,
    by: &mut [Vector12<T>; LENS_PARAMETERS],
) {
    let (frame_l, frame_r) = (frame.left().matrix(), frame.right().matrix());
    let (pose_l, pose_r) = (pose.left().matrix(), pose.right().matrix());
    let [_, y_l, z_l] = product(frame_l, &pose_l.transpose()).data.0;
    let [_, y_r, z_r] = product(frame_r, &pose_r.transpose()).data.0;
    let ([_, _, depth_l], [_, _, depth_r]) = (frame_l.data.0, frame_r.data.0);
    let ([x_axis_l, y_axis_l, z_axis_l], [x_axis_r, y_axis_r, z_axis_r]) =
        (pose_l.data.0, pose_r.data.0);
    let LensValues { focal, column, row, k1, p1 } = by.each_mut().into();
    let [[scale_l, scale_r], [column_l, column_r], [row_l, row_r], [k1_l, k1_r]] =
        [focal, column, row, k1];
    let cross = |[_, y, z]: [T; 3], of_y: [T; 3], of_z: [T; 3]| {
        let ([a, b, c], [d, e, f]) = (of_z, of_y);
        [y * a - z * d, y * b - z * e, y * c - z * f]
    };
    let (minus, one) = (T::MINUS_ONE, T::ONE);
    for (sum, sign, axis) in
        [(&mut *scale_l, one, z_axis_l), (column_l, minus, x_axis_l), (row_l, minus, y_axis_l)]
    {
        add_outer(sum, sign, &cross(axis, y_r, z_r), &depth_l);
    }
    for (sum, sign, axis) in
        [(&mut *scale_r, one, z_axis_r), (column_r, minus, x_axis_r), (row_r, minus, y_axis_r)]
    {
        add_outer(sum, -sign, &depth_r, &cross(axis, y_l, z_l));
    }
    // The noise scales with the rays. Each camera contributes half, so a common scale has no effect.
    for scale in [scale_l, scale_r] {
        scale.iter_mut().zip(of_offset).for_each(|(by, o)| *by -= T::HALF * *o);
    }
    let [.., of_k1_l, _, _] = k1_l;
    *of_k1_l = one;
    let [.., of_k1_r, _] = k1_r;
    *of_k1_r = one;
    let [.., of_p1] = p1;
    *of_p1 = one;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::change_frame::split;
    use crate::algebra::moments::{Moments, without_lens};
    use crate::geometry::rectification::tests::pose;
    use nalgebra::{Vector3, Vector5};

    type Pose = RectifyingRotations<f64>;

    #[derive(Default)]
    struct Terms {
        mixed: [[f64; 5]; LENS_PARAMETERS],
        information: [[f64; LENS_PARAMETERS]; LENS_PARAMETERS],
        gradient: [f64; LENS_PARAMETERS],
    }

    fn terms(sums: &Moments<f64>, frame: &Pose, pose: &Pose) -> Terms {
        let mut terms = Terms::default();
        let Terms { mixed, information, gradient } = &mut terms;
        sums.in_frame_of(frame).fill_lens(pose, LensEquations { mixed, information, gradient });
        terms
    }

    /// Arbitrary rays in the camera frames, so that no expression is small.
    const RAYS: [[f64; 3]; 2] = [[0.31, -0.42, 1.0], [-0.17, 0.23, 1.0]];
    const WEIGHT: f64 = 3.0;

    /// Returns homogeneous rays that are corrected for errors of focal length and principal point.
    fn corrected(p: &[f64; LENS_PARAMETERS]) -> [Vector3<f64>; 2] {
        let [s_l, s_r, cx_l, cx_r, cy_l, cy_r, ..] = *p;
        let [left, right] = RAYS.map(Vector3::from);
        [left + Vector3::new(-cx_l, -cy_l, s_l), right + Vector3::new(-cx_r, -cy_r, s_r)]
    }

    /// Returns the constraint of the corrected rays at a pose. It is divided by the scale of the noise, to which each
    /// camera contributes half.
    fn constraint(at: &Pose, p: &[f64; LENS_PARAMETERS]) -> f64 {
        let [left, right] = corrected(p);
        let [s_l, s_r, ..] = *p;
        let (a, b) = (at.left() * left, at.right() * right);
        (a.y * b.z - a.z * b.y) / ((1.0 + s_l) * (1.0 + s_r)).sqrt()
    }

    #[test]
    fn terms_of_focal_length_and_principal_point_match_central_differences_at_any_pose() {
        let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
        let [left, right] = RAYS.map(Vector3::from);
        let k = without_lens(split(&((frame.right() * right) * (frame.left() * left).transpose())));
        let mut sums = Moments::ZERO;
        sums.add_rows(core::iter::once((WEIGHT, &k)));
        for at in [frame, pose([-0.03, 0.06, 0.1], [-0.05, 0.08])] {
            let terms = terms(&sums, &frame, &at);
            let difference = |of: &dyn Fn(f64) -> f64| (of(1e-5) - of(-1e-5)) / 2e-5;
            let by_lens: [f64; LENS_PARAMETERS] = core::array::from_fn(|i| {
                difference(&|h| {
                    constraint(&at, &core::array::from_fn(|k| if k == i { h } else { 0.0 }))
                })
            });
            let value = constraint(&at, &[0.0; LENS_PARAMETERS]);
            let by_pose: [f64; 5] = core::array::from_fn(|i| {
                let moved = |h| at.stepped_by(&Vector5::ith(i, h)).unwrap();
                difference(&|h| constraint(&moved(h), &[0.0; LENS_PARAMETERS]))
            });
            for i in 0..6 {
                let close = |got: f64, of: f64| {
                    assert!((got - WEIGHT * by_lens[i] * of).abs() < 1e-8, "{i}: {got}");
                };
                close(terms.gradient[i], value);
                (0..6).for_each(|j| close(terms.information[i][j], by_lens[j]));
                (0..5).for_each(|j| close(terms.mixed[i][j], by_pose[j]));
            }
            // The coordinates of the radial and tangential terms are zero here, so these parameters have no
            // information.
            assert!(terms.information[6..].iter().flatten().all(|x| *x == 0.0));
        }
    }

    #[test]
    fn radial_and_tangential_terms_are_the_last_coordinates() {
        let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
        let mut sums = Moments::ZERO;
        let k = [0.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 2.0, 3.0, 4.0];
        sums.add_rows(core::iter::once((WEIGHT, &k)));
        let terms = terms(&sums, &frame, &frame);
        let normal = sums.at_frame();
        for (i, k_i) in [(6, 2.0), (7, 3.0), (8, 4.0)] {
            assert!((terms.gradient[i] - WEIGHT * 0.5 * k_i).abs() < 1e-12);
            assert!((terms.information[i][i] - WEIGHT * k_i * k_i).abs() < 1e-12);
            // The gradient contains `cx` = 0.5 where the mixed information contains `k_i`.
            for j in 0..5 {
                assert!((terms.mixed[i][j] - normal.gradient[j] * k_i / 0.5).abs() < 1e-12);
            }
        }
    }
}
