//! The error codes.

use core::ffi::c_char;

use crate::text::{ERRORS, find};

/// Why a function gave nothing. The numbers stay; new ones may come.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_error_t {
    /// Done.
    SELFCAL_OK = 0,

    /// A pointer is null.
    SELFCAL_ERROR_NULL = 1,
    /// A pointer is not aligned for what it points to.
    SELFCAL_ERROR_ALIGNMENT = 2,
    /// The storage is too small: a header of another capacity?
    SELFCAL_ERROR_STORAGE_SIZE = 3,
    /// The storage is not initialised, has been overwritten, or belongs to another build.
    SELFCAL_ERROR_NOT_INITIALISED = 4,
    /// The configuration is not initialised: begin with `selfcal_config_default`.
    SELFCAL_ERROR_CONFIG_NOT_INITIALISED = 5,
    /// A number is none of its enumeration.
    SELFCAL_ERROR_VALUE = 6,
    /// An array is longer than the address space.
    SELFCAL_ERROR_COUNT = 7,
    /// `selfcal_set_cameras` comes first.
    SELFCAL_ERROR_NO_CAMERAS = 8,
    /// No pair has been solved since the batch was last begun or cleared.
    SELFCAL_ERROR_NO_REPORT = 9,
    /// No pair has been fused.
    SELFCAL_ERROR_NO_ESTIMATE = 10,
    /// There are no cameras, no fused pairs, or no matches in the batch that fit the estimate.
    SELFCAL_ERROR_NO_HEALTH = 11,
    /// Depth errors are only predicted while locked.
    SELFCAL_ERROR_NO_DEPTH_ERROR = 12,
    /// The length of the baseline is not finite or not above 0.
    SELFCAL_ERROR_BASELINE = 13,
    /// The rectified camera is not finite, or its focal length not above 0.
    SELFCAL_ERROR_RECTIFIED_CAMERA = 14,
    /// The core gave an error that this API does not know yet.
    SELFCAL_ERROR_UNKNOWN = 99,

    /// Left camera: a focal length is not finite or not within 1 to 1e6 px.
    SELFCAL_ERROR_LEFT_FOCAL_LENGTH = 100,
    /// Left camera: the principal point is not finite, or further from the image than its own size.
    SELFCAL_ERROR_LEFT_PRINCIPAL_POINT = 101,
    /// Left camera: the image is smaller than 2 x 2 px.
    SELFCAL_ERROR_LEFT_IMAGE_SIZE = 102,
    /// Left camera: a lens coefficient is not finite or above 1e3 in size.
    SELFCAL_ERROR_LEFT_DISTORTION = 103,
    /// Left camera: the lens model is none of `selfcal_lens_t`.
    SELFCAL_ERROR_LEFT_LENS = 104,
    /// Left camera: a coefficient that the lens model does not have is not 0.
    SELFCAL_ERROR_LEFT_COEFFICIENT = 105,
    /// Right camera: a focal length is not finite or not within 1 to 1e6 px.
    SELFCAL_ERROR_RIGHT_FOCAL_LENGTH = 110,
    /// Right camera: the principal point is not finite, or further from the image than its own size.
    SELFCAL_ERROR_RIGHT_PRINCIPAL_POINT = 111,
    /// Right camera: the image is smaller than 2 x 2 px.
    SELFCAL_ERROR_RIGHT_IMAGE_SIZE = 112,
    /// Right camera: a lens coefficient is not finite or above 1e3 in size.
    SELFCAL_ERROR_RIGHT_DISTORTION = 113,
    /// Right camera: the lens model is none of `selfcal_lens_t`.
    SELFCAL_ERROR_RIGHT_LENS = 114,
    /// Right camera: a coefficient that the lens model does not have is not 0.
    SELFCAL_ERROR_RIGHT_COEFFICIENT = 115,

    /// Ray: the pixel is not finite.
    SELFCAL_ERROR_RAY_NOT_FINITE = 120,
    /// Ray: the pixel is outside the image by more than half a pixel.
    SELFCAL_ERROR_RAY_OUTSIDE_IMAGE = 121,
    /// Ray: the lens model folds back before the pixel, or the ray is over 85 degrees off axis.
    SELFCAL_ERROR_RAY_NOT_INVERTIBLE = 122,
    /// Pixel: the ray is not finite.
    SELFCAL_ERROR_PIXEL_NOT_FINITE = 130,
    /// Pixel: the ray lies beyond the range in which the lens model is one to one.
    SELFCAL_ERROR_PIXEL_BEYOND_LENS = 131,

    /// Extrinsics: `R` is not finite, not orthonormal to about 0.1, or a reflection.
    SELFCAL_ERROR_EXTRINSICS_NOT_A_ROTATION = 200,
    /// Extrinsics: `t` is not finite or has no direction.
    SELFCAL_ERROR_EXTRINSICS_NO_DIRECTION = 201,
    /// Extrinsics: `t` is within 6 degrees of an optical axis: such a pair cannot be rectified.
    SELFCAL_ERROR_EXTRINSICS_ALONG_OPTICAL_AXIS = 202,

    /// Configuration: the Huber threshold must be finite and above 0 px.
    SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD = 300,
    /// Configuration: there must be at least 2 passes.
    SELFCAL_ERROR_CONFIG_MAX_PASSES = 301,
    /// Configuration: the step tolerance must lie within 0 to 0.1 rad.
    SELFCAL_ERROR_CONFIG_STEP_TOLERANCE = 302,
    /// Configuration: at least 6 correspondences must be asked for.
    SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES = 303,
    /// Configuration: the noise floor must be finite and above 0 px.
    SELFCAL_ERROR_CONFIG_NOISE_FLOOR = 304,
    /// Configuration: the standard deviation of the prior must lie within 1e-4 to 1 rad.
    SELFCAL_ERROR_CONFIG_PRIOR_SD = 305,
    /// Configuration: the largest standard deviation must be finite and above 0 rad.
    SELFCAL_ERROR_CONFIG_MAX_SD = 306,
    /// Configuration: the memory must be at least 20 pairs.
    SELFCAL_ERROR_CONFIG_MEMORY = 307,
    /// Configuration: the correction limit must be above 0 and below 1.5 rad.
    SELFCAL_ERROR_CONFIG_MAX_CORRECTION = 308,

    /// Push: `selfcal_set_cameras` comes first.
    SELFCAL_ERROR_PUSH_NO_CAMERAS = 400,
    /// Push: a pair is being solved; finish it or clear it first.
    SELFCAL_ERROR_PUSH_BUSY = 401,
    /// Push: the score is not within 0 to 1.
    SELFCAL_ERROR_PUSH_SCORE = 402,
    /// Push: the grid step is not within 0 to 255.99 px.
    SELFCAL_ERROR_PUSH_GRID_STEP = 403,
    /// Push: the left pixel is not finite.
    SELFCAL_ERROR_PUSH_LEFT_NOT_FINITE = 410,
    /// Push: the left pixel is outside the image by more than half a pixel.
    SELFCAL_ERROR_PUSH_LEFT_OUTSIDE_IMAGE = 411,
    /// Push: the lens model is not invertible at the left pixel.
    SELFCAL_ERROR_PUSH_LEFT_NOT_INVERTIBLE = 412,
    /// Push: the right pixel is not finite.
    SELFCAL_ERROR_PUSH_RIGHT_NOT_FINITE = 420,
    /// Push: the right pixel is outside the image by more than half a pixel.
    SELFCAL_ERROR_PUSH_RIGHT_OUTSIDE_IMAGE = 421,
    /// Push: the lens model is not invertible at the right pixel.
    SELFCAL_ERROR_PUSH_RIGHT_NOT_INVERTIBLE = 422,

    /// Pair: `selfcal_set_cameras` comes first.
    SELFCAL_ERROR_PAIR_NO_CAMERAS = 500,
    /// Pair: `selfcal_begin_pair` comes first.
    SELFCAL_ERROR_PAIR_NOT_BEGUN = 501,
    /// Pair: fewer usable correspondences than configured. Collect more; nothing is wrong.
    SELFCAL_ERROR_PAIR_TOO_FEW = 502,
    /// Pair: the correspondences agree on no extrinsics; mismatches only.
    SELFCAL_ERROR_PAIR_NO_CONSENSUS = 503,
    /// Pair: the correspondences leave a direction free: all alike, on a line, or at infinity.
    SELFCAL_ERROR_PAIR_UNOBSERVABLE = 504,

    /// Fuse: the weakest direction of the pair is too uncertain.
    SELFCAL_ERROR_FUSE_TOO_UNCERTAIN = 600,
    /// Fuse: further from the factory extrinsics than the correction limit.
    SELFCAL_ERROR_FUSE_CORRECTION_LIMIT = 601,
    /// Fuse: the pair leads to extrinsics that cannot be rectified.
    SELFCAL_ERROR_FUSE_NO_RIG = 602,
    /// Fuse: the pair disagrees with the estimate, and with the pairs kept apart from it.
    SELFCAL_ERROR_FUSE_DISAGREES = 603,
    /// Fuse: the pair has been fused, or the calibrator reset, since it was solved.
    SELFCAL_ERROR_FUSE_STALE = 604,
    /// Fuse: the calibrator is frozen.
    SELFCAL_ERROR_FUSE_FROZEN = 605,

    /// Apply: no pair has been fused.
    SELFCAL_ERROR_APPLY_NO_PROPOSAL = 700,
    /// Apply: the fused pairs agree on no extrinsics.
    SELFCAL_ERROR_APPLY_INCONSISTENT = 701,
    /// Apply: the estimate is not locked; `selfcal_state` says what it is.
    SELFCAL_ERROR_APPLY_NOT_LOCKED = 702,
    /// Apply: image halves disagree by more than 5 standard deviations; the matches are biased.
    SELFCAL_ERROR_APPLY_DOUBTFUL = 703,
    /// Apply: the calibrator is frozen.
    SELFCAL_ERROR_APPLY_FROZEN = 704,
    /// Undo: nothing has been applied since the last reset or undo.
    SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO = 705,

    /// Rectify: `alpha` is not within 0 to 1.
    SELFCAL_ERROR_RECTIFY_ALPHA = 800,
    /// Rectify: the rectified views share no rectangle, or are not upright.
    SELFCAL_ERROR_RECTIFY_NO_COMMON_VIEW = 801,
    /// Rectify: a point on the border of the left image is not finite.
    SELFCAL_ERROR_RECTIFY_LEFT_NOT_FINITE = 810,
    /// Rectify: a point on the border of the left image is outside it.
    SELFCAL_ERROR_RECTIFY_LEFT_OUTSIDE_IMAGE = 811,
    /// Rectify: the lens model is not invertible on the border of the left image.
    SELFCAL_ERROR_RECTIFY_LEFT_NOT_INVERTIBLE = 812,
    /// Rectify: the left image border lies behind the rectified plane: turned too far.
    SELFCAL_ERROR_RECTIFY_LEFT_BEHIND = 813,
    /// Rectify: a point on the border of the right image is not finite.
    SELFCAL_ERROR_RECTIFY_RIGHT_NOT_FINITE = 820,
    /// Rectify: a point on the border of the right image is outside it.
    SELFCAL_ERROR_RECTIFY_RIGHT_OUTSIDE_IMAGE = 821,
    /// Rectify: the lens model is not invertible on the border of the right image.
    SELFCAL_ERROR_RECTIFY_RIGHT_NOT_INVERTIBLE = 822,
    /// Rectify: the right image border lies behind the rectified plane: turned too far.
    SELFCAL_ERROR_RECTIFY_RIGHT_BEHIND = 823,

    /// Snapshot: the record takes more room than there is.
    SELFCAL_ERROR_SNAPSHOT_ROOM = 900,
    /// Snapshot: `selfcal_set_cameras` comes first; a record is of one rig.
    SELFCAL_ERROR_SNAPSHOT_NO_CAMERAS = 901,

    /// Restore: the checksum of the record is wrong, or it ends where it should not. Use an older one.
    SELFCAL_ERROR_RESTORE_DAMAGED = 1000,
    /// Restore: it is a record of something else.
    SELFCAL_ERROR_RESTORE_FOREIGN = 1001,
    /// Restore: the record was written by later firmware, in a layout that is not known.
    SELFCAL_ERROR_RESTORE_VERSION = 1002,
    /// Restore: the numbers of the record are not of type float.
    SELFCAL_ERROR_RESTORE_SCALAR = 1003,
    /// Restore: the record is of the other preset.
    SELFCAL_ERROR_RESTORE_PRESET = 1004,
    /// Restore: it was learnt with other cameras or from other factory extrinsics. Start afresh.
    SELFCAL_ERROR_RESTORE_OTHER_RIG = 1005,
    /// Restore: a quantity of the record cannot be; it was not written by this library.
    SELFCAL_ERROR_RESTORE_ABSURD = 1006,
    /// Restore: further from the factory extrinsics than the correction limit is now.
    SELFCAL_ERROR_RESTORE_CORRECTION_LIMIT = 1007,
    /// Restore: the calibrator has learnt something already, or is solving a pair.
    SELFCAL_ERROR_RESTORE_NOT_FRESH = 1008,
    /// Restore: `selfcal_set_cameras` comes first.
    SELFCAL_ERROR_RESTORE_NO_CAMERAS = 1009,

    /// Link: a pair is being solved; no byte was used. Finish it or clear it, then feed on.
    SELFCAL_ERROR_LINK_BUSY = 1100,
    /// Link: `selfcal_set_cameras` comes first. The frame is not taken; feed on.
    SELFCAL_ERROR_LINK_NO_CAMERAS = 1101,
    /// Link: the matcher's images are not of the cameras' size. The frame is not taken; feed on.
    SELFCAL_ERROR_LINK_IMAGE_SIZE = 1102,
}

/// What an error code means, in English; never null, `"unknown"` for other numbers.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_error_string(error: i32) -> *const c_char {
    find(ERRORS, error)
}

/// The code of what an act came to.
pub(crate) fn code(act: impl FnOnce() -> Result<(), selfcal_error_t>) -> selfcal_error_t {
    act().err().unwrap_or(selfcal_error_t::SELFCAL_OK)
}
