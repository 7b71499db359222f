//! Errors: one small enum per operation. No error changes the extrinsics in use, except an error of
//! [`crate::Calibrator::restore`] or [`crate::store::Store::resume`], which puts the factory calibration into use.
//! [`crate::Calibrator::advance_pair`] says which rejected pairs count against the estimate.

use thiserror::Error;

use crate::state::State;

/// A camera of the pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// Left: its frame is the frame of the rig, `p_r = R p_l + t`.
    Left,
    /// Right.
    Right,
}

texts! { Side { Left = "left", Right = "right" } }

/// Why a camera or lens was refused. Correct the named quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CameraError {
    /// A focal length is not finite or not in 1..=1e6 px.
    #[error("focal length is not finite or not within 1 to 1e6 px")]
    FocalLength,
    /// The principal point is not finite, or it is further outside the image than the size of the image.
    #[error("principal point is not finite or far outside the image")]
    PrincipalPoint,
    /// The image is smaller than 2 x 2 px.
    #[error("image is smaller than 2 x 2 px")]
    ImageSize,
    /// A distortion coefficient is not finite or above 1e3 in magnitude; of a rational lens above 1e5.
    #[error("distortion coefficient is not finite or out of range")]
    Distortion,
}

/// Why a pixel has no ray. Drop the correspondence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UndistortError {
    /// A coordinate is NaN or infinite.
    #[error("pixel is not finite")]
    NotFinite,
    /// The pixel lies outside the image by more than half a pixel.
    #[error("pixel is outside the image")]
    OutsideImage,
    /// The lens model folds back before or near this pixel, or the ray of the pixel is more than 85 degrees off axis.
    #[error("the lens model is not invertible at this pixel")]
    NotInvertible,
}

/// Why a ray has no pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ProjectError {
    /// A coordinate is NaN or infinite.
    #[error("ray is not finite")]
    NotFinite,
    /// The ray lies beyond the range in which the lens model is one to one, or is more than 85 degrees off axis.
    #[error("ray is beyond the range of the lens model")]
    BeyondLens,
}

/// Why `R`, `t` are not the extrinsics of a stereo rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ExtrinsicsError {
    /// `R` is not finite, not orthonormal to about 0.1, or a reflection.
    #[error("R is not a rotation")]
    NotARotation,
    /// `t` is not finite or has no direction.
    #[error("t has no direction")]
    NoDirection,
    /// `t` is within 6 degrees of an optical axis: such a rig cannot be rectified.
    #[error("the baseline lies along an optical axis")]
    AlongOpticalAxis,
}

/// The parameter of a configuration that was out of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// Limit of the row offset of a match that fits: finite and above 0 px.
    #[error("fit limit must be finite and above 0 px")]
    FitLimit,
    /// Huber threshold of the published method: finite and above 0 px.
    #[error("huber threshold must be finite and above 0 px")]
    HuberThreshold,
    /// Passes: at least 2.
    #[error("max passes must be at least 2")]
    MaxPasses,
    /// Step tolerance: finite, from 0 to 0.1 rad.
    #[error("step tolerance must lie within 0 to 0.1 rad")]
    StepTolerance,
    /// Least number of correspondences: at least 6, one more than the number of unknowns.
    #[error("min correspondences must be at least 6")]
    MinCorrespondences,
    /// Noise floor: from 0.001 to 100 px.
    #[error("noise floor must lie within 0.001 to 100 px")]
    NoiseFloor,
    /// Standard deviation of the prior: from 1e-4 to 1 rad.
    #[error("prior standard deviation must lie within 1e-4 to 1 rad")]
    PriorStandardDeviation,
    /// Largest standard deviation: finite and above 0 rad.
    #[error("max standard deviation must be finite and above 0 rad")]
    MaxStandardDeviation,
    /// Memory: at least 20 pairs.
    #[error("memory must be at least 20 pairs")]
    Memory,
    /// Standard deviations of the lens: 0 to 100 px for the principal point, 0 to 0.1 for all others.
    #[error("lens deviations must lie within 0 to 0.1, of the principal point 0 to 100 px")]
    LensPrior,
    /// Correction limit: above 0 and below 1.5 rad.
    #[error("max correction must lie within 0 to 1.5 rad")]
    MaxCorrection,
    /// Standard deviation of the factory yaw: from 1e-6 to 1 rad.
    #[error("deviation of the factory yaw must lie within 1e-6 to 1 rad")]
    FactoryYaw,
    /// Standard deviation of the apparent yaw of the lens: from 0 to 0.1 rad.
    #[error("deviation of the lens's yaw must lie within 0 to 0.1 rad")]
    LensYaw,
    /// Limit of the row offset: above 0 px.
    #[error("limit of the rows must be above 0 px")]
    RowsLimit,
    /// Limit of the depth error: above 0 px.
    #[error("limit of the depth must be above 0 px")]
    DepthLimit,
    /// Limit of the coverage: from 0 to 1.
    #[error("limit of the coverage must lie within 0 to 1")]
    CoverageLimit,
    /// Length of the baseline: from 1e-3 to 1e3 m.
    #[error("length of the baseline must lie within 1e-3 to 1e3 m")]
    BaselineLength,
}

/// Why a range reading was not taken. The estimate is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RangeError {
    /// The factory calibration has no baseline length: [`crate::FactoryCalibration::with_baseline_m`].
    #[error("the length of the baseline is not known")]
    NoBaseline,
    /// The estimate is not locked, or the calibrator is frozen; later readings may be taken.
    #[error("the estimate is not locked, or frozen")]
    NotLocked,
    /// The range is not within 0.01 to 1e5 m, or its standard deviation is not above 0 and at most the range.
    #[error("range or deviation is out of the range of a sensor")]
    Reading,
    /// The left or the right pixel of the reading has no ray.
    #[error("pixel: {0}")]
    Pixel(UndistortError),
    /// The reading's own match does not fit the estimate; without one, no match near the pixel fits it.
    #[error("no match near the pixel fits the estimate")]
    NoMatch,
    /// The apparent yaw of the lens would have to be off by more than three standard deviations of its prior: the
    /// sensor has measured another point, or its scale is wrong.
    #[error("reading contradicts mount and lens")]
    Contradicts,
}

/// Why tracked matches were not taken. The estimate is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MotionError {
    /// The estimate is not locked, or the calibrator is frozen.
    #[error("the estimate is not locked, or frozen")]
    NotLocked,
    /// There are fewer tracked matches than a pair needs.
    #[error("too few tracked matches")]
    TooFew,
    /// The tracked matches agree on no motion, or on a motion that does not determine yaw: the rig is at rest, or only
    /// turns.
    #[error("no motion that tells yaw")]
    NoMotion,
    /// The apparent yaw of the lens would have to be off by more than three standard deviations of its prior.
    #[error("motion contradicts mount and lens")]
    Contradicts,
}

/// Why a correspondence was not taken. It is not in the batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PushError {
    /// A pair is being solved: finish it or discard it first.
    #[error("a pair is being solved")]
    Busy,
    /// A pixel has no ray.
    #[error("{0} pixel: {1}")]
    Pixel(Side, UndistortError),
    /// The score is not within 0 to 1.
    #[error("score is not within 0 to 1")]
    Score,
    /// The grid step is not within 0 to 255.99 px.
    #[error("grid step is not within 0 to 255.99 px")]
    GridStep,
}

/// Why a pair is not in the estimate. Take the next pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Rejection {
    /// The batch has fewer usable correspondences than the configuration asks for; nothing is wrong.
    #[error("{usable} usable correspondences, {needed} needed")]
    TooFew {
        /// Number of correspondences in the batch, without those found behind a camera.
        usable: u32,
        /// Number that the configuration asks for.
        needed: u32,
    },
    /// No extrinsics were found at which clearly more matches have small row offsets than by chance: most matches are
    /// outliers, or the noise is too large.
    #[error("the correspondences agree on no extrinsics")]
    NoConsensus,
    /// Under the extrinsics that the matches agree on, the points are behind the cameras: left and right are exchanged,
    /// `t` of the factory extrinsics has the other sign, one image is mirrored, or both are upside down. Such pairs are
    /// never fused.
    #[error(
        "the points are behind the cameras: left and right exchanged, t of the other sign, an image mirrored or both \
         upside down"
    )]
    Behind,
    /// The matches fit cameras one above the other clearly better than cameras side by side: u and v are exchanged, the
    /// cameras are mounted one above the other, or `t` of the factory extrinsics is wrong.
    #[error(
        "disparities run along the columns: u and v exchanged, cameras one above the other, or a wrong t"
    )]
    Columns,
    /// The disparities are equal, or change linearly from left to right, to within a tenth of the standard deviation of
    /// their noise: both sides show the same image, or the scene is one upright plane. Such a pair does not show
    /// whether the calibration is good.
    #[error("no depth: all disparities alike, such as with the same image on both sides")]
    NoDepth,
    /// Nearly all rows of left and right are equal, in the images or after rectification with the calibration in use:
    /// the matcher searches along the rows and has not measured them. Such a pair says nothing about the calibration.
    #[error("rows not measured: the matcher searches along rows")]
    RowsNotMeasured,
    /// The correspondences leave a direction of the extrinsics free: they are all alike, or on one line. In the
    /// published method they may also be all far away. The pair is also refused for this reason if its own extrinsics
    /// are not valid.
    #[error("the correspondences leave a direction of the extrinsics free")]
    Unobservable,
    /// The pair's weakest direction is less certain than the configuration allows (published method only).
    #[error("the weakest direction of the pair is too uncertain")]
    TooUncertain,
    /// `R` or `t` of the estimate with the pair, or in the published method of the pair alone, is further from the
    /// factory values than the correction limit. If this error returns again and again, the factory values are wrong or
    /// the mount has moved.
    #[error("further from the factory extrinsics than the correction limit")]
    CorrectionLimit,
    /// The estimate with this pair has no valid optimum, or cannot be rectified.
    #[error("the pair leads to extrinsics that cannot be rectified")]
    NoRig,
    /// The pair disagrees with the estimate, and with the challenger if there is one.
    #[error("the pair disagrees with the estimate")]
    Disagrees,
    /// The calibrator is frozen: the pair was solved, and changes nothing.
    #[error("the calibrator is frozen")]
    Frozen,
    /// No pair was being solved. [`crate::Calibrator`] never returns this error.
    #[error("no pair has been begun")]
    NotBegun,
}

/// Why nothing was applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ApplyError {
    /// There is no estimate: no pair has been fused, or the estimate was dropped or began again, and no pair has been
    /// fused since.
    #[error("there is no proposal: no pair has been fused")]
    NoProposal,
    /// The fused pairs give no valid calibration: the result cannot be rectified, its covariance is not valid, or its
    /// corrected cameras are out of range.
    #[error("the fused pairs agree on no extrinsics")]
    Inconsistent,
    /// The estimate is not [`State::Locked`]: it is not confirmed, or the last pairs disagree with it.
    #[error("the estimate is {0}, not locked")]
    NotLocked(State),
    /// The matches are doubtful: [`crate::Reason::SecondMode`] or [`crate::Reason::Biased`].
    /// [`crate::Proposal::reasons`] says which.
    #[error("a second crowd of matches, or image halves that disagree: the matches are biased")]
    Doubtful,
    /// The calibrator is frozen.
    #[error("the calibrator is frozen")]
    Frozen,
    /// [`crate::Calibrator::apply`] has changed no calibration since the last reset or undo.
    #[error("nothing has been applied since the last reset")]
    NothingToUndo,
}

/// Why a record was not read. After the failed restore of a state, the calibrator is in the state after
/// [`crate::Calibrator::reset`]: continue from the factory calibration. If the factory calibration itself cannot be
/// read, the rig needs another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError {
    /// The checksum or the length of the record is wrong.
    #[error("the record is damaged")]
    Damaged,
    /// The record is of another kind.
    #[error("the record is of something else")]
    Foreign,
    /// The record has the layout of an earlier or later firmware.
    #[error("the record has layout {0}, and this firmware has another one")]
    Layout(u8),
    /// The record was learnt with other cameras or from other factory extrinsics.
    #[error("the record is of another rig")]
    OtherRig,
    /// A number is out of its range, or numbers do not fit together, although the checksum is right: probably another
    /// program wrote the record.
    #[error("a number of the record is out of its range")]
    Absurd,
    /// The record is beyond the correction limit, or it has corrected cameras ([`crate::LensTracking::Compensate`])
    /// although the configuration only reports lens errors.
    #[error("the record is beyond what the configuration allows")]
    Config,
}

/// Why a rig has no common rectified camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RectifyError {
    /// `alpha` is not within 0 to 1.
    #[error("alpha is not within 0 to 1")]
    Alpha,
    /// A point on an image border has no ray.
    #[error("{0} image border: {1}")]
    Border(Side, UndistortError),
    /// The ray of a border point points backwards or almost sideways in the rectified frame: the rig is turned too far.
    #[error("the {0} image border lies behind the rectified plane")]
    Behind(Side),
    /// The two cameras see no common rectangle of the rectified plane, or the rectified images are not upright: cameras
    /// one above the other, or left and right exchanged.
    #[error("the rectified views share no rectangle")]
    NoCommonView,
}

// Numbers of the errors that several enumerations have.

/// The estimate is not locked.
const NOT_LOCKED: u16 = 702;
/// The calibrator is frozen.
const FROZEN: u16 = 605;
/// Too few correspondences.
const TOO_FEW: u16 = 502;
/// A witness contradicts mount and lens.
const CONTRADICTS: u16 = 1204;
/// No pair has been fused.
const NO_ESTIMATE: u16 = 700;
/// No match fits the estimate.
const NO_MATCH: u16 = 1203;
/// A pair is being solved.
pub(crate) const BUSY: u16 = 401;
/// A score is out of its range.
pub(crate) const SCORE: u16 = 402;

codes! {
    Side { Left = 0, Right = 1 }
    CameraError { FocalLength = 100, PrincipalPoint = 101, ImageSize = 102, Distortion = 103 }
    UndistortError { NotFinite = 120, OutsideImage = 121, NotInvertible = 122 }
    ProjectError { NotFinite = 120, BeyondLens = 123 }
    ExtrinsicsError { NotARotation = 200, NoDirection = 201, AlongOpticalAxis = 202 }
    ConfigError {
        HuberThreshold = 300, MaxPasses = 301, StepTolerance = 302, MinCorrespondences = 303,
        NoiseFloor = 304, PriorStandardDeviation = 305, MaxStandardDeviation = 306, Memory = 307,
        MaxCorrection = 308, LensPrior = 309, FactoryYaw = 311, LensYaw = 312, BaselineLength = 313,
        RowsLimit = 314, DepthLimit = 315, CoverageLimit = 316, FitLimit = 317,
    }
    PushError { Busy = BUSY, Score = SCORE, GridStep = 403, Pixel { 1: why } = why.code() }
    RangeError {
        NoBaseline = 1200, NotLocked = NOT_LOCKED, Reading = 1202, NoMatch = NO_MATCH,
        Contradicts = CONTRADICTS, Pixel { 0: why } = why.code(),
    }
    MotionError {
        NotLocked = NOT_LOCKED, TooFew = TOO_FEW, NoMotion = 1222, Contradicts = CONTRADICTS,
    }
    Rejection {
        NotBegun = 501, TooFew = TOO_FEW, NoConsensus = 503, Unobservable = 504, Behind = 506,
        Columns = 507, NoDepth = 508, RowsNotMeasured = 509, TooUncertain = 600, CorrectionLimit = 601, NoRig = 602,
        Disagrees = 603, Frozen = FROZEN,
    }
    ApplyError {
        NoProposal = NO_ESTIMATE, Inconsistent = 701, NotLocked = NOT_LOCKED, Doubtful = 703,
        Frozen = FROZEN, NothingToUndo = 705,
    }
    RectifyError { Alpha = 800, NoCommonView = 801, Behind = 802, Border = 803 }
    RestoreError {
        Damaged = 1000, Foreign = 1001, Layout = 1002, OtherRig = 1003, Absurd = 1004, Config = 1005,
    }
}
