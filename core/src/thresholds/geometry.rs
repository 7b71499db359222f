//! Thresholds of geometry and batch: lenses, rotations, the rectification, the cells of the image.

/// Least depth of a rectified unit-depth ray (87 degrees off axis); a shallower ray is skipped. A larger limit skips
/// rays at the border; a smaller one lets the `1 / z` of the row offset grow.
pub(crate) const MIN_DEPTH: f64 = 0.05;

/// Least component of the unit baseline across each optical axis (sine of 6 degrees). A larger limit refuses rigs that
/// can be rectified; a smaller one accepts rigs near the pole of the gauge.
pub(crate) const MIN_LATERAL: f64 = 0.1;

/// Largest turn of one view in one step. A larger limit uses a linearisation beyond its range; a smaller one refuses
/// steps from a distant start.
pub(crate) const MAX_STEP_RAD: f64 = 1.5;

/// Tangent of 85 degrees: a ray further off axis has no useful unit-depth form. A larger limit loses digits in `f32`; a
/// smaller one cuts off the border of a fisheye image.
pub(crate) const MAX_TANGENT: f64 = 11.43;

/// Largest squared Frobenius norm of `M^T M - I` at which `M` counts as a rotation. A larger norm accepts other
/// matrices; a smaller one refuses rounded files.
pub(crate) const MAX_ROTATION_DEFECT: f64 = 0.04;

/// Number of Newton-Schulz steps to the nearest rotation. Four steps reduce the norm of `M^T M - I` from 0.2 to 1e-13;
/// two are spare.
pub(crate) const NEWTON_SCHULZ_STEPS: usize = 6;

/// Largest number of Newton steps of an undistortion; 3 to 5 are usual. A bracketed fisheye takes up to four times this
/// number, a rational lens up to three times. A larger limit raises the worst-case time; a smaller one refuses pixels
/// near the fold.
pub(crate) const MAX_NEWTON_STEPS: usize = 12;

/// Newton step that ends an undistortion: in units in the last place of one plus the size of the point, and for a
/// fisheye in units in the last place of the angle. A larger tolerance loses digits; a smaller one may never be
/// reached.
pub(crate) const NEWTON_ULPS: f64 = 4.0;
pub(crate) const FISHEYE_NEWTON_ULPS: f64 = 2.0;

/// Least denominator of a rational lens. A larger limit cuts the image of a nearly singular lens; a smaller one lets
/// the quotient lose its digits.
pub(crate) const MIN_LENS_DENOMINATOR: f64 = 0.01;

/// Largest residual of an undistorted and redistorted point of a rational lens, in units in the last place of one plus
/// the sizes of both points. A larger limit accepts points that miss their pixel; a smaller one refuses good points.
pub(crate) const RATIONAL_RESIDUAL_ULPS: f64 = 256.0;

/// Start of Newton's method for a distorted point beyond the fold, as a part of the fold's radius. A larger part starts
/// where the Jacobian is nearly singular; a smaller one takes more steps.
pub(crate) const NEWTON_START: f64 = 0.9;

/// Largest magnitude of a distortion coefficient. A larger limit accepts files that hold no lens; a smaller one refuses
/// lenses.
pub(crate) const MAX_DISTORTION: f64 = 1e3;

/// Largest magnitude of a coefficient of a rational lens: those of numerator and denominator cancel, and calibrations
/// with some thousands are ordinary inside the image.
pub(crate) const MAX_RATIONAL: f64 = 1e5;

/// Samples of a lens model up to its limit, and bisections of the interval that holds the fold. Larger numbers cost
/// time when a camera is set; a smaller number of samples misses a narrow fold, and a smaller number of bisections
/// loses digits.
pub(crate) const FOLD_SAMPLES: u32 = 256;
pub(crate) const FOLD_BISECTIONS: usize = 30;

/// Largest number of correspondences in one of the 48 cells of the image. A larger number raises the worst-case time of a
/// push; a smaller one loses matches of a scene in a few cells.
pub(crate) const MAX_IN_CELL: u16 = 128;
