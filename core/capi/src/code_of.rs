//! Errors of the core as error codes: each its own.

use stereo_selfcal::link::FrameRefusal;
use stereo_selfcal::{
    ApplyError, CameraError, ConfigError, ExtrinsicsError, PairError, ProjectError, PushError,
    RectifyError, Refusal, Rejection, RestoreError, Side, SnapshotError, UndistortError,
};

use crate::code::selfcal_error_t::{self, *};

/// Of one of the two cameras.
pub(crate) fn of_camera(side: Side, error: CameraError) -> selfcal_error_t {
    let [left, right] = match error {
        CameraError::FocalLength => {
            [SELFCAL_ERROR_LEFT_FOCAL_LENGTH, SELFCAL_ERROR_RIGHT_FOCAL_LENGTH]
        }
        CameraError::PrincipalPoint => {
            [SELFCAL_ERROR_LEFT_PRINCIPAL_POINT, SELFCAL_ERROR_RIGHT_PRINCIPAL_POINT]
        }
        CameraError::ImageSize => [SELFCAL_ERROR_LEFT_IMAGE_SIZE, SELFCAL_ERROR_RIGHT_IMAGE_SIZE],
        CameraError::Distortion => [SELFCAL_ERROR_LEFT_DISTORTION, SELFCAL_ERROR_RIGHT_DISTORTION],
        _ => [SELFCAL_ERROR_UNKNOWN; 2],
    };
    of_side(side, left, right)
}

/// One of two codes, by side.
pub(crate) fn of_side(
    side: Side,
    left: selfcal_error_t,
    right: selfcal_error_t,
) -> selfcal_error_t {
    match side {
        Side::Left => left,
        Side::Right => right,
    }
}

impl From<UndistortError> for selfcal_error_t {
    fn from(error: UndistortError) -> Self {
        match error {
            UndistortError::NotFinite => SELFCAL_ERROR_RAY_NOT_FINITE,
            UndistortError::OutsideImage => SELFCAL_ERROR_RAY_OUTSIDE_IMAGE,
            UndistortError::NotInvertible => SELFCAL_ERROR_RAY_NOT_INVERTIBLE,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<ProjectError> for selfcal_error_t {
    fn from(error: ProjectError) -> Self {
        match error {
            ProjectError::NotFinite => SELFCAL_ERROR_PIXEL_NOT_FINITE,
            ProjectError::BeyondLens => SELFCAL_ERROR_PIXEL_BEYOND_LENS,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<ExtrinsicsError> for selfcal_error_t {
    fn from(error: ExtrinsicsError) -> Self {
        match error {
            ExtrinsicsError::NotARotation => SELFCAL_ERROR_EXTRINSICS_NOT_A_ROTATION,
            ExtrinsicsError::NoDirection => SELFCAL_ERROR_EXTRINSICS_NO_DIRECTION,
            ExtrinsicsError::AlongOpticalAxis => SELFCAL_ERROR_EXTRINSICS_ALONG_OPTICAL_AXIS,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<ConfigError> for selfcal_error_t {
    fn from(error: ConfigError) -> Self {
        match error {
            ConfigError::HuberThreshold => SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD,
            ConfigError::MaxPasses => SELFCAL_ERROR_CONFIG_MAX_PASSES,
            ConfigError::StepTolerance => SELFCAL_ERROR_CONFIG_STEP_TOLERANCE,
            ConfigError::MinCorrespondences => SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES,
            ConfigError::NoiseFloor => SELFCAL_ERROR_CONFIG_NOISE_FLOOR,
            ConfigError::PriorStandardDeviation => SELFCAL_ERROR_CONFIG_PRIOR_SD,
            ConfigError::MaxStandardDeviation => SELFCAL_ERROR_CONFIG_MAX_SD,
            ConfigError::Memory => SELFCAL_ERROR_CONFIG_MEMORY,
            ConfigError::MaxCorrection => SELFCAL_ERROR_CONFIG_MAX_CORRECTION,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<PushError> for selfcal_error_t {
    fn from(error: PushError) -> Self {
        match error {
            PushError::NoCameras => SELFCAL_ERROR_PUSH_NO_CAMERAS,
            PushError::Busy => SELFCAL_ERROR_PUSH_BUSY,
            PushError::Score => SELFCAL_ERROR_PUSH_SCORE,
            PushError::GridStep => SELFCAL_ERROR_PUSH_GRID_STEP,
            PushError::Pixel(side, UndistortError::NotFinite) => of_side(
                side,
                SELFCAL_ERROR_PUSH_LEFT_NOT_FINITE,
                SELFCAL_ERROR_PUSH_RIGHT_NOT_FINITE,
            ),
            PushError::Pixel(side, UndistortError::OutsideImage) => of_side(
                side,
                SELFCAL_ERROR_PUSH_LEFT_OUTSIDE_IMAGE,
                SELFCAL_ERROR_PUSH_RIGHT_OUTSIDE_IMAGE,
            ),
            PushError::Pixel(side, UndistortError::NotInvertible) => of_side(
                side,
                SELFCAL_ERROR_PUSH_LEFT_NOT_INVERTIBLE,
                SELFCAL_ERROR_PUSH_RIGHT_NOT_INVERTIBLE,
            ),
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<PairError> for selfcal_error_t {
    fn from(error: PairError) -> Self {
        match error {
            PairError::NoCameras => SELFCAL_ERROR_PAIR_NO_CAMERAS,
            PairError::NotBegun => SELFCAL_ERROR_PAIR_NOT_BEGUN,
            PairError::TooFew { .. } => SELFCAL_ERROR_PAIR_TOO_FEW,
            PairError::NoConsensus => SELFCAL_ERROR_PAIR_NO_CONSENSUS,
            PairError::Unobservable => SELFCAL_ERROR_PAIR_UNOBSERVABLE,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<Refusal> for selfcal_error_t {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::TooUncertain => SELFCAL_ERROR_FUSE_TOO_UNCERTAIN,
            Refusal::CorrectionLimit => SELFCAL_ERROR_FUSE_CORRECTION_LIMIT,
            Refusal::NoRig => SELFCAL_ERROR_FUSE_NO_RIG,
            Refusal::Disagrees => SELFCAL_ERROR_FUSE_DISAGREES,
            Refusal::NothingSolved => SELFCAL_ERROR_FUSE_STALE,
            Refusal::Frozen => SELFCAL_ERROR_FUSE_FROZEN,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<Rejection> for selfcal_error_t {
    fn from(rejection: Rejection) -> Self {
        match rejection {
            Rejection::Unsolved(error) => error.into(),
            Rejection::Refused(refusal) => refusal.into(),
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<ApplyError> for selfcal_error_t {
    fn from(error: ApplyError) -> Self {
        match error {
            ApplyError::NoProposal => SELFCAL_ERROR_APPLY_NO_PROPOSAL,
            ApplyError::Inconsistent => SELFCAL_ERROR_APPLY_INCONSISTENT,
            ApplyError::NotLocked(_) => SELFCAL_ERROR_APPLY_NOT_LOCKED,
            ApplyError::Doubtful => SELFCAL_ERROR_APPLY_DOUBTFUL,
            ApplyError::Frozen => SELFCAL_ERROR_APPLY_FROZEN,
            ApplyError::NothingToUndo => SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<RectifyError> for selfcal_error_t {
    fn from(error: RectifyError) -> Self {
        match error {
            RectifyError::Alpha => SELFCAL_ERROR_RECTIFY_ALPHA,
            RectifyError::NoCommonView => SELFCAL_ERROR_RECTIFY_NO_COMMON_VIEW,
            RectifyError::Border(side, UndistortError::NotFinite) => of_side(
                side,
                SELFCAL_ERROR_RECTIFY_LEFT_NOT_FINITE,
                SELFCAL_ERROR_RECTIFY_RIGHT_NOT_FINITE,
            ),
            RectifyError::Border(side, UndistortError::OutsideImage) => of_side(
                side,
                SELFCAL_ERROR_RECTIFY_LEFT_OUTSIDE_IMAGE,
                SELFCAL_ERROR_RECTIFY_RIGHT_OUTSIDE_IMAGE,
            ),
            RectifyError::Border(side, UndistortError::NotInvertible) => of_side(
                side,
                SELFCAL_ERROR_RECTIFY_LEFT_NOT_INVERTIBLE,
                SELFCAL_ERROR_RECTIFY_RIGHT_NOT_INVERTIBLE,
            ),
            RectifyError::Behind(side) => {
                of_side(side, SELFCAL_ERROR_RECTIFY_LEFT_BEHIND, SELFCAL_ERROR_RECTIFY_RIGHT_BEHIND)
            }
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<SnapshotError> for selfcal_error_t {
    fn from(error: SnapshotError) -> Self {
        match error {
            SnapshotError::Room { .. } => SELFCAL_ERROR_SNAPSHOT_ROOM,
            SnapshotError::NoCameras => SELFCAL_ERROR_SNAPSHOT_NO_CAMERAS,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<RestoreError> for selfcal_error_t {
    fn from(error: RestoreError) -> Self {
        match error {
            RestoreError::Damaged => SELFCAL_ERROR_RESTORE_DAMAGED,
            RestoreError::Foreign => SELFCAL_ERROR_RESTORE_FOREIGN,
            RestoreError::Version(_) => SELFCAL_ERROR_RESTORE_VERSION,
            RestoreError::Scalar => SELFCAL_ERROR_RESTORE_SCALAR,
            RestoreError::Preset => SELFCAL_ERROR_RESTORE_PRESET,
            RestoreError::OtherRig => SELFCAL_ERROR_RESTORE_OTHER_RIG,
            RestoreError::Absurd => SELFCAL_ERROR_RESTORE_ABSURD,
            RestoreError::CorrectionLimit => SELFCAL_ERROR_RESTORE_CORRECTION_LIMIT,
            RestoreError::NotFresh => SELFCAL_ERROR_RESTORE_NOT_FRESH,
            RestoreError::NoCameras => SELFCAL_ERROR_RESTORE_NO_CAMERAS,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}

impl From<FrameRefusal> for selfcal_error_t {
    fn from(refusal: FrameRefusal) -> Self {
        match refusal {
            FrameRefusal::Busy => SELFCAL_ERROR_LINK_BUSY,
            FrameRefusal::NoCameras => SELFCAL_ERROR_LINK_NO_CAMERAS,
            FrameRefusal::ImageSize(_) => SELFCAL_ERROR_LINK_IMAGE_SIZE,
            _ => SELFCAL_ERROR_UNKNOWN,
        }
    }
}
