//! What codes and states are called in words.

use core::ffi::{CStr, c_char};

use crate::code::selfcal_error_t::{self, *};

/// A number of C and its words.
pub(crate) type Text<N> = (N, &'static CStr);

/// The words of a number; `"unknown"` if it has none.
pub(crate) fn find<N: Copy + PartialEq>(texts: &[Text<N>], value: N) -> *const c_char {
    let found = texts.iter().find(|(number, _)| *number == value);
    found.map_or(c"unknown", |(_, text)| text).as_ptr()
}

const fn error(error: selfcal_error_t, text: &'static CStr) -> Text<i32> {
    (error as i32, text)
}

pub(crate) const ERRORS: &[Text<i32>] = &[
    error(SELFCAL_OK, c"done"),
    error(SELFCAL_ERROR_NULL, c"a pointer is null"),
    error(SELFCAL_ERROR_ALIGNMENT, c"a pointer is not aligned for what it points to"),
    error(SELFCAL_ERROR_STORAGE_SIZE, c"the storage is too small: a header of another capacity?"),
    error(SELFCAL_ERROR_NOT_INITIALISED, c"the storage is not initialised, has been overwritten, or belongs to another build"),
    error(SELFCAL_ERROR_CONFIG_NOT_INITIALISED, c"the configuration is not initialised: begin with selfcal_config_default"),
    error(SELFCAL_ERROR_VALUE, c"a number is none of its enumeration"),
    error(SELFCAL_ERROR_COUNT, c"an array is longer than the address space"),
    error(SELFCAL_ERROR_NO_CAMERAS, c"selfcal_set_cameras comes first"),
    error(SELFCAL_ERROR_NO_REPORT, c"no pair has been solved since the batch was last begun or cleared"),
    error(SELFCAL_ERROR_NO_ESTIMATE, c"no pair has been fused"),
    error(SELFCAL_ERROR_NO_HEALTH, c"there are no cameras, no fused pairs, or no matches in the batch that fit the estimate"),
    error(SELFCAL_ERROR_NO_DEPTH_ERROR, c"depth errors are only predicted while locked"),
    error(SELFCAL_ERROR_BASELINE, c"the length of the baseline is not finite or not above 0"),
    error(SELFCAL_ERROR_RECTIFIED_CAMERA, c"the rectified camera is not finite, or its focal length not above 0"),
    error(SELFCAL_ERROR_UNKNOWN, c"the core gave an error that this API does not know yet"),
    error(SELFCAL_ERROR_LEFT_FOCAL_LENGTH, c"left camera: a focal length is not finite or not within 1 to 1e6 px"),
    error(SELFCAL_ERROR_LEFT_PRINCIPAL_POINT, c"left camera: the principal point is not finite, or further from the image than its own size"),
    error(SELFCAL_ERROR_LEFT_IMAGE_SIZE, c"left camera: the image is smaller than 2 x 2 px"),
    error(SELFCAL_ERROR_LEFT_DISTORTION, c"left camera: a lens coefficient is not finite or above 1e3 in size"),
    error(SELFCAL_ERROR_LEFT_LENS, c"left camera: the lens model is none of selfcal_lens_t"),
    error(SELFCAL_ERROR_LEFT_COEFFICIENT, c"left camera: a coefficient that the lens model does not have is not 0"),
    error(SELFCAL_ERROR_RIGHT_FOCAL_LENGTH, c"right camera: a focal length is not finite or not within 1 to 1e6 px"),
    error(SELFCAL_ERROR_RIGHT_PRINCIPAL_POINT, c"right camera: the principal point is not finite, or further from the image than its own size"),
    error(SELFCAL_ERROR_RIGHT_IMAGE_SIZE, c"right camera: the image is smaller than 2 x 2 px"),
    error(SELFCAL_ERROR_RIGHT_DISTORTION, c"right camera: a lens coefficient is not finite or above 1e3 in size"),
    error(SELFCAL_ERROR_RIGHT_LENS, c"right camera: the lens model is none of selfcal_lens_t"),
    error(SELFCAL_ERROR_RIGHT_COEFFICIENT, c"right camera: a coefficient that the lens model does not have is not 0"),
    error(SELFCAL_ERROR_RAY_NOT_FINITE, c"ray: the pixel is not finite"),
    error(SELFCAL_ERROR_RAY_OUTSIDE_IMAGE, c"ray: the pixel is outside the image by more than half a pixel"),
    error(SELFCAL_ERROR_RAY_NOT_INVERTIBLE, c"ray: the lens model folds back before the pixel, or the ray is over 85 degrees off axis"),
    error(SELFCAL_ERROR_PIXEL_NOT_FINITE, c"pixel: the ray is not finite"),
    error(SELFCAL_ERROR_PIXEL_BEYOND_LENS, c"pixel: the ray lies beyond the range in which the lens model is one to one"),
    error(SELFCAL_ERROR_EXTRINSICS_NOT_A_ROTATION, c"extrinsics: R is not finite, not orthonormal to about 0.1, or a reflection"),
    error(SELFCAL_ERROR_EXTRINSICS_NO_DIRECTION, c"extrinsics: t is not finite or has no direction"),
    error(SELFCAL_ERROR_EXTRINSICS_ALONG_OPTICAL_AXIS, c"extrinsics: t is within 6 degrees of an optical axis: such a pair cannot be rectified"),
    error(SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD, c"configuration: the Huber threshold must be finite and above 0 px"),
    error(SELFCAL_ERROR_CONFIG_MAX_PASSES, c"configuration: there must be at least 2 passes"),
    error(SELFCAL_ERROR_CONFIG_STEP_TOLERANCE, c"configuration: the step tolerance must lie within 0 to 0.1 rad"),
    error(SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES, c"configuration: at least 6 correspondences must be asked for"),
    error(SELFCAL_ERROR_CONFIG_NOISE_FLOOR, c"configuration: the noise floor must be finite and above 0 px"),
    error(SELFCAL_ERROR_CONFIG_PRIOR_SD, c"configuration: the standard deviation of the prior must lie within 1e-4 to 1 rad"),
    error(SELFCAL_ERROR_CONFIG_MAX_SD, c"configuration: the largest standard deviation must be finite and above 0 rad"),
    error(SELFCAL_ERROR_CONFIG_MEMORY, c"configuration: the memory must be at least 20 pairs"),
    error(SELFCAL_ERROR_CONFIG_MAX_CORRECTION, c"configuration: the correction limit must be above 0 and below 1.5 rad"),
    error(SELFCAL_ERROR_PUSH_NO_CAMERAS, c"push: selfcal_set_cameras comes first"),
    error(SELFCAL_ERROR_PUSH_BUSY, c"push: a pair is being solved; finish it or clear it first"),
    error(SELFCAL_ERROR_PUSH_SCORE, c"push: the score is not within 0 to 1"),
    error(SELFCAL_ERROR_PUSH_GRID_STEP, c"push: the grid step is not within 0 to 255.99 px"),
    error(SELFCAL_ERROR_PUSH_LEFT_NOT_FINITE, c"push: the left pixel is not finite"),
    error(SELFCAL_ERROR_PUSH_LEFT_OUTSIDE_IMAGE, c"push: the left pixel is outside the image by more than half a pixel"),
    error(SELFCAL_ERROR_PUSH_LEFT_NOT_INVERTIBLE, c"push: the lens model is not invertible at the left pixel"),
    error(SELFCAL_ERROR_PUSH_RIGHT_NOT_FINITE, c"push: the right pixel is not finite"),
    error(SELFCAL_ERROR_PUSH_RIGHT_OUTSIDE_IMAGE, c"push: the right pixel is outside the image by more than half a pixel"),
    error(SELFCAL_ERROR_PUSH_RIGHT_NOT_INVERTIBLE, c"push: the lens model is not invertible at the right pixel"),
    error(SELFCAL_ERROR_PAIR_NO_CAMERAS, c"pair: selfcal_set_cameras comes first"),
    error(SELFCAL_ERROR_PAIR_NOT_BEGUN, c"pair: selfcal_begin_pair comes first"),
    error(SELFCAL_ERROR_PAIR_TOO_FEW, c"pair: fewer usable correspondences than configured. Collect more; nothing is wrong"),
    error(SELFCAL_ERROR_PAIR_NO_CONSENSUS, c"pair: the correspondences agree on no extrinsics; mismatches only"),
    error(SELFCAL_ERROR_PAIR_UNOBSERVABLE, c"pair: the correspondences leave a direction free: all alike, on a line, or at infinity"),
    error(SELFCAL_ERROR_FUSE_TOO_UNCERTAIN, c"fuse: the weakest direction of the pair is too uncertain"),
    error(SELFCAL_ERROR_FUSE_CORRECTION_LIMIT, c"fuse: further from the factory extrinsics than the correction limit"),
    error(SELFCAL_ERROR_FUSE_NO_RIG, c"fuse: the pair leads to extrinsics that cannot be rectified"),
    error(SELFCAL_ERROR_FUSE_DISAGREES, c"fuse: the pair disagrees with the estimate, and with the pairs kept apart from it"),
    error(SELFCAL_ERROR_FUSE_STALE, c"fuse: the pair has been fused, or the calibrator reset, since it was solved"),
    error(SELFCAL_ERROR_FUSE_FROZEN, c"fuse: the calibrator is frozen"),
    error(SELFCAL_ERROR_FUSE_NOT_FINITE, c"fuse: a quantity of the report is not finite"),
    error(SELFCAL_ERROR_APPLY_NO_PROPOSAL, c"apply: no pair has been fused"),
    error(SELFCAL_ERROR_APPLY_INCONSISTENT, c"apply: the fused pairs agree on no extrinsics"),
    error(SELFCAL_ERROR_APPLY_NOT_LOCKED, c"apply: the estimate is not locked; selfcal_state says what it is"),
    error(SELFCAL_ERROR_APPLY_DOUBTFUL, c"apply: image halves disagree by more than 5 standard deviations; the matches are biased"),
    error(SELFCAL_ERROR_APPLY_FROZEN, c"apply: the calibrator is frozen"),
    error(SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO, c"undo: nothing has been applied since the last reset or undo"),
    error(SELFCAL_ERROR_RECTIFY_ALPHA, c"rectify: alpha is not within 0 to 1"),
    error(SELFCAL_ERROR_RECTIFY_NO_COMMON_VIEW, c"rectify: the rectified views share no rectangle, or are not upright"),
    error(SELFCAL_ERROR_RECTIFY_LEFT_NOT_FINITE, c"rectify: a point on the border of the left image is not finite"),
    error(SELFCAL_ERROR_RECTIFY_LEFT_OUTSIDE_IMAGE, c"rectify: a point on the border of the left image is outside it"),
    error(SELFCAL_ERROR_RECTIFY_LEFT_NOT_INVERTIBLE, c"rectify: the lens model is not invertible on the border of the left image"),
    error(SELFCAL_ERROR_RECTIFY_LEFT_BEHIND, c"rectify: the left image border lies behind the rectified plane: turned too far"),
    error(SELFCAL_ERROR_RECTIFY_RIGHT_NOT_FINITE, c"rectify: a point on the border of the right image is not finite"),
    error(SELFCAL_ERROR_RECTIFY_RIGHT_OUTSIDE_IMAGE, c"rectify: a point on the border of the right image is outside it"),
    error(SELFCAL_ERROR_RECTIFY_RIGHT_NOT_INVERTIBLE, c"rectify: the lens model is not invertible on the border of the right image"),
    error(SELFCAL_ERROR_RECTIFY_RIGHT_BEHIND, c"rectify: the right image border lies behind the rectified plane: turned too far"),
];
