//! The error codes and their texts.

use stereo_selfcal::depth::{MotionError, RangeError};
use stereo_selfcal::geometry::{ProjectError, RectifyError, UndistortError};
use stereo_selfcal::link::{EncodeError, FrameRefusal, HeaderError};
use stereo_selfcal::{ApplyError, PushError, Rejection, RestoreError};

c_enum! {
    /// Result of a call. An error that several functions return has the same number in all of them. Numbers from 100 on
    /// equal the error codes of the core.
    #[repr(u32)]
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
        /// an argument is out of its range
        SELFCAL_ERROR_VALUE = 5,
        /// a parameter of the configuration is out of its range; selfcal_argument_string names it
        SELFCAL_ERROR_CONFIG = 6,
        /// a camera or the extrinsics are not valid; selfcal_argument_string names the quantity
        SELFCAL_ERROR_FACTORY = 7,
        /// the header is of another version than the library, or compiled to structs of other sizes
        SELFCAL_ERROR_HEADER = 8,
        /// the core returned an error that this API does not know
        SELFCAL_ERROR_UNKNOWN = 99,

        /// a pixel or a ray is not finite
        SELFCAL_ERROR_NOT_FINITE = 120,
        /// a pixel is outside the image by more than half a pixel
        SELFCAL_ERROR_OUTSIDE_IMAGE = 121,
        /// the lens model is not one to one at the pixel, or the ray is over 85 degrees off axis
        SELFCAL_ERROR_NOT_INVERTIBLE = 122,
        /// the lens model is not one to one at the ray
        SELFCAL_ERROR_BEYOND_LENS = 123,

        /// a pair is being solved; finish or discard it first
        SELFCAL_ERROR_BUSY = 401,
        /// the score is not within 0 to 1
        SELFCAL_ERROR_SCORE = 402,
        /// the grid step is not within 0 to 255.99 px
        SELFCAL_ERROR_GRID_STEP = 403,

        /// fewer usable correspondences than configured; collect more
        SELFCAL_ERROR_TOO_FEW = 502,
        /// the correspondences agree on no extrinsics; all may be outliers
        SELFCAL_ERROR_NO_CONSENSUS = 503,
        /// a direction is not observable; correspondences all alike, on a line, or at infinity
        SELFCAL_ERROR_UNOBSERVABLE = 504,
        /// points behind the cameras; left and right exchanged, wrong sign of t, an image mirrored or both upside down
        SELFCAL_ERROR_BEHIND = 506,
        /// disparities run along the columns; u and v exchanged, cameras one above the other, or a wrong t
        SELFCAL_ERROR_COLUMNS = 507,
        /// no depth; all disparities are alike, as with the same image on both sides
        SELFCAL_ERROR_NO_DEPTH = 508,
        /// rows not measured; the matcher searches along rows
        SELFCAL_ERROR_ROWS_NOT_MEASURED = 509,

        /// the standard deviation of the weakest direction of the pair is too large
        SELFCAL_ERROR_TOO_UNCERTAIN = 600,
        /// the distance from the factory extrinsics exceeds the correction limit
        SELFCAL_ERROR_CORRECTION_LIMIT = 601,
        /// the estimate with this pair cannot be rectified
        SELFCAL_ERROR_NO_RIG = 602,
        /// the pair disagrees with the estimate and with the challenger
        SELFCAL_ERROR_DISAGREES = 603,
        /// the calibrator is frozen
        SELFCAL_ERROR_FROZEN = 605,

        /// no pair has been fused
        SELFCAL_ERROR_NO_ESTIMATE = 700,
        /// the fused pairs agree on no extrinsics
        SELFCAL_ERROR_INCONSISTENT = 701,
        /// the estimate is not locked; read selfcal_state
        SELFCAL_ERROR_NOT_LOCKED = 702,
        /// a second crowd of matches, or image halves that disagree; read the verdict
        SELFCAL_ERROR_DOUBTFUL = 703,
        /// nothing has been applied since the last reset or undo
        SELFCAL_ERROR_NOTHING_TO_UNDO = 705,

        /// alpha is not within 0 to 1
        SELFCAL_ERROR_ALPHA = 800,
        /// the rectified views share no rectangle, or are not upright
        SELFCAL_ERROR_NO_COMMON_VIEW = 801,
        /// an image border is behind the rectified plane; the rotation is too large
        SELFCAL_ERROR_BEHIND_PLANE = 802,
        /// a point on an image border has no ray; check the lens model
        SELFCAL_ERROR_BORDER = 803,

        /// the record is damaged
        SELFCAL_ERROR_RECORD_DAMAGED = 1000,
        /// the record is of another kind
        SELFCAL_ERROR_RECORD_FOREIGN = 1001,
        /// the record has the layout of another firmware
        SELFCAL_ERROR_RECORD_LAYOUT = 1002,
        /// the record is of other cameras or other factory extrinsics
        SELFCAL_ERROR_RECORD_OTHER_RIG = 1003,
        /// a number of the record is out of its range; another program wrote it
        SELFCAL_ERROR_RECORD_ABSURD = 1004,
        /// the record is beyond the correction limit, or of corrected cameras where the configuration only reports
        SELFCAL_ERROR_RECORD_CONFIG = 1005,

        /// frame refused, the image sizes of matcher and cameras differ; feed on
        SELFCAL_ERROR_IMAGE_SIZE = 1102,
        /// frame header with an unknown flag, fraction bits beyond 8, or a pyramid ratio below 64/64
        SELFCAL_ERROR_FRAME_HEADER = 1113,
        /// a coordinate is not finite, or not within the 24 bits of a record; drop the match
        SELFCAL_ERROR_FRAME_COORDINATE = 1120,
        /// no level of the pyramid of the header has this grid step
        SELFCAL_ERROR_FRAME_GRID_STEP = 1122,
        /// the frame has as many matches as its header counts; end it
        SELFCAL_ERROR_FRAME_FULL = 1123,
        /// the frame has fewer matches than its header counts
        SELFCAL_ERROR_FRAME_MISSING = 1124,

        /// the length of the baseline is not known; set baseline_m of the factory calibration
        SELFCAL_ERROR_NO_BASELINE = 1200,
        /// range or deviation is out of the range of a sensor
        SELFCAL_ERROR_READING = 1202,
        /// no match in the batch fits the estimate; for a range, none near its pixel
        SELFCAL_ERROR_NO_MATCH = 1203,
        /// the witness contradicts mount and lens
        SELFCAL_ERROR_CONTRADICTS = 1204,
        /// no motion that tells yaw
        SELFCAL_ERROR_NO_MOTION = 1222,
    }
}

use selfcal_error_t::*;

from_core!(
    UndistortError, ProjectError, PushError, Rejection, ApplyError, RangeError,
    MotionError, RectifyError, RestoreError, FrameRefusal, HeaderError, EncodeError
    => selfcal_error_t from 0, else SELFCAL_ERROR_UNKNOWN
);

/// Returns the error code of the body of a call, or `SELFCAL_OK` without an error.
pub(crate) fn status(body: impl FnOnce() -> Result<(), selfcal_error_t>) -> selfcal_error_t {
    body().err().unwrap_or(SELFCAL_OK)
}
