//! The error codes and their texts.

use core::ffi::c_char;

use stereo_selfcal::link::{EncodeError, FrameRefusal, HeaderError};
use stereo_selfcal::{
    ApplyError, ConfigError, ExtrinsicsError, MotionError, ProjectError, PushError, RangeError,
    RectifyError, Rejection, RestoreError, UndistortError,
};

use crate::enumeration::find;

c_enum! {
    /// Result of a call. From 100 on, the numbers are those of the core. Numbers stay; new ones may
    /// come.
    #[repr(i32)]
    #[allow(clippy::doc_markdown, reason = "the documentation is the text")]
    pub enum selfcal_error_t {
        /// no error
        SELFCAL_OK = 0,

        /// a pointer is null
        SELFCAL_ERROR_NULL = 1,
        /// a pointer is not aligned for its type
        SELFCAL_ERROR_ALIGNMENT = 2,
        /// the storage is too small; compare the capacities of header and library
        SELFCAL_ERROR_STORAGE_SIZE = 3,
        /// the storage is not initialised, its name or a length is overwritten, or it belongs to another build
        SELFCAL_ERROR_NOT_INITIALISED = 4,
        /// the configuration is not initialised; call selfcal_config_default first
        SELFCAL_ERROR_CONFIG_NOT_INITIALISED = 5,
        /// an argument is no value of its enumeration
        SELFCAL_ERROR_VALUE = 6,
        /// an array is longer than the address space
        SELFCAL_ERROR_COUNT = 7,
        /// no cameras are set; call selfcal_set_cameras first
        SELFCAL_ERROR_NO_CAMERAS = 8,
        /// no pair has been solved since the batch was last begun or cleared, or its fusion has been read
        SELFCAL_ERROR_NO_REPORT = 9,
        /// no pair has been fused
        SELFCAL_ERROR_NO_ESTIMATE = 10,
        /// no cameras, no fused pair, or no match in the batch that fits the estimate
        SELFCAL_ERROR_NO_HEALTH = 11,
        /// depth errors are predicted in the locked state only
        SELFCAL_ERROR_NO_DEPTH_ERROR = 12,
        /// the length of the baseline is not finite or not above 0
        SELFCAL_ERROR_BASELINE = 13,
        /// the rectified camera is not finite, or its focal length is not above 0
        SELFCAL_ERROR_RECTIFIED_CAMERA = 14,
        /// the core returned an error that this API does not know
        SELFCAL_ERROR_UNKNOWN = 99,

        /// left camera: a focal length is not finite or not within 1 to 1e6 px
        SELFCAL_ERROR_LEFT_FOCAL_LENGTH = 100,
        /// left camera: the principal point is not finite, or further from the image than its size
        SELFCAL_ERROR_LEFT_PRINCIPAL_POINT = 101,
        /// left camera: the image is smaller than 2 x 2 px
        SELFCAL_ERROR_LEFT_IMAGE_SIZE = 102,
        /// left camera: the magnitude of a lens coefficient is above 1e3 or not finite
        SELFCAL_ERROR_LEFT_DISTORTION = 103,
        /// left camera: the lens model is no value of selfcal_lens_t
        SELFCAL_ERROR_LEFT_LENS = 104,
        /// left camera: a coefficient that the lens model does not use is not 0
        SELFCAL_ERROR_LEFT_COEFFICIENT = 105,
        /// right camera: a focal length is not finite or not within 1 to 1e6 px
        SELFCAL_ERROR_RIGHT_FOCAL_LENGTH = 110,
        /// right camera: the principal point is not finite, or further from the image than its size
        SELFCAL_ERROR_RIGHT_PRINCIPAL_POINT = 111,
        /// right camera: the image is smaller than 2 x 2 px
        SELFCAL_ERROR_RIGHT_IMAGE_SIZE = 112,
        /// right camera: the magnitude of a lens coefficient is above 1e3 or not finite
        SELFCAL_ERROR_RIGHT_DISTORTION = 113,
        /// right camera: the lens model is no value of selfcal_lens_t
        SELFCAL_ERROR_RIGHT_LENS = 114,
        /// right camera: a coefficient that the lens model does not use is not 0
        SELFCAL_ERROR_RIGHT_COEFFICIENT = 115,

        /// ray: the pixel is not finite
        SELFCAL_ERROR_RAY_NOT_FINITE = 120,
        /// ray: the pixel is outside the image by more than half a pixel
        SELFCAL_ERROR_RAY_OUTSIDE_IMAGE = 121,
        /// ray: the lens model is not one to one at the pixel, or the ray is over 85 degrees off axis
        SELFCAL_ERROR_RAY_NOT_INVERTIBLE = 122,
        /// pixel: the ray is not finite
        SELFCAL_ERROR_PIXEL_NOT_FINITE = 130,
        /// pixel: the lens model is not one to one at the ray
        SELFCAL_ERROR_PIXEL_BEYOND_LENS = 131,

        /// extrinsics: R is not finite, not orthonormal to about 0.1, or a reflection
        SELFCAL_ERROR_EXTRINSICS_NOT_A_ROTATION = 200,
        /// extrinsics: t is not finite or has no direction
        SELFCAL_ERROR_EXTRINSICS_NO_DIRECTION = 201,
        /// extrinsics: t is within 6 degrees of an optical axis; such a rig cannot be rectified
        SELFCAL_ERROR_EXTRINSICS_ALONG_OPTICAL_AXIS = 202,

        /// configuration: the Huber threshold is not finite or not above 0 px
        SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD = 300,
        /// configuration: fewer than 2 passes
        SELFCAL_ERROR_CONFIG_MAX_PASSES = 301,
        /// configuration: the step tolerance is not within 0 to 0.1 rad
        SELFCAL_ERROR_CONFIG_STEP_TOLERANCE = 302,
        /// configuration: fewer than 6 correspondences
        SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES = 303,
        /// configuration: the noise floor is not finite or not above 0 px
        SELFCAL_ERROR_CONFIG_NOISE_FLOOR = 304,
        /// configuration: the standard deviation of the prior is not within 1e-4 to 1 rad
        SELFCAL_ERROR_CONFIG_PRIOR_SD = 305,
        /// configuration: the largest standard deviation is not finite or not above 0 rad
        SELFCAL_ERROR_CONFIG_MAX_SD = 306,
        /// configuration: the memory is below 20 pairs
        SELFCAL_ERROR_CONFIG_MEMORY = 307,
        /// configuration: the correction limit is not above 0 and below 1.5 rad
        SELFCAL_ERROR_CONFIG_MAX_CORRECTION = 308,
        /// configuration: a deviation of the lens is not within 0 to 0.1, of the principal point 0 to 100 px
        SELFCAL_ERROR_CONFIG_LENS_PRIOR = 309,
        /// configuration: the deviation of the factory yaw is not within 1e-6 to 1 rad
        SELFCAL_ERROR_CONFIG_FACTORY_YAW = 311,
        /// configuration: the deviation of the apparent yaw of the lens is not within 0 to 0.1 rad
        SELFCAL_ERROR_CONFIG_LENS_YAW = 312,
        /// configuration: the length of the baseline is not within 1e-3 to 1e3 m
        SELFCAL_ERROR_CONFIG_BASELINE_LENGTH = 313,

        /// push: a pair is being solved; finish or clear it first
        SELFCAL_ERROR_PUSH_BUSY = 401,
        /// push: the score is not within 0 to 1
        SELFCAL_ERROR_PUSH_SCORE = 402,
        /// push: the grid step is not within 0 to 255.99 px
        SELFCAL_ERROR_PUSH_GRID_STEP = 403,
        /// push: the left pixel is not finite
        SELFCAL_ERROR_PUSH_LEFT_NOT_FINITE = 410,
        /// push: the left pixel is outside the image by more than half a pixel
        SELFCAL_ERROR_PUSH_LEFT_OUTSIDE_IMAGE = 411,
        /// push: the lens model is not invertible at the left pixel
        SELFCAL_ERROR_PUSH_LEFT_NOT_INVERTIBLE = 412,
        /// push: the right pixel is not finite
        SELFCAL_ERROR_PUSH_RIGHT_NOT_FINITE = 420,
        /// push: the right pixel is outside the image by more than half a pixel
        SELFCAL_ERROR_PUSH_RIGHT_OUTSIDE_IMAGE = 421,
        /// push: the lens model is not invertible at the right pixel
        SELFCAL_ERROR_PUSH_RIGHT_NOT_INVERTIBLE = 422,

        /// pair: not begun; call selfcal_begin_pair first
        SELFCAL_ERROR_PAIR_NOT_BEGUN = 501,
        /// pair: fewer usable correspondences than configured; collect more
        SELFCAL_ERROR_PAIR_TOO_FEW = 502,
        /// pair: the correspondences agree on no extrinsics; all may be outliers
        SELFCAL_ERROR_PAIR_NO_CONSENSUS = 503,
        /// pair: a direction is not observable; correspondences all alike, on a line, or at infinity
        SELFCAL_ERROR_PAIR_UNOBSERVABLE = 504,
        /// pair: the points are behind the cameras; left and right exchanged, t of the other sign, an image mirrored or both upside down
        SELFCAL_ERROR_PAIR_BEHIND = 506,
        /// pair: disparities run along the columns; u and v exchanged, cameras one above the other, or a wrong t
        SELFCAL_ERROR_PAIR_COLUMNS = 507,
        /// pair: no depth; all disparities are alike, as of the same image on both sides
        SELFCAL_ERROR_PAIR_NO_DEPTH = 508,

        /// fuse: the standard deviation of the weakest direction of the pair is too large
        SELFCAL_ERROR_FUSE_TOO_UNCERTAIN = 600,
        /// fuse: the distance from the factory extrinsics exceeds the correction limit
        SELFCAL_ERROR_FUSE_CORRECTION_LIMIT = 601,
        /// fuse: the estimate with this pair cannot be rectified
        SELFCAL_ERROR_FUSE_NO_RIG = 602,
        /// fuse: the pair disagrees with the estimate and with the challenger
        SELFCAL_ERROR_FUSE_DISAGREES = 603,
        /// fuse: the calibrator is frozen
        SELFCAL_ERROR_FUSE_FROZEN = 605,

        /// apply: no pair has been fused
        SELFCAL_ERROR_APPLY_NO_PROPOSAL = 700,
        /// apply: the fused pairs agree on no extrinsics
        SELFCAL_ERROR_APPLY_INCONSISTENT = 701,
        /// apply: the estimate is not locked; read selfcal_state
        SELFCAL_ERROR_APPLY_NOT_LOCKED = 702,
        /// apply: a second crowd of matches, or image halves that disagree; read the doubt
        SELFCAL_ERROR_APPLY_DOUBTFUL = 703,
        /// apply: the calibrator is frozen
        SELFCAL_ERROR_APPLY_FROZEN = 704,
        /// undo: nothing has been applied since the last reset or undo
        SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO = 705,

        /// rectify: alpha is not within 0 to 1
        SELFCAL_ERROR_RECTIFY_ALPHA = 800,
        /// rectify: the rectified views share no rectangle, or are not upright
        SELFCAL_ERROR_RECTIFY_NO_COMMON_VIEW = 801,
        /// rectify: a point on the border of the left image is not finite
        SELFCAL_ERROR_RECTIFY_LEFT_NOT_FINITE = 810,
        /// rectify: a point on the border of the left image is outside it
        SELFCAL_ERROR_RECTIFY_LEFT_OUTSIDE_IMAGE = 811,
        /// rectify: the lens model is not invertible on the border of the left image
        SELFCAL_ERROR_RECTIFY_LEFT_NOT_INVERTIBLE = 812,
        /// rectify: the left image border is behind the rectified plane; the rotation is too large
        SELFCAL_ERROR_RECTIFY_LEFT_BEHIND = 813,
        /// rectify: a point on the border of the right image is not finite
        SELFCAL_ERROR_RECTIFY_RIGHT_NOT_FINITE = 820,
        /// rectify: a point on the border of the right image is outside it
        SELFCAL_ERROR_RECTIFY_RIGHT_OUTSIDE_IMAGE = 821,
        /// rectify: the lens model is not invertible on the border of the right image
        SELFCAL_ERROR_RECTIFY_RIGHT_NOT_INVERTIBLE = 822,
        /// rectify: the right image border is behind the rectified plane; the rotation is too large
        SELFCAL_ERROR_RECTIFY_RIGHT_BEHIND = 823,

        /// restore: the record is damaged
        SELFCAL_ERROR_RESTORE_DAMAGED = 1000,
        /// restore: the record is of another kind
        SELFCAL_ERROR_RESTORE_FOREIGN = 1001,
        /// restore: the record has the layout of another firmware
        SELFCAL_ERROR_RESTORE_LAYOUT = 1002,
        /// restore: the record is of other cameras or other factory extrinsics
        SELFCAL_ERROR_RESTORE_OTHER_RIG = 1003,
        /// restore: a number of the record is out of its range; another program wrote it
        SELFCAL_ERROR_RESTORE_ABSURD = 1004,
        /// restore: beyond the correction limit, or of corrected cameras where the configuration only reports
        SELFCAL_ERROR_RESTORE_CONFIG = 1005,

        /// link: a pair is being solved, no byte was used; finish or clear it, then feed on
        SELFCAL_ERROR_LINK_BUSY = 1100,
        /// link: frame refused, the image sizes of matcher and cameras differ; feed on
        SELFCAL_ERROR_LINK_IMAGE_SIZE = 1102,

        /// frame: the header has an unknown flag
        SELFCAL_ERROR_FRAME_FLAGS = 1113,
        /// frame: the fraction bits are not within 0 to 8
        SELFCAL_ERROR_FRAME_FRACTION_BITS = 1114,
        /// frame: the pyramid ratio is below 64/64
        SELFCAL_ERROR_FRAME_PYRAMID_RATIO = 1115,
        /// frame: a coordinate is not finite, or not within the 24 bits of a record; drop the match
        SELFCAL_ERROR_FRAME_COORDINATE = 1120,
        /// frame: the score is not within 0 to 1; drop the match
        SELFCAL_ERROR_FRAME_SCORE = 1121,
        /// frame: no level of the pyramid of the header has this grid step
        SELFCAL_ERROR_FRAME_GRID_STEP = 1122,
        /// frame: it has as many matches as its header counts; end it
        SELFCAL_ERROR_FRAME_FULL = 1123,
        /// frame: it has fewer matches than its header counts
        SELFCAL_ERROR_FRAME_MISSING = 1124,

        /// range: the length of the baseline is not known; call selfcal_config_set_baseline_m
        SELFCAL_ERROR_RANGE_NO_BASELINE = 1200,
        /// range: the estimate is not locked, or frozen
        SELFCAL_ERROR_RANGE_NOT_LOCKED = 1201,
        /// range: range or deviation is not that of a sensor
        SELFCAL_ERROR_RANGE_READING = 1202,
        /// range: no match near the pixel fits the estimate
        SELFCAL_ERROR_RANGE_NO_MATCH = 1203,
        /// range: the reading contradicts mount and lens
        SELFCAL_ERROR_RANGE_CONTRADICTS = 1204,
        /// range: the pixel is not finite
        SELFCAL_ERROR_RANGE_NOT_FINITE = 1210,
        /// range: the pixel is outside the image by more than half a pixel
        SELFCAL_ERROR_RANGE_OUTSIDE_IMAGE = 1211,
        /// range: the lens model is not invertible at the pixel
        SELFCAL_ERROR_RANGE_NOT_INVERTIBLE = 1212,
        /// motion: the estimate is not locked, or frozen
        SELFCAL_ERROR_MOTION_NOT_LOCKED = 1220,
        /// motion: too few tracked matches
        SELFCAL_ERROR_MOTION_TOO_FEW = 1221,
        /// motion: no motion that tells yaw
        SELFCAL_ERROR_MOTION_NO_MOTION = 1222,
        /// motion: it contradicts mount and lens
        SELFCAL_ERROR_MOTION_CONTRADICTS = 1223,
    }
}

use selfcal_error_t::*;

from_core!(
    UndistortError, ProjectError, ExtrinsicsError, ConfigError, PushError, Rejection,
    ApplyError, RangeError, MotionError, RectifyError, RestoreError, FrameRefusal, HeaderError, EncodeError
    => selfcal_error_t, else SELFCAL_ERROR_UNKNOWN
);

/// Text of an error code, English; never null, `"unknown"` for other numbers.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_error_string(error: i32) -> *const c_char {
    find(selfcal_error_t::TEXTS, error.cast_unsigned())
}

/// The error code of a call: that of its body, else `SELFCAL_OK`.
pub(crate) fn status(body: impl FnOnce() -> Result<(), selfcal_error_t>) -> selfcal_error_t {
    body().err().unwrap_or(SELFCAL_OK)
}
