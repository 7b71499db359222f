/*
 * Online self-calibration of stereo extrinsics from left/right correspondences. C API, f32.
 *
 * Generated from the Rust source: do not edit.
 *
 * Convention: p_r = R p_l + t, |t| = 1. Camera frames x right, y down, z forward; p_l and p_r are the
 * same point in the left and the right camera frame. Matrices row by row, angles in rad, pixels of the
 * raw image, before undistortion, with the centre of the top left pixel at (0, 0).
 *
 * Every function returns a selfcal_error_t and writes its results through pointers; the exceptions are
 * selfcal_string, selfcal_argument_string and selfcal_version, which return a text. Pointers must not be null, unless the
 * function documents otherwise. Null and misaligned pointers and storage that is not initialised are refused.
 * A refused call writes no results except the ones that its documentation names. The calibration in use stays as
 * it is, unless a record is refused: selfcal_restore then leaves the factory calibration in use. Refused
 * correspondences are counted. A refused pair is noted in the verdict and may count against the estimate: go on
 * with the next pair.
 *
 * Nothing allocates, blocks or keeps a pointer. One call at a time for each calibrator and each link.
 *
 * Complete programs: core/capi/examples/readme/usage.c, from matches to extrinsics, and firmware.c, from
 * the bytes of a matcher (format: core/src/link/FORMAT.md), with records over a loss of power. In short:
 *
 *     static selfcal_t cal;
 *
 *     at start: selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &factory);
 *               selfcal_in_use(&cal, &used); load the rectifier with it
 *     for each stereo pair:
 *         selfcal_take_pair(&cal, matches, count, NULL);
 *         selfcal_verdict(&cal, &verdict);
 *         allow arming only if verdict.may_arm
 *         if (verdict.should_apply && selfcal_apply(&cal, &used) == SELFCAL_OK)
 *             load the rectifier with it
 *
 * SELFCAL_CAPACITY must match the library: if the library was built with the feature capacity-64, -128, -512 or
 * -1024, define SELFCAL_CAPACITY_64, _128, _512 or _1024. selfcal_init refuses storage that is too small.
 */


#ifndef STEREO_SELFCAL_H
#define STEREO_SELFCAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/* Version of this header; selfcal_version gives that of the library. */
#define SELFCAL_VERSION "0.1.0"

/* Version and sizes of the structs of this header, for selfcal_init. */
#define SELFCAL_HEADER \
    (1000u + 31u * (uint32_t)sizeof(selfcal_config_t) + 37u * (uint32_t)sizeof(selfcal_factory_t) + \
     41u * (uint32_t)sizeof(selfcal_correspondence_t) + 43u * (uint32_t)sizeof(selfcal_outcome_t) + \
     47u * (uint32_t)sizeof(selfcal_proposal_t) + 53u * (uint32_t)sizeof(selfcal_verdict_t) + \
     59u * (uint32_t)sizeof(selfcal_event_t) + 61u * (uint32_t)sizeof(selfcal_details_t) + \
     67u * (uint32_t)sizeof(selfcal_calibration_t))


#if defined(SELFCAL_CAPACITY_1024)
/**
 * Largest number of correspondences in a batch. A full batch keeps a selection.
 */
#define SELFCAL_CAPACITY 1024
#endif

#if (defined(SELFCAL_CAPACITY_512) && !defined(SELFCAL_CAPACITY_1024))
/**
 * Largest number of correspondences in a batch. A full batch keeps a selection.
 */
#define SELFCAL_CAPACITY 512
#endif

#if (defined(SELFCAL_CAPACITY_128) && !(defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024)))
/**
 * Largest number of correspondences in a batch. A full batch keeps a selection.
 */
#define SELFCAL_CAPACITY 128
#endif

#if (defined(SELFCAL_CAPACITY_64) && !(defined(SELFCAL_CAPACITY_128) || defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024)))
/**
 * Largest number of correspondences in a batch. A full batch keeps a selection.
 */
#define SELFCAL_CAPACITY 64
#endif

#if !(defined(SELFCAL_CAPACITY_64) || defined(SELFCAL_CAPACITY_128) || defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024))
/**
 * Largest number of correspondences in a batch. A full batch keeps a selection.
 */
#define SELFCAL_CAPACITY 256
#endif

/**
 * Size of `selfcal_t` in words of 8 bytes, sufficient on every target.
 */
#define SELFCAL_STORAGE_WORDS (644 + ((23 * SELFCAL_CAPACITY) / 8))

/**
 * Size of `selfcal_t`, bytes.
 */
#define SELFCAL_STORAGE_SIZE (8 * SELFCAL_STORAGE_WORDS)

/**
 * Alignment of `selfcal_t`, bytes, sufficient on every target.
 */
#define SELFCAL_STORAGE_ALIGN 8

/**
 * Length of a record of `selfcal_factory_to_record`, bytes.
 */
#define SELFCAL_FACTORY_BYTES 180

/**
 * Size of `selfcal_link_t` in words of 8 bytes, sufficient on every target.
 */
#define SELFCAL_LINK_STORAGE_WORDS 19

/**
 * Size of `selfcal_link_t`, bytes.
 */
#define SELFCAL_LINK_STORAGE_SIZE (8 * SELFCAL_LINK_STORAGE_WORDS)

/**
 * Length of the header of a frame, bytes.
 */
#define SELFCAL_FRAME_HEADER_BYTES 32

/**
 * Length of a match in a frame, bytes.
 */
#define SELFCAL_FRAME_MATCH_BYTES 16

/**
 * Length of the end of a frame, bytes.
 */
#define SELFCAL_FRAME_END_BYTES 4

/**
 * Flag of a header: frames were dropped right before this one because the receiver did not read.
 */
#define SELFCAL_FRAME_DROPPED_BEFORE 1

/**
 * Flag of a header: more matches were found than are sent.
 */
#define SELFCAL_FRAME_MORE_FOUND 2

/**
 * Size of `selfcal_encoder_t` in words of 8 bytes, sufficient on every target.
 */
#define SELFCAL_ENCODER_STORAGE_WORDS 10

/**
 * Size of `selfcal_encoder_t`, bytes.
 */
#define SELFCAL_ENCODER_STORAGE_SIZE (8 * SELFCAL_ENCODER_STORAGE_WORDS)

/**
 * Length of a record of `selfcal_snapshot`, bytes, for any capacity.
 */
#define SELFCAL_SNAPSHOT_BYTES 400

/**
 * Size of `selfcal_tracks_t` in words of 8 bytes, sufficient on every target.
 */
#define SELFCAL_TRACKS_STORAGE_WORDS (11 + ((66 * SELFCAL_CAPACITY) / 8))

/**
 * Size of `selfcal_tracks_t`, bytes.
 */
#define SELFCAL_TRACKS_STORAGE_SIZE (8 * SELFCAL_TRACKS_STORAGE_WORDS)

/**
 * Size of `selfcal_paper_t` in words of 8 bytes, sufficient on every target.
 */
#define SELFCAL_PAPER_WORDS (260 + ((23 * SELFCAL_CAPACITY) / 8))

/**
 * Result of a call. An error that several functions return has the same number in all of them. Numbers from 100 on
 * equal the error codes of the core.
 */
enum selfcal_error_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * no error
     */
    SELFCAL_OK = 0,
    /**
     * a pointer is null
     */
    SELFCAL_ERROR_NULL = 1,
    /**
     * a pointer is not aligned for its type
     */
    SELFCAL_ERROR_ALIGNMENT = 2,
    /**
     * the storage is too small; compare the capacities of header and library
     */
    SELFCAL_ERROR_STORAGE_SIZE = 3,
    /**
     * the storage is not initialised, its name or a length is overwritten, or it belongs to another build
     */
    SELFCAL_ERROR_NOT_INITIALISED = 4,
    /**
     * an argument is out of its range
     */
    SELFCAL_ERROR_VALUE = 5,
    /**
     * a parameter of the configuration is out of its range; selfcal_argument_string names it
     */
    SELFCAL_ERROR_CONFIG = 6,
    /**
     * a camera or the extrinsics are not valid; selfcal_argument_string names the quantity
     */
    SELFCAL_ERROR_FACTORY = 7,
    /**
     * the header is of another version than the library, or compiled to structs of other sizes
     */
    SELFCAL_ERROR_HEADER = 8,
    /**
     * the core returned an error that this API does not know
     */
    SELFCAL_ERROR_UNKNOWN = 99,
    /**
     * a pixel or a ray is not finite
     */
    SELFCAL_ERROR_NOT_FINITE = 120,
    /**
     * a pixel is outside the image by more than half a pixel
     */
    SELFCAL_ERROR_OUTSIDE_IMAGE = 121,
    /**
     * the lens model is not one to one at the pixel, or the ray is over 85 degrees off axis
     */
    SELFCAL_ERROR_NOT_INVERTIBLE = 122,
    /**
     * the lens model is not one to one at the ray
     */
    SELFCAL_ERROR_BEYOND_LENS = 123,
    /**
     * a pair is being solved; finish or discard it first
     */
    SELFCAL_ERROR_BUSY = 401,
    /**
     * the score is not within 0 to 1
     */
    SELFCAL_ERROR_SCORE = 402,
    /**
     * the grid step is not within 0 to 255.99 px
     */
    SELFCAL_ERROR_GRID_STEP = 403,
    /**
     * fewer usable correspondences than configured; collect more
     */
    SELFCAL_ERROR_TOO_FEW = 502,
    /**
     * the correspondences agree on no extrinsics; all may be outliers
     */
    SELFCAL_ERROR_NO_CONSENSUS = 503,
    /**
     * a direction is not observable; correspondences all alike, on a line, or at infinity
     */
    SELFCAL_ERROR_UNOBSERVABLE = 504,
    /**
     * points behind the cameras; left and right exchanged, wrong sign of t, an image mirrored or both upside down
     */
    SELFCAL_ERROR_BEHIND = 506,
    /**
     * disparities run along the columns; u and v exchanged, cameras one above the other, or a wrong t
     */
    SELFCAL_ERROR_COLUMNS = 507,
    /**
     * no depth; all disparities are alike, as with the same image on both sides
     */
    SELFCAL_ERROR_NO_DEPTH = 508,
    /**
     * rows not measured; the matcher searches along rows
     */
    SELFCAL_ERROR_ROWS_NOT_MEASURED = 509,
    /**
     * the standard deviation of the weakest direction of the pair is too large
     */
    SELFCAL_ERROR_TOO_UNCERTAIN = 600,
    /**
     * the distance from the factory extrinsics exceeds the correction limit
     */
    SELFCAL_ERROR_CORRECTION_LIMIT = 601,
    /**
     * the estimate with this pair cannot be rectified
     */
    SELFCAL_ERROR_NO_RIG = 602,
    /**
     * the pair disagrees with the estimate and with the challenger
     */
    SELFCAL_ERROR_DISAGREES = 603,
    /**
     * the calibrator is frozen
     */
    SELFCAL_ERROR_FROZEN = 605,
    /**
     * no pair has been fused
     */
    SELFCAL_ERROR_NO_ESTIMATE = 700,
    /**
     * the fused pairs agree on no extrinsics
     */
    SELFCAL_ERROR_INCONSISTENT = 701,
    /**
     * the estimate is not locked; read selfcal_state
     */
    SELFCAL_ERROR_NOT_LOCKED = 702,
    /**
     * a second crowd of matches, or image halves that disagree; read the verdict
     */
    SELFCAL_ERROR_DOUBTFUL = 703,
    /**
     * nothing has been applied since the last reset or undo
     */
    SELFCAL_ERROR_NOTHING_TO_UNDO = 705,
    /**
     * alpha is not within 0 to 1
     */
    SELFCAL_ERROR_ALPHA = 800,
    /**
     * the rectified views share no rectangle, or are not upright
     */
    SELFCAL_ERROR_NO_COMMON_VIEW = 801,
    /**
     * an image border is behind the rectified plane; the rotation is too large
     */
    SELFCAL_ERROR_BEHIND_PLANE = 802,
    /**
     * a point on an image border has no ray; check the lens model
     */
    SELFCAL_ERROR_BORDER = 803,
    /**
     * the record is damaged
     */
    SELFCAL_ERROR_RECORD_DAMAGED = 1000,
    /**
     * the record is of another kind
     */
    SELFCAL_ERROR_RECORD_FOREIGN = 1001,
    /**
     * the record has the layout of another firmware
     */
    SELFCAL_ERROR_RECORD_LAYOUT = 1002,
    /**
     * the record is of other cameras or other factory extrinsics
     */
    SELFCAL_ERROR_RECORD_OTHER_RIG = 1003,
    /**
     * a number of the record is out of its range; another program wrote it
     */
    SELFCAL_ERROR_RECORD_ABSURD = 1004,
    /**
     * the record is beyond the correction limit, or of corrected cameras where the configuration only reports
     */
    SELFCAL_ERROR_RECORD_CONFIG = 1005,
    /**
     * frame refused, the image sizes of matcher and cameras differ; feed on
     */
    SELFCAL_ERROR_IMAGE_SIZE = 1102,
    /**
     * frame header with an unknown flag, fraction bits beyond 8, or a pyramid ratio below 64/64
     */
    SELFCAL_ERROR_FRAME_HEADER = 1113,
    /**
     * a coordinate is not finite, or not within the 24 bits of a record; drop the match
     */
    SELFCAL_ERROR_FRAME_COORDINATE = 1120,
    /**
     * no level of the pyramid of the header has this grid step
     */
    SELFCAL_ERROR_FRAME_GRID_STEP = 1122,
    /**
     * the frame has as many matches as its header counts; end it
     */
    SELFCAL_ERROR_FRAME_FULL = 1123,
    /**
     * the frame has fewer matches than its header counts
     */
    SELFCAL_ERROR_FRAME_MISSING = 1124,
    /**
     * the length of the baseline is not known; set baseline_m of the factory calibration
     */
    SELFCAL_ERROR_NO_BASELINE = 1200,
    /**
     * range or deviation is out of the range of a sensor
     */
    SELFCAL_ERROR_READING = 1202,
    /**
     * no match in the batch fits the estimate; for a range, none near its pixel
     */
    SELFCAL_ERROR_NO_MATCH = 1203,
    /**
     * the witness contradicts mount and lens
     */
    SELFCAL_ERROR_CONTRADICTS = 1204,
    /**
     * no motion that tells yaw
     */
    SELFCAL_ERROR_NO_MOTION = 1222,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_error_t selfcal_error_t;
#else
typedef uint32_t selfcal_error_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Effect of a valid correspondence on the batch.
 */
enum selfcal_pushed_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * kept
     *
     * The batch had room for it.
     */
    SELFCAL_PUSHED_KEPT = 10000,
    /**
     * replaced another one
     *
     * It replaces another correspondence in the full batch.
     */
    SELFCAL_PUSHED_REPLACED = 10001,
    /**
     * left out
     *
     * The full batch keeps other correspondences instead.
     */
    SELFCAL_PUSHED_LEFT_OUT = 10002,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_PUSHED_UNKNOWN = 10255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_pushed_t selfcal_pushed_t;
#else
typedef uint32_t selfcal_pushed_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Effect of a pair on the estimate.
 */
enum selfcal_fused_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * added
     *
     * The pair is part of the estimate.
     */
    SELFCAL_FUSED_ADDED = 12000,
    /**
     * same scene again
     *
     * The scene has hardly moved since the last pair that was added, and the pair adds nothing.
     */
    SELFCAL_FUSED_REPEATED = 12001,
    /**
     * kept apart
     *
     * The pair disagrees with the estimate, and is part of the challenger. A challenger that three pairs confirm
     * ends with this pair if its extrinsics agree with the estimate after all.
     */
    SELFCAL_FUSED_KEPT_APART = 12002,
    /**
     * added, older pairs dropped
     *
     * The pair is part of the estimate, and the last pairs have replaced the older ones: the rig has drifted, or
     * has moved by less than a single pair shows.
     */
    SELFCAL_FUSED_RENEWED = 12003,
    /**
     * challenger promoted
     *
     * The challenger, with this pair, has become the estimate.
     */
    SELFCAL_FUSED_TOOK_OVER = 12004,
    /**
     * lens corrected, estimate begins again
     *
     * The pairs show another lens model of the right camera: the estimate begins again with corrected cameras
     * (`SELFCAL_LENS_TRACKING_COMPENSATE`). The batch is emptied, and there are neither a proposal nor details until
     * the next pair is fused.
     */
    SELFCAL_FUSED_LENS_CORRECTED = 12005,
    /**
     * not fused
     *
     * The pair is not part of the estimate; the error of the call says why.
     */
    SELFCAL_FUSED_NOT = 12254,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_FUSED_UNKNOWN = 12255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_fused_t selfcal_fused_t;
#else
typedef uint32_t selfcal_fused_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Why the solver stopped.
 */
enum selfcal_stop_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * converged
     *
     * The step fell below the tolerance, or below the resolution of `f32` at the optimum.
     */
    SELFCAL_STOP_CONVERGED = 11000,
    /**
     * no descent
     *
     * No step lowers the cost, so this is the optimum within the resolution of `f32`; or the normal equations have
     * no solution.
     */
    SELFCAL_STOP_NO_DESCENT = 11001,
    /**
     * passes spent
     *
     * All passes were taken. This is normal for a pair that was tracked from an estimate. A search that stops this
     * way has not converged; its result is the best pose reached.
     */
    SELFCAL_STOP_PASSES_SPENT = 11002,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_STOP_UNKNOWN = 11255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_stop_t selfcal_stop_t;
#else
typedef uint32_t selfcal_stop_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Reliability of the estimate.
 */
enum selfcal_state_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * acquiring
     *
     * Too few pairs agree yet.
     */
    SELFCAL_STATE_ACQUIRING = 13000,
    /**
     * locked
     *
     * The last pair agrees with the estimate, and `R` is certain. `t` may still be the start value; see
     * `baseline_observed`.
     */
    SELFCAL_STATE_LOCKED = 13001,
    /**
     * suspect
     *
     * The last pair that was compared with the estimate disagrees, a challenger gathers pairs, or no pair has
     * supported a restored estimate yet.
     */
    SELFCAL_STATE_SUSPECT = 13002,
    /**
     * lost
     *
     * At least ten pairs in a row disagree with the estimate, and no three of them agree well enough with each
     * other.
     */
    SELFCAL_STATE_LOST = 13003,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_STATE_UNKNOWN = 13255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_state_t selfcal_state_t;
#else
typedef uint32_t selfcal_state_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * One of the five unknowns, in the rectified frame (x along the baseline, z forward).
 */
enum selfcal_direction_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * pitch
     *
     * Rotation of `R` about x: shifts all rows alike.
     */
    SELFCAL_DIRECTION_PITCH = 15001,
    /**
     * yaw
     *
     * Rotation of `R` about y: moves rows by the product of column and row.
     */
    SELFCAL_DIRECTION_YAW = 15002,
    /**
     * roll
     *
     * Rotation of `R` about z: tilts rows.
     */
    SELFCAL_DIRECTION_ROLL = 15003,
    /**
     * baseline forward
     *
     * Rotation of the baseline about y: `t_z`.
     */
    SELFCAL_DIRECTION_BASELINE_FORWARD = 15004,
    /**
     * baseline down
     *
     * Rotation of the baseline about z: `t_y`.
     */
    SELFCAL_DIRECTION_BASELINE_DOWN = 15005,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_DIRECTION_UNKNOWN = 15255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_direction_t selfcal_direction_t;
#else
typedef uint32_t selfcal_direction_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A mistake that keeps pairs from agreeing, or their matches from supporting a calibration.
 */
enum selfcal_cause_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * none
     *
     * No mistake is known.
     */
    SELFCAL_CAUSE_NONE = 18000,
    /**
     * left and right exchanged, t of the other sign, one image mirrored, or both upside down
     *
     * The points are behind the cameras.
     */
    SELFCAL_CAUSE_REVERSED = 18001,
    /**
     * cameras one above the other, or t of the factory extrinsics turned
     *
     * Disparities run along the columns, and nothing shows that u and v are exchanged.
     */
    SELFCAL_CAUSE_UPRIGHT = 18002,
    /**
     * u and v exchanged
     *
     * Disparities run along the columns, some pixels were refused, and all accepted matches are within the square
     * that an image and its transpose have in common.
     */
    SELFCAL_CAUSE_TRANSPOSED = 18003,
    /**
     * the same image on both sides
     *
     * Most matches have the same motion between the images, and nothing shows depth.
     */
    SELFCAL_CAUSE_SAME_IMAGE = 18004,
    /**
     * cameras of smaller images, or pixels from another origin than the upper left
     *
     * Most matches are refused, usually because a pixel is outside the images of the cameras.
     */
    SELFCAL_CAUSE_SMALLER_IMAGES = 18005,
    /**
     * cameras of larger images, or matches in one quarter of the image only
     *
     * The matches of all pairs fill the upper left quarter of the left image and nothing else.
     */
    SELFCAL_CAUSE_LARGER_IMAGES = 18006,
    /**
     * focal length or lens of another unit or image, such as mm
     *
     * Most matches are refused, usually because a pixel has no ray.
     */
    SELFCAL_CAUSE_FOCAL_LENGTH = 18007,
    /**
     * another lens, or points that are undistorted already
     *
     * Pairs show an error of the lens models that is too large for any calibration.
     */
    SELFCAL_CAUSE_LENS = 18008,
    /**
     * matches that agree on nothing
     *
     * No other cause explains the pairs without agreement.
     */
    SELFCAL_CAUSE_MISMATCHES = 18009,
    /**
     * rows not measured: the matcher searches along rows
     *
     * Nearly all rows of left and right are equal.
     */
    SELFCAL_CAUSE_ROWS_NOT_MEASURED = 18010,
    /**
     * left and right of different moments, a moving mount, or a rolling shutter
     *
     * Pairs fit well alone, and not each other.
     */
    SELFCAL_CAUSE_MOMENTS = 18011,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_CAUSE_UNKNOWN = 18255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_cause_t selfcal_cause_t;
#else
typedef uint32_t selfcal_cause_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Effect of a valid reading on the estimate.
 */
enum selfcal_witnessed_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * taken
     *
     * The reading is part of the estimate.
     */
    SELFCAL_WITNESSED_TAKEN = 19000,
    /**
     * waiting for others that agree
     *
     * The reading contradicts the present yaw, and waits for further readings that agree with it.
     */
    SELFCAL_WITNESSED_WAITING = 19001,
    /**
     * unknown
     *
     * A value that this API does not know.
     */
    SELFCAL_WITNESSED_UNKNOWN = 19255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_witnessed_t selfcal_witnessed_t;
#else
typedef uint32_t selfcal_witnessed_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Central value of the rotation angles of the pairs.
 */
enum selfcal_angle_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Arithmetic mean: efficient without outlier pairs.
     */
    SELFCAL_ANGLE_MEAN = 0,
    /**
     * Median: robust to a minority of outlier pairs.
     */
    SELFCAL_ANGLE_MEDIAN = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_angle_t selfcal_angle_t;
#else
typedef uint32_t selfcal_angle_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Part of a calibrator's answers that an event reports as changed: a bit of `changes`.
 */
enum selfcal_change_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The state of the estimate.
     */
    SELFCAL_CHANGE_STATE = 1,
    /**
     * The answer to an arming check.
     */
    SELFCAL_CHANGE_ARMING = 2,
    /**
     * Whether `selfcal_apply` is worthwhile.
     */
    SELFCAL_CHANGE_APPLYING = 4,
    /**
     * The reasons not to rely on the calibration in use.
     */
    SELFCAL_CHANGE_REASONS = 8,
    /**
     * The likeliest mistake in rig file or matcher.
     */
    SELFCAL_CHANGE_CAUSE = 16,
    /**
     * The calibration in use.
     */
    SELFCAL_CHANGE_GENERATION = 32,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_change_t selfcal_change_t;
#else
typedef uint32_t selfcal_change_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Treatment of errors of the given lens models.
 */
enum selfcal_lens_tracking_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Errors are estimated and reported, and they increase the reported deviations that include the lens. The
     * extrinsics belong to the given lens models.
     */
    SELFCAL_LENS_TRACKING_REPORT = 0,
    /**
     * Differences of focal length and of `k1` are compensated, if that halves the standard deviation of `t`; see
     * `SELFCAL_FUSED_LENS_CORRECTED`. This is for callers that rectify with the cameras of the calibration in use, as
     * the functions of this API do.
     */
    SELFCAL_LENS_TRACKING_COMPENSATE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_lens_tracking_t selfcal_lens_tracking_t;
#else
typedef uint32_t selfcal_lens_tracking_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Lens models, with OpenCV's coefficients.
 */
enum selfcal_lens_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * No distortion.
     */
    SELFCAL_LENS_PINHOLE = 0,
    /**
     * Brown's model, `cv::undistortPoints` with k1 k2 p1 p2 k3.
     */
    SELFCAL_LENS_RADIAL_TANGENTIAL = 1,
    /**
     * Kannala-Brandt equidistant, `cv::fisheye` with k1 k2 k3 k4.
     */
    SELFCAL_LENS_FISHEYE = 2,
    /**
     * Rational model, `cv::undistortPoints` with k1 k2 p1 p2 k3 k4 k5 k6.
     */
    SELFCAL_LENS_RATIONAL = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_lens_t selfcal_lens_t;
#else
typedef uint32_t selfcal_lens_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * One reason not to rely on a calibration: a bit of `reasons`.
 */
enum selfcal_reason_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * estimate not locked
     *
     * The state is not locked: the estimate is not confirmed, the last pair disagrees with it, or a challenger
     * gathers pairs. Forbids arming, except in the state suspect.
     */
    SELFCAL_REASON_NOT_LOCKED = 65536,
    /**
     * second crowd of matches
     *
     * Matches with residuals on one side of the inliers are nearly as many as the inliers, and may agree with a
     * second calibration, for instance because of a fence or a reflection. Forbids arming, and nothing is applied
     * until the view has changed.
     */
    SELFCAL_REASON_SECOND_MODE = 262144,
    /**
     * matches biased
     *
     * Image halves disagree by more than 5 standard deviations, and the lens models are taken as exact: the
     * matches of an image region share a bias. Forbids arming, and nothing is applied.
     */
    SELFCAL_REASON_BIASED = 33554432,
    /**
     * matches do not support it
     *
     * The matches or the estimate show a mistake in rig file or matcher, which `cause` names. Forbids arming.
     */
    SELFCAL_REASON_UNFIT = 16777216,
    /**
     * in use not confirmed by the last pairs
     *
     * The calibration in use has not fitted two pairs in a row, or two pairs in a row have missed it since, or no
     * pair could be solved for ten pairs. Forbids arming.
     */
    SELFCAL_REASON_EVIDENCE = 8388608,
    /**
     * depth in use uncertain
     *
     * `depth_px` is above its limit. Forbids arming.
     */
    SELFCAL_REASON_DEPTH = 134217728,
    /**
     * rows in use off
     *
     * `rows_px` is above its limit. One such pair alone does not disarm.
     */
    SELFCAL_REASON_ROWS = 131072,
    /**
     * matches do not cover image or calibration in use
     *
     * `coverage` is below its limit, or the matches cover less than a seventh of the image. One such pair alone does
     * not disarm.
     */
    SELFCAL_REASON_COVERAGE = 67108864,
    /**
     * image halves disagree
     *
     * Image halves disagree by more than 3 standard deviations; the reported deviations include this disagreement.
     */
    SELFCAL_REASON_IMAGE_HALVES = 524288,
    /**
     * lens models off
     *
     * The pairs show an error of the lens models or an apparent yaw of the lenses; `sd_lens` of the proposal
     * includes it.
     */
    SELFCAL_REASON_LENS = 1048576,
    /**
     * baseline not observed
     *
     * The pairs have not determined the baseline direction: as a rule the baseline in use is kept; see
     * `applicable` of the proposal.
     */
    SELFCAL_REASON_BASELINE = 2097152,
    /**
     * repeated scene
     *
     * The scene has hardly moved since the last pair that was added, and the pair adds no evidence.
     */
    SELFCAL_REASON_REPEATED = 4194304,
    /**
     * yaw not confirmed
     *
     * The standard deviation of the apparent yaw of the lens is above 0.1 degrees: neither the factory calibration
     * nor witnesses separate it well enough from the yaw of the mount. The deviations of yaw and depth include
     * both.
     */
    SELFCAL_REASON_YAW = 268435456,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_reason_t selfcal_reason_t;
#else
typedef uint32_t selfcal_reason_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * One of the two cameras.
 */
enum selfcal_side_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Left: its frame is the frame of the rig, `p_r = R p_l + t`.
     */
    SELFCAL_SIDE_LEFT = 0,
    /**
     * Right.
     */
    SELFCAL_SIDE_RIGHT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_side_t selfcal_side_t;
#else
typedef uint32_t selfcal_side_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Calibration to rectify with: extrinsics, and the cameras that they belong to.
 */
enum selfcal_source_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The calibration in use.
     */
    SELFCAL_SOURCE_IN_USE = 0,
    /**
     * The estimate, `extrinsics` of the proposal.
     */
    SELFCAL_SOURCE_PROPOSED = 1,
    /**
     * The calibration that `selfcal_apply` would put into use.
     */
    SELFCAL_SOURCE_APPLICABLE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_source_t selfcal_source_t;
#else
typedef uint32_t selfcal_source_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A calibrator of one stereo rig, owned by the caller, in static memory or elsewhere. It holds no
 * pointers and needs no release. One call at a time; calibrators are independent.
 *
 * Each call detects two kinds of overwritten storage: changed first 12 bytes (name and size), and a length beyond its
 * array. Then it does nothing, and returns `SELFCAL_ERROR_NOT_INITIALISED`. Other wrong bits are not detected, and the
 * effect of a call is then undefined: protect the memory, or call `selfcal_init` again.
 */
typedef struct selfcal_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_STORAGE_WORDS];
} selfcal_t;

/**
 * Standard deviations of the errors of the given lens models; 0 takes a parameter as exact. `focal`, `principal_px`
 * and `k1` apply to each camera; each of the other fields says what it applies to. Without a given lens prior the
 * values are, in the order of the fields, 0.003, 1 px, 0.005, 0.001, 0.00025 and 0.0046 rad.
 */
typedef struct selfcal_lens_prior_t {
    /**
     * Focal length, relative.
     */
    float focal;
    /**
     * Principal point, each coordinate, px.
     */
    float principal_px;
    /**
     * Radial coefficient `k1`.
     */
    float k1;
    /**
     * Tangential coefficient `p1` of the right camera minus the one of the left camera.
     */
    float p1;
    /**
     * Tangential coefficient `p2` of the right camera.
     */
    float p2;
    /**
     * Apparent yaw `a` of the lenses, rad: it shifts rows by `a x y` at unit depth.
     */
    float yaw_rad;
} selfcal_lens_prior_t;

/**
 * Parameters of a calibrator. 0 in a field stands for its default: `selfcal_config_t config = {0}` is the default
 * configuration, and `{.memory_pairs = 300}` changes one parameter. `selfcal_init` checks all fields.
 */
typedef struct selfcal_config_t {
    /**
     * Largest number of passes over the batch that a pair may take, which bounds its time: 2 or more; default 24. A
     * pair takes up to 9 passes even if the limit is lower. With a limit below 20 it does not test before the first lock
     * whether a turned baseline fits better.
     */
    uint16_t max_passes;
    /**
     * Least number of usable correspondences that a pair needs: 6 or more; default 12.
     */
    uint16_t min_correspondences;
    /**
     * Number `n` of fused pairs after which each further pair multiplies the weight of the older pairs by `1 - 1 / n`:
     * 20 or more; default 1000. A larger number averages longer; a smaller one follows a slow drift.
     */
    uint32_t memory_pairs;
    /**
     * Correction limit, rad: above 0 and below 1.5; default 0.5. A pair is not fused if `R` or `t` of the estimate
     * with the pair differs from the factory value by a larger angle.
     */
    float max_correction_rad;
    /**
     * Standard deviation of the factory extrinsics about each axis, rad: 1e-4 to 1; default 0.1. A larger value
     * follows a rig that is further off; a smaller one stabilises pairs with little information.
     */
    float prior_sd_rad;
    /**
     * Lower bound of the estimated noise of a coordinate, px: 0.001 to 100; default 0.15. The bound keeps the
     * information finite on data without noise.
     */
    float noise_floor_px;
    /**
     * Limit of row offsets, px: finite and above 0; default 3. A match fits a calibration if its row offset is within
     * the limit, or within 4.2 times the noise of a coordinate if that is more.
     */
    float fit_limit_px;
    /**
     * Largest row offset in use at which a rig may arm, px: above 0, or infinite; default 1.
     */
    float rows_limit_px;
    /**
     * Largest expected error of disparity at which a rig may arm, px: above 0, or infinite for a rig that uses no metric
     * depth, such as one that started from a guess; default 2.
     */
    float depth_limit_px;
    /**
     * Least share of the matches that fit the pair's own pose that must fit the calibration in use: up to 1; default
     * 0.7.
     */
    float coverage_limit;
    /**
     * A `selfcal_lens_tracking_t`, which acts only with a lens prior.
     */
    uint32_t lens_tracking;
    /**
     * 1 if `lens_prior` replaces the default deviations of the lens models, otherwise 0.
     */
    uint32_t has_lens_prior;
    /**
     * Standard deviations of the given lens models, which `sd_lens` of the proposal covers. All 0 take the lens models
     * as exact; disagreeing image halves then forbid to apply the estimate (`SELFCAL_REASON_BIASED`).
     */
    struct selfcal_lens_prior_t lens_prior;
} selfcal_config_t;

/**
 * A calibrated camera.
 */
typedef struct selfcal_camera_t {
    /**
     * Focal lengths fx, fy, px; 1 to 1e6.
     */
    float focal_px[2];
    /**
     * Principal point cx, cy, px; (0, 0) is the centre of the top left pixel.
     */
    float principal_px[2];
    /**
     * Image width, height, px.
     */
    uint16_t size_px[2];
    /**
     * A `selfcal_lens_t`.
     */
    uint32_t lens;
    /**
     * Lens coefficients in OpenCV's order, dimensionless. Coefficients that the model does not use must be 0.
     */
    float distortion[8];
} selfcal_camera_t;

/**
 * `R` and unit `t` of `p_r = R p_l + t`. A plain side-by-side rig has `R = I`, `t = (-1, 0, 0)`.
 */
typedef struct selfcal_extrinsics_t {
    /**
     * `R`, left to right camera frame, row by row.
     */
    float rotation[9];
    /**
     * `t`: position of the left camera in the right camera frame. As a result it has unit length; as an argument it
     * may have any length.
     */
    float translation[3];
} selfcal_extrinsics_t;

/**
 * Cameras and extrinsics of a rig as it left the factory, and the uncertainty of its calibration.
 * `{.left = left, .right = right}` is a guess: two cameras side by side.
 */
typedef struct selfcal_factory_t {
    /**
     * Left camera.
     */
    struct selfcal_camera_t left;
    /**
     * Right camera.
     */
    struct selfcal_camera_t right;
    /**
     * Extrinsics of a calibration: `R` orthonormal to about 0.1, `t` of any length. All 0 stand for a guess: cameras
     * side by side. The prior and the correction limit refer to these extrinsics, and `selfcal_reset` returns to them.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * 1 if the extrinsics are a guess: the estimate then does not keep their yaw, and follows the yaw that the rows
     * show. Otherwise 0.
     */
    uint32_t is_guess;
    /**
     * Standard deviation of the yaw of the extrinsics, rad, 1e-6 to 1. Depth relies on this yaw and on the turns since.
     * 0 stands for 8.7e-4 (0.05 degrees), the standard deviation of a calibration with boards. Not used for a guess.
     */
    float yaw_sd_rad;
    /**
     * Length of the baseline, m, 1e-3 to 1e3; 0 if it is not known. `selfcal_push_range` needs it.
     */
    float baseline_m;
} selfcal_factory_t;

/**
 * Storage that the library needs.
 */
typedef struct selfcal_requirements_t {
    /**
     * Size, bytes; at most `sizeof(selfcal_t)`.
     */
    size_t size;
    /**
     * Alignment, bytes.
     */
    size_t align;
    /**
     * Largest number of correspondences of a pair.
     */
    size_t capacity;
} selfcal_requirements_t;

/**
 * Extrinsics and the cameras that they belong to. With other cameras the extrinsics are wrong.
 */
typedef struct selfcal_calibration_t {
    /**
     * Left camera, as given.
     */
    struct selfcal_camera_t left;
    /**
     * Right camera, as given; with `SELFCAL_LENS_TRACKING_COMPENSATE` it may be corrected.
     */
    struct selfcal_camera_t right;
    /**
     * `p_r = R p_l + t`.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * Number that changes whenever the calibration in use changes; it wraps around. A restored record may change the
     * number alone.
     */
    uint32_t generation;
} selfcal_calibration_t;

/**
 * One left/right correspondence in the raw images, before undistortion.
 */
typedef struct selfcal_correspondence_t {
    /**
     * Column u, row v in the left image, px.
     */
    float left_px[2];
    /**
     * Column u, row v in the right image, px.
     */
    float right_px[2];
    /**
     * Confidence of the matcher, 0 (none) to 1 (certain).
     */
    float score;
    /**
     * Step of the grid on which the matcher finds coordinates, px, 0 to 255.99: 1 for whole pixels, 0 for continuous
     * coordinates.
     */
    float grid_step_px;
} selfcal_correspondence_t;

/**
 * Effect of an array of correspondences on the batch.
 */
typedef struct selfcal_pushed_counts_t {
    /**
     * Number of correspondences that the batch had room for.
     */
    size_t kept;
    /**
     * Number of correspondences that replaced another one.
     */
    size_t replaced;
    /**
     * Number of valid correspondences that the full batch did not take.
     */
    size_t left_out;
    /**
     * Number of correspondences that were refused, because they are not valid.
     */
    size_t refused;
    /**
     * Why the first refused correspondence was refused; `SELFCAL_OK` without a refusal.
     */
    selfcal_error_t first_refusal;
} selfcal_pushed_counts_t;

/**
 * Counts of the batch.
 */
typedef struct selfcal_batch_t {
    /**
     * Number of correspondences in the batch.
     */
    uint32_t held;
    /**
     * Number of correspondences offered to this batch: held, left out or refused.
     */
    uint32_t offered;
    /**
     * Number of valid correspondences that the full batch does not hold.
     */
    uint32_t left_out;
    /**
     * Number of refused correspondences.
     */
    uint32_t refused;
} selfcal_batch_t;

/**
 * Decoder that finds the frames of a matcher in the bytes of a driver. The caller owns the storage, as with
 * `selfcal_t`. It holds its position in a frame, but no frame. Each wire needs its own.
 */
typedef struct selfcal_link_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_LINK_STORAGE_WORDS];
} selfcal_link_t;

/**
 * A whole frame. All fields are 0 if no frame is whole.
 */
typedef struct selfcal_frame_t {
    /**
     * Time of exposure on the clock of the matcher, us; 0 without a clock. Not interpreted.
     */
    uint64_t timestamp_us;
    /**
     * Sequence number of the frame; it wraps around.
     */
    uint32_t sequence;
    /**
     * Number of matches in the frame.
     */
    uint32_t count;
    /**
     * Number of these matches in the batch. The batch refuses matches that are not valid, and a full batch selects;
     * see `selfcal_batch`.
     */
    uint32_t taken;
    /**
     * Whether a frame is whole. Then its matches are the batch: solve it before the next feed.
     */
    bool whole;
    /**
     * The matcher dropped unread frames right before this one.
     */
    bool dropped_before;
    /**
     * The matcher found more matches than it sent.
     */
    bool more_found;
    /**
     * Always 0.
     */
    uint8_t reserved;
} selfcal_frame_t;

/**
 * Counters of a link since `selfcal_link_init`. They saturate.
 */
typedef struct selfcal_link_counters_t {
    /**
     * Whole frames returned.
     */
    uint32_t good;
    /**
     * Frames with a wrong CRC: bytes are being damaged or lost. Check the wiring and the clock of the bus.
     */
    uint32_t bad_crc;
    /**
     * Places where the magic is found, but the header has a wrong CRC.
     */
    uint32_t bad_header;
    /**
     * Headers with a correct CRC whose content is not valid in version 1 of the format: correct the sender.
     */
    uint32_t unsupported;
    /**
     * Frames missing between the sequence numbers of the whole frames.
     */
    uint32_t gaps;
    /**
     * Whole frames with the sequence number of the last whole frame before; they are not returned.
     */
    uint32_t repeats;
    /**
     * Backward steps of the sequence number: the sender restarted.
     */
    uint32_t restarts;
    /**
     * Whole frames before which the sender dropped some, and calls of `selfcal_link_note_overrun`.
     */
    uint32_t overruns;
    /**
     * Refused frames: their image size differs from the image size of the left camera.
     */
    uint32_t refused;
    /**
     * Bytes skipped in search of a frame.
     */
    uint32_t skipped_bytes;
} selfcal_link_counters_t;

/**
 * Header of a frame to be sent; core/src/link/FORMAT.md defines the fields.
 */
typedef struct selfcal_frame_header_t {
    /**
     * Time of exposure on the clock of the sender, us; 0 without a clock.
     */
    uint64_t timestamp_us;
    /**
     * Sequence number of the frame; it increases by 1 for each stereo pair, sent or not, and wraps around.
     */
    uint32_t sequence;
    /**
     * Width and height of the left image, px; the right image may have another size.
     */
    uint16_t size_px[2];
    /**
     * Number of matches in the frame.
     */
    uint16_t count;
    /**
     * Grid step of pyramid level 0, 1/256 px; 0 stands for the coordinate step, `2^-fraction_bits` px.
     */
    uint16_t grid_step;
    /**
     * Fraction bits of the coordinates, 0 to 8.
     */
    uint8_t fraction_bits;
    /**
     * Pixel size of a pyramid level over the pixel size of the level below, in 1/64: 64 to 255; 64 without a pyramid.
     */
    uint8_t pyramid_ratio;
    /**
     * Sum of `SELFCAL_FRAME_DROPPED_BEFORE` and `SELFCAL_FRAME_MORE_FOUND`, as far as they hold.
     */
    uint8_t flags;
    /**
     * Ignored.
     */
    uint8_t reserved;
} selfcal_frame_header_t;

/**
 * Encoder of one frame, for a matcher in software. The caller owns the encoder. It stores no
 * matches: each call returns the bytes of one match.
 */
typedef struct selfcal_encoder_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_ENCODER_STORAGE_WORDS];
} selfcal_encoder_t;

/**
 * Result of one pair: the rig at its moment. A rig that bends all the time has no estimate over many pairs, and each
 * image pair is rectified with the extrinsics of its own report.
 */
typedef struct selfcal_report_t {
    /**
     * `R`, `t` of the pair alone.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * Information matrix, 1/rad^2, symmetric. Order: rotation of `R` about x, y, z, rotation of the
     * baseline about y, z, in the rectified frame.
     */
    float information[5][5];
    /**
     * Why the solver stopped.
     */
    selfcal_stop_t stop;
    /**
     * Passes taken over the batch. The published method does not count the evaluation pass.
     */
    uint16_t passes;
    /**
     * Number of correspondences in front of both rectified cameras.
     */
    uint32_t usable;
    /**
     * Number of correspondences that are left out, because they are not in front of both rectified cameras.
     */
    uint32_t skipped;
    /**
     * Number of usable correspondences that fit the solution and are in front of both cameras at the start.
     */
    uint32_t screened;
    /**
     * Cost at the start, computed with the loss of the solution, px^2.
     */
    float cost_before;
    /**
     * Cost at the solution, px^2.
     */
    float cost_after;
    /**
     * RMS row offset of the screened correspondences at the start, px; 0 without any.
     */
    float rms_px_before;
    /**
     * RMS row offset of the same correspondences at the solution, px.
     */
    float rms_px_after;
    /**
     * Estimated noise, standard deviation, px: of a coordinate; in the published method of a row offset.
     */
    float noise_px;
} selfcal_report_t;

/**
 * Outcome of one pair.
 */
typedef struct selfcal_outcome_t {
    /**
     * Effect on the estimate; `SELFCAL_FUSED_NOT` with an error.
     */
    selfcal_fused_t fused;
    /**
     * Whether the pair was solved. Then `pair` is valid, even if the pair was not fused.
     */
    bool has_pair;
    /**
     * Result of the pair alone. If it is not valid, its numbers are 0, and `stop` is `SELFCAL_STOP_UNKNOWN`.
     */
    struct selfcal_report_t pair;
} selfcal_outcome_t;

/**
 * Correction that is added to the given lens model of the right camera; 0 leaves it as given.
 */
typedef struct selfcal_lens_correction_t {
    /**
     * Relative focal length: 0.001 makes the right one longer by 0.1 %.
     */
    float focal;
    /**
     * Radial coefficient `k1`.
     */
    float k1;
} selfcal_lens_correction_t;

/**
 * Reported standard deviations of an estimate: the expected sizes of its errors.
 */
typedef struct selfcal_sd_t {
    /**
     * Deviation of `R`, rad: root of the sum of the variances about the three axes.
     */
    float rotation_rad;
    /**
     * Deviation of the direction of `t`, rad: root of the sum of the variances of its two angles.
     */
    float translation_rad;
} selfcal_sd_t;

/**
 * Error of a lens parameter, with its standard deviation.
 */
typedef struct selfcal_finding_t {
    /**
     * Estimated error: the true value minus the given value.
     */
    float value;
    /**
     * Standard deviation; at first the standard deviation of the prior.
     */
    float sd;
} selfcal_finding_t;

/**
 * Errors of the given lens models that pairs show: right camera minus left camera, except for the mean. Only
 * `SELFCAL_LENS_TRACKING_COMPENSATE` corrects the extrinsics for them, namely for the differences of focal length and
 * `k1`.
 */
typedef struct selfcal_lens_estimate_t {
    /**
     * Relative focal length: 0.001 if the right one is 0.1 % longer than given.
     */
    struct selfcal_finding_t focal;
    /**
     * Radial coefficient `k1`.
     */
    struct selfcal_finding_t k1;
    /**
     * Radial coefficient `k1`, mean of both cameras. Half of a `k1` that is compensated is not included.
     */
    struct selfcal_finding_t k1_mean;
    /**
     * Tangential coefficient `p1`.
     */
    struct selfcal_finding_t p1;
    /**
     * Column of the principal point, px.
     */
    struct selfcal_finding_t principal_x_px;
} selfcal_lens_estimate_t;

/**
 * The least certain direction of an estimate.
 */
typedef struct selfcal_weakest_t {
    /**
     * The direction.
     */
    selfcal_direction_t direction;
    /**
     * Its standard deviation, rad.
     */
    float sd_rad;
} selfcal_weakest_t;

/**
 * Motion of the rig from one pair to the next about a constant mean, which is the estimate; 0 if the pairs show no
 * vibration. The extrinsics of a single pair differ from the estimate by this much. No calibration can follow a
 * vibration.
 */
typedef struct selfcal_vibration_t {
    /**
     * Vibration of `R` about each axis, rad RMS.
     */
    float rotation_rad;
    /**
     * Vibration of the direction of `t` about each of its two angles, rad RMS.
     */
    float translation_rad;
} selfcal_vibration_t;

/**
 * The estimate over all pairs so far.
 */
typedef struct selfcal_proposal_t {
    /**
     * The best `R`, `t`.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * Correction of the cameras that the extrinsics belong to; 0 without `SELFCAL_LENS_TRACKING_COMPENSATE`.
     */
    struct selfcal_lens_correction_t correction;
    /**
     * Extrinsics that `selfcal_apply` puts into use: the best `R`, `t`, or the `t` in use with the best `R` for it.
     * The `t` in use is kept in three cases: the baseline is not observed; it is observed, but still uncertain, and
     * the `t` in use does not differ from it significantly; or image halves disagree with exact lens models. In the
     * first two cases the best `R`, `t` are applied nevertheless if pairs determine the baseline with the lens models
     * as given, and their row offsets are clearly smaller. If no `R` fits the `t` in use, this is the calibration in
     * use.
     */
    struct selfcal_extrinsics_t applicable;
    /**
     * Correction of the cameras that `applicable` belongs to.
     */
    struct selfcal_lens_correction_t applicable_correction;
    /**
     * Number of pairs in the estimate; pairs of a repeated scene count once.
     */
    uint32_t pairs;
    /**
     * Reported standard deviations, with the lens models as given.
     */
    struct selfcal_sd_t sd;
    /**
     * Reported standard deviations with the lens models uncertain by `lens_prior` of `selfcal_config_t`.
     */
    struct selfcal_sd_t sd_lens;
    /**
     * Whether `lens` is valid; false without a lens prior.
     */
    bool has_lens;
    /**
     * Errors of the lens models; 0 if they are not valid.
     */
    struct selfcal_lens_estimate_t lens;
    /**
     * Covariance, rad^2, symmetric. Order: rotation of `R` about x, y, z,
     * rotation of the baseline about y, z, in the rectified frame.
     */
    float covariance[5][5];
    /**
     * Apparent yaw `a` of the lenses, rad: the right row is below the left one by `a x y`, at unit depth.
     */
    struct selfcal_finding_t lens_yaw;
    /**
     * The least certain direction, with the lens models uncertain as in `sd_lens`.
     */
    struct selfcal_weakest_t weakest;
    /**
     * Motion of the rig about the estimate.
     */
    struct selfcal_vibration_t vibration;
    /**
     * State of the estimate.
     */
    selfcal_state_t state;
    /**
     * Reasons not to rely on the estimate: sum of `selfcal_reason_t`.
     */
    uint32_t reasons;
    /**
     * Whether pairs have determined the baseline direction. Points more than some thousand baselines away do not
     * determine it.
     */
    bool baseline_observed;
} selfcal_proposal_t;

/**
 * Judgement of the calibration in use by the last pairs. A struct of zeros is no verdict: 0 is no state, and it permits
 * nothing.
 */
typedef struct selfcal_verdict_t {
    /**
     * RMS row offset of the calibration in use beyond that of the pair's own pose, px; infinite before the first pair.
     * Noise of the matcher does not count; vibration does.
     */
    float rows_px;
    /**
     * Expected RMS error of the disparities with the calibration in use, px; infinite without an estimate. The error of
     * depth `Z` is `Z^2 / (f b)` times this.
     */
    float depth_px;
    /**
     * Share of the matches that fit the calibration in use, among those that fit the pair's own pose, 0 to 1.
     */
    float coverage;
    /**
     * Share of the cells of an 8 x 6 grid over the left image with a match that fits the pair's own pose, 0 to 1.
     */
    float image_coverage;
    /**
     * Whether `rows_px` is within `rows_limit_px` of the configuration.
     */
    bool rows_ok;
    /**
     * Whether `depth_px` is within `depth_limit_px` of the configuration.
     */
    bool depth_ok;
    /**
     * Answer to an arming check; `reasons` says why it is false.
     */
    bool may_arm;
    /**
     * Whether `selfcal_apply` is worthwhile: the estimate is locked and clearly better than the calibration in use, and
     * no mistake of the setup is named (`cause`).
     */
    bool should_apply;
    /**
     * State of the estimate.
     */
    selfcal_state_t state;
    /**
     * Reasons not to rely on the calibration in use: sum of `selfcal_reason_t`.
     */
    uint32_t reasons;
    /**
     * The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show.
     */
    selfcal_cause_t cause;
} selfcal_verdict_t;

/**
 * A change of a calibrator, with the verdict and the generation after it. All members are plain numbers, so an event
 * can be kept in any memory and sent over any wire. A struct of zeros stands for a new calibrator.
 */
typedef struct selfcal_event_t {
    /**
     * Time on the caller's clock, in the caller's unit.
     */
    uint64_t time;
    /**
     * Number of the pair, as the caller counts.
     */
    uint32_t pair;
    /**
     * Parts that differ from the event before: sum of `selfcal_change_t`.
     */
    uint32_t changes;
    /**
     * Generation of the calibration in use.
     */
    uint32_t generation;
    /**
     * State of the estimate, a `selfcal_state_t`.
     */
    uint32_t state;
    /**
     * Sum of `selfcal_reason_t`.
     */
    uint32_t reasons;
    /**
     * A `selfcal_cause_t`.
     */
    uint32_t cause;
    /**
     * Answer to an arming check, 0 or 1.
     */
    uint32_t may_arm;
    /**
     * Whether `selfcal_apply` is worthwhile, 0 or 1.
     */
    uint32_t should_apply;
    /**
     * Numbers of the verdict, as in `selfcal_verdict_t`.
     */
    float rows_px;
    /**
     * As in `selfcal_verdict_t`.
     */
    float depth_px;
    /**
     * As in `selfcal_verdict_t`.
     */
    float coverage;
    /**
     * As in `selfcal_verdict_t`.
     */
    float image_coverage;
} selfcal_event_t;

/**
 * The calibration in use and the estimate over the matches of the last pair, for logs. Both RMS values are over the
 * matches that fit the estimate.
 */
typedef struct selfcal_details_t {
    /**
     * RMS row offset of the extrinsics in use, px; 0 is perfect.
     */
    float in_use_px;
    /**
     * RMS row offset of the proposed extrinsics, px.
     */
    float proposed_px;
    /**
     * RMS difference between the row offsets in use and proposed, px: the error of the extrinsics in use, without
     * noise and vibration.
     */
    float off_px;
    /**
     * Matches that fit the extrinsics in use.
     */
    uint32_t fit_in_use;
    /**
     * Matches that fit the proposed extrinsics.
     */
    uint32_t fit_proposed;
    /**
     * Expected error of the yaw in use, rad.
     */
    float yaw_rad;
    /**
     * Row offset, px, that the apparent yaw of the lenses leaves in the image corner that is furthest from the
     * principal point. Both RMS values exclude these row offsets.
     */
    float corner_px;
    /**
     * Number of readings of `selfcal_push_range` since the last reset that contradicted the yaw: they were refused, or
     * had to wait for further readings that agree. Saturates.
     */
    uint16_t contradicting_ranges;
    /**
     * The same number for motions of `selfcal_push_motion` and `selfcal_push_tracks`.
     */
    uint16_t contradicting_motions;
} selfcal_details_t;

/**
 * Rectifying rotations `R_l`, `R_r`, which align the rows of both views.
 */
typedef struct selfcal_rotations_t {
    /**
     * `R_l`, left camera frame to rectified frame, row by row.
     */
    float left[9];
    /**
     * `R_r`, right camera frame to rectified frame, row by row.
     */
    float right[9];
} selfcal_rotations_t;

/**
 * Common camera of both rectified views, without distortion.
 */
typedef struct selfcal_rectified_camera_t {
    /**
     * Focal length, px.
     */
    float focal_px;
    /**
     * Principal point cx, cy, px.
     */
    float principal_px[2];
} selfcal_rectified_camera_t;

/**
 * Homographies from undistorted pixels of each camera to pixels of the rectified camera.
 */
typedef struct selfcal_homographies_t {
    /**
     * `H_l = K R_l K_l^-1`, row by row.
     */
    float left[9];
    /**
     * `H_r = K R_r K_r^-1`, row by row.
     */
    float right[9];
} selfcal_homographies_t;

/**
 * A point of the left image at a known distance.
 */
typedef struct selfcal_range_t {
    /**
     * Column u, row v in the left image, px, before undistortion.
     */
    float pixel_px[2];
    /**
     * Distance from the left camera, m.
     */
    float range_m;
    /**
     * Standard deviation of the distance, m.
     */
    float sd_m;
    /**
     * 0: the distance is along the ray of the pixel, as a laser rangefinder measures it. Otherwise it is along the
     * optical axis, such as the distance of a wall ahead.
     */
    uint32_t along_axis;
    /**
     * 0: the nearest match of the last pair within 3 px of `pixel_px` gives the disparity. Otherwise `right_px` gives
     * it.
     */
    uint32_t has_right;
    /**
     * Column u, row v of the same point in the right image, px, before undistortion, if the matcher has looked for it.
     */
    float right_px[2];
} selfcal_range_t;

/**
 * A match that was tracked from one pair to a later pair: its rays in both pairs, written by `selfcal_track`.
 */
typedef struct selfcal_tracked_t {
    /**
     * Private.
     */
    uint32_t words[10];
} selfcal_tracked_t;

/**
 * Matches of an earlier frame and of the last frame, joined by the track numbers that a matcher sends with them; up to
 * `SELFCAL_CAPACITY`. The caller owns the storage, as with `selfcal_t`. Each link needs its own.
 */
typedef struct selfcal_tracks_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_TRACKS_STORAGE_WORDS];
} selfcal_tracks_t;

/**
 * The published method for one stereo rig, owned by the caller: no pointers, no release. One call at a time. Changed
 * storage is detected as in `selfcal_t`.
 */
typedef struct selfcal_paper_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_PAPER_WORDS];
} selfcal_paper_t;

/**
 * Parameters of the published method. 0 in a field stands for its default.
 */
typedef struct selfcal_paper_config_t {
    /**
     * Largest number of passes of the solver over the batch: 2 or more; default 100. One more pass evaluates the
     * result.
     */
    uint16_t max_passes;
    /**
     * Least number of usable correspondences that a pair needs: 6 or more; default 12.
     */
    uint16_t min_correspondences;
    /**
     * Correction limit, rad: above 0 and below 1.5; default 0.5. A pair is not fused if `R` or `t` of the pair alone, or
     * of the estimate with the pair, differs from the factory value by a larger angle.
     */
    float max_correction_rad;
    /**
     * Lower bound of the estimated noise of a row offset, px: 0.001 to 100; default 0.02.
     */
    float noise_floor_px;
    /**
     * Huber threshold of the row offset, px: finite and above 0; default 1. A larger value lets outliers bias the
     * result; a smaller one discards the information of good matches.
     */
    float huber_threshold_px;
    /**
     * Step below which the solver has converged, rad: up to 0.1; default 1e-9. A value below the resolution of `f32`,
     * about 1e-6, acts as 1e-6.
     */
    float step_tolerance_rad;
    /**
     * Largest standard deviation of the least certain direction of a fused pair, rad: finite and above 0; default
     * 0.12.
     */
    float max_sd_rad;
    /**
     * A `selfcal_angle_t`.
     */
    uint32_t angle;
} selfcal_paper_config_t;

/**
 * Estimate of the published method over all fused pairs.
 */
typedef struct selfcal_paper_estimate_t {
    /**
     * `R*`, `t*`.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * Number of fused pairs.
     */
    uint32_t pairs;
    /**
     * Standard errors of the means; with one pair the standard deviations of that pair.
     */
    struct selfcal_sd_t sd;
    /**
     * Length of the mean of the unit rotation axes: 1 where all pairs agree, 0 for pure noise.
     */
    float axis_concentration;
    /**
     * Whether the rotation has a meaningful axis: its angle is far enough from 0 and from a half turn, and the pairs
     * agree on it.
     */
    bool axis_is_meaningful;
} selfcal_paper_estimate_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns the English text of an error code, or of a value of any other enumeration that is the type of a result;
 * never null. No two of these enumerations share a number. For other numbers the text is `"unknown"`. Enumerations
 * that arguments have as plain numbers, such as `selfcal_lens_t`, have no texts, and share numbers with error codes.
 */
const char *selfcal_string(uint32_t value);

/**
 * Undistorts a pixel to the ray at unit depth, with a camera of the calibration in use.
 *
 * * `side`: a `selfcal_side_t`.
 * * `pixel`: column u, row v in the raw image, px.
 * * `ray`: x, y at z = 1, camera frame, dimensionless.
 *
 */
selfcal_error_t selfcal_ray(const struct selfcal_t *cal,
                            uint32_t side,
                            const float pixel[2],
                            float ray[2]);

/**
 * Distorts a ray at unit depth to its pixel, with a camera of the calibration in use.
 *
 * * `side`: a `selfcal_side_t`.
 * * `ray`: x, y at z = 1, camera frame, dimensionless.
 * * `pixel`: column u, row v in the raw image, px; it may be outside the image.
 *
 */
selfcal_error_t selfcal_pixel(const struct selfcal_t *cal,
                              uint32_t side,
                              const float ray[2],
                              float pixel[2]);

/**
 * Returns the English text of the parameter or quantity that `selfcal_init` refuses; never null. If both arguments
 * are valid, the text is `"no error"`. If both are refused, the text names the parameter of `config`.
 *
 * * `config`, `factory`: each may be null. An argument that is null or misaligned is not checked.
 */
const char *selfcal_argument_string(const struct selfcal_config_t *config,
                                    const struct selfcal_factory_t *factory);

/**
 * Writes a factory calibration as a record. Call it once, in production.
 *
 * * `record`: place for `SELFCAL_FACTORY_BYTES` bytes.
 */
selfcal_error_t selfcal_factory_to_record(const struct selfcal_factory_t *factory, uint8_t *record);

/**
 * Reads a factory calibration from a record. Call it at each start. A calibrator that is initialised with it has the
 * same cameras and factory extrinsics, bit for bit, as with the calibration that was written.
 *
 * * `record`: from `selfcal_factory_to_record`.
 * * `length`: number of bytes that were found.
 */
selfcal_error_t selfcal_factory_from_record(struct selfcal_factory_t *factory,
                                            const uint8_t *record,
                                            size_t length);

/**
 * Returns the version of the library as a text; never null. `selfcal_init` compares it with that of the header.
 */
const char *selfcal_version(void);

/**
 * Writes the size and alignment of the storage that the library needs, and its capacity. Use them to allocate the
 * storage at run time, or to compare the library with the header.
 */
selfcal_error_t selfcal_requirements(struct selfcal_requirements_t *requirements);

/**
 * Initialises a calibrator at a factory calibration. Call it before all other functions of the calibrator. It also
 * restarts a calibrator in use, with the same or another factory calibration. The generation is 0 afterwards. Load the
 * rectifier with the calibration that `selfcal_in_use` returns.
 *
 * * `cal`: a `selfcal_t`, or any storage of the required size and alignment.
 * * `size`: size of the storage, bytes: `sizeof(selfcal_t)`.
 * * `header`: `SELFCAL_HEADER`. A program that was compiled with the header of another version, or with structs of
 *   other sizes, is refused.
 * * `config`: copied; null for the default.
 * * `factory`: copied. `selfcal_argument_string` says why `config` or `factory` is refused.
 */
selfcal_error_t selfcal_init(struct selfcal_t *cal,
                             size_t size,
                             uint32_t header,
                             const struct selfcal_config_t *config,
                             const struct selfcal_factory_t *factory);

/**
 * Puts the factory calibration back into use, releases a freeze, and forgets the batch and all fused pairs.
 */
selfcal_error_t selfcal_reset(struct selfcal_t *cal);

/**
 * Reads the calibration in use; at first this is the factory calibration. Load the rectifier with it at start, and
 * again whenever its generation has changed.
 */
selfcal_error_t selfcal_in_use(const struct selfcal_t *cal,
                               struct selfcal_calibration_t *calibration);

/**
 * Offers one correspondence to the batch. A full batch selects: it keeps matches spread over the left image, and
 * prefers the better score among neighbours. The first correspondence after the end of a pair begins a new batch. A
 * correspondence that is not valid is refused and counted. While a pair is being solved, the batch takes no
 * correspondence: `SELFCAL_ERROR_BUSY`.
 *
 * * `pushed`: effect on the batch; may be null.
 */
selfcal_error_t selfcal_push(struct selfcal_t *cal,
                             const struct selfcal_correspondence_t *correspondence,
                             selfcal_pushed_t *pushed);

/**
 * Offers an array of correspondences to the batch, in their order. Refused correspondences are counted, and are not an
 * error. While a pair is being solved, the batch takes no correspondence: `SELFCAL_ERROR_BUSY`.
 *
 * * `correspondences`: array of `count`; may be null if `count` is 0.
 * * `counts`: effect on the batch; may be null.
 */
selfcal_error_t selfcal_push_array(struct selfcal_t *cal,
                                   const struct selfcal_correspondence_t *correspondences,
                                   size_t count,
                                   struct selfcal_pushed_counts_t *counts);

/**
 * Reads the counts of the batch.
 */
selfcal_error_t selfcal_batch(const struct selfcal_t *cal, struct selfcal_batch_t *batch);

/**
 * Initialises a link. Call it before all other functions of the link. It also restarts a link in use; a frame that is
 * partly read is dropped, and the counters are 0.
 *
 * * `size`: size of the storage, bytes: `sizeof(selfcal_link_t)`.
 */
selfcal_error_t selfcal_link_init(struct selfcal_link_t *link,
                                  size_t size);

/**
 * Decodes bytes off the wire, in pieces of any length, up to the end of the first whole frame. A
 * frame replaces the batch. Damaged or lost bytes cost the frames they are part of; the decoder
 * finds the next frame.
 *
 * Feed all bytes, in their order, in a loop:
 *
 * ```c
 * do {
 *     error = selfcal_link_feed(&wire, &cal, bytes, length, &used, &frame);
 *     bytes += used;
 *     length -= used;
 *     if (frame.whole)
 *         ...
 * } while (used > 0 && length > 0);
 * ```
 *
 * Do not push a correspondence, and do not begin a pair, while a frame arrives: its matches are hidden until it is
 * whole. While a pair is being solved, the call returns `SELFCAL_ERROR_BUSY` and uses no bytes: feed the same bytes
 * later. After `SELFCAL_ERROR_IMAGE_SIZE` feed the rest: the frame is skipped, and the batch is unchanged.
 *
 * * `bytes`: array of `length`; may be null if `length` is 0. Not needed after the call.
 * * `used`: number of bytes used, also written with errors; 0 if nothing was decoded.
 * * `frame`: the frame, if one is whole; otherwise, and with errors, all 0.
 */
selfcal_error_t selfcal_link_feed(struct selfcal_link_t *link,
                                  struct selfcal_t *cal,
                                  const uint8_t *bytes,
                                  size_t length,
                                  size_t *used,
                                  struct selfcal_frame_t *frame);

/**
 * Counts an overrun of the receiver, such as a ring buffer that wrapped or an overrun that a UART reports. Go on
 * feeding: the decoder finds the next whole frame.
 */
selfcal_error_t selfcal_link_note_overrun(struct selfcal_link_t *link);

/**
 * Reads the counters of a link.
 */
selfcal_error_t selfcal_link_counters(const struct selfcal_link_t *link,
                                      struct selfcal_link_counters_t *counters);

/**
 * Checks whether a match can be encoded in a frame. Count such matches before the frame begins, because the header
 * contains their number.
 *
 * * `header`: header of the frame; its count is ignored.
 */
selfcal_error_t selfcal_frame_check(const struct selfcal_frame_header_t *header,
                                    const struct selfcal_correspondence_t *correspondence);

/**
 * Begins a frame, also in an encoder in use. The header contains the number of matches that follow.
 *
 * * `size`: size of the storage, bytes: `sizeof(selfcal_encoder_t)`.
 * * `bytes`: place for the first `SELFCAL_FRAME_HEADER_BYTES` bytes of the frame.
 */
selfcal_error_t selfcal_frame_begin(struct selfcal_encoder_t *encoder,
                                    size_t size,
                                    const struct selfcal_frame_header_t *header,
                                    uint8_t *bytes);

/**
 * Encodes the next match of a frame. A match that is refused changes nothing: send another one in its
 * place, or begin the next frame.
 *
 * * `bytes`: place for the next `SELFCAL_FRAME_MATCH_BYTES` bytes of the frame.
 */
selfcal_error_t selfcal_frame_match(struct selfcal_encoder_t *encoder,
                                    const struct selfcal_correspondence_t *correspondence,
                                    uint8_t *bytes);

/**
 * Does the same as `selfcal_frame_match`, for a match that a tracker follows.
 *
 * * `track`: number of the track; its low 12 bits are sent. If they are 0, the match is sent without a track.
 */
selfcal_error_t selfcal_frame_tracked_match(struct selfcal_encoder_t *encoder,
                                            const struct selfcal_correspondence_t *correspondence,
                                            uint16_t track,
                                            uint8_t *bytes);

/**
 * Ends a frame with its CRC. While matches are missing, it returns `SELFCAL_ERROR_FRAME_MISSING`: add them, or begin
 * the next frame; the receiver then drops this one.
 *
 * * `bytes`: place for the last `SELFCAL_FRAME_END_BYTES` bytes of the frame.
 */
selfcal_error_t selfcal_frame_end(const struct selfcal_encoder_t *encoder,
                                  uint8_t *bytes);

/**
 * Takes one stereo pair in one call: replaces the batch by an array of correspondences, solves it and fuses the
 * result. A pair that was being solved is abandoned. Refused correspondences are not an error; `selfcal_batch`
 * counts them.
 *
 * An error from 500 on says why the pair is not part of the estimate, which is normal: go on with the next pair.
 *
 * * `correspondences`: array of `count`; may be null if `count` is 0.
 * * `outcome`: written with these errors, too; may be null.
 */
selfcal_error_t selfcal_take_pair(struct selfcal_t *cal,
                                  const struct selfcal_correspondence_t *correspondences,
                                  size_t count,
                                  struct selfcal_outcome_t *outcome);

/**
 * Solves the batch and fuses the result, in one call with all passes. The next correspondence that is pushed begins
 * a new batch; until then `selfcal_details` and `selfcal_push_range` read this one. It has the
 * same errors as `selfcal_take_pair`.
 *
 * * `outcome`: written with these errors, too; may be null.
 */
selfcal_error_t selfcal_solve_pair(struct selfcal_t *cal,
                                   struct selfcal_outcome_t *outcome);

/**
 * Takes one step of a pair: at most one pass over the batch. The first step begins the pair with the correspondences
 * pushed so far, and the last step fuses the result. Outcome and errors equal those of `selfcal_solve_pair`, bit for
 * bit. An error from 500 on ends the pair.
 *
 * * `ended`: whether the pair has ended; written with these errors, too.
 * * `outcome`: written once the pair has ended; may be null.
 */
selfcal_error_t selfcal_advance_pair(struct selfcal_t *cal,
                                     bool *ended,
                                     struct selfcal_outcome_t *outcome);

/**
 * Empties the batch, and abandons a pair that is being solved. A pair that has been fused already gets its verdict first.
 */
selfcal_error_t selfcal_discard_pair(struct selfcal_t *cal);

/**
 * Reads the state of the estimate.
 */
selfcal_error_t selfcal_state(const struct selfcal_t *cal, selfcal_state_t *state);

/**
 * Reads the estimate over all fused pairs. Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`.
 */
selfcal_error_t selfcal_proposal(const struct selfcal_t *cal,
                                 struct selfcal_proposal_t *proposal);

/**
 * Writes the verdict after the last pair. It stays the same until the next pair has ended, and costs nothing. If the
 * call fails, nothing is written.
 */
selfcal_error_t selfcal_verdict(const struct selfcal_t *cal,
                                struct selfcal_verdict_t *verdict);

/**
 * Compares a calibrator with its last event, and replaces the event if anything has changed. Call it after each pair,
 * after `selfcal_apply` if that is called. The caller keeps the events, for instance the last 32 in a ring:
 *
 * ```c
 * static selfcal_event_t event, ring[32];
 * static uint32_t count;
 *
 * if (selfcal_event(&cal, time_us, pair, &event, &is_new) == SELFCAL_OK && is_new)
 *     ring[count++ % 32] = event;
 * ```
 *
 * * `time`: time on the caller's clock, in any unit.
 * * `pair`: number of the pair.
 * * `event`: the last event; zeros before the first one.
 * * `is_new`: whether `event` is a new event.
 */
selfcal_error_t selfcal_event(const struct selfcal_t *cal,
                              uint64_t time,
                              uint32_t pair,
                              struct selfcal_event_t *event,
                              bool *is_new);

/**
 * Compares the calibration in use with the estimate over the matches of the last pair, in one pass over the batch.
 * Call it before the next correspondence is pushed.
 *
 * Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`, and without a match that fits the estimate
 * `SELFCAL_ERROR_NO_MATCH`; nothing is written then.
 */
selfcal_error_t selfcal_details(const struct selfcal_t *cal,
                                struct selfcal_details_t *details);

/**
 * Writes the expected depth errors of the extrinsics in use at 1, 2, 5 and 10 m, in the middle of the image. Takes one
 * pass over the batch. The noise of the matcher and the error of the baseline length are not included. Returns
 * `SELFCAL_ERROR_NOT_LOCKED` if the estimate is not locked. It also has the errors of `selfcal_details`.
 *
 * * `baseline_m`: length of the baseline, m; finite and above 0.
 * * `errors`: expected depth errors, m.
 *
 */
selfcal_error_t selfcal_depth_errors(const struct selfcal_t *cal,
                                     float baseline_m,
                                     float errors[4]);

/**
 * Puts the estimate into use: `applicable` of the proposal. The generation changes if the calibration changes. Until
 * four pairs agree, `SELFCAL_ERROR_NO_ESTIMATE` and `SELFCAL_ERROR_NOT_LOCKED` are normal.
 *
 * * `applied`: the calibration now in use; may be null.
 */
selfcal_error_t selfcal_apply(struct selfcal_t *cal,
                              struct selfcal_calibration_t *applied);

/**
 * Puts the calibration that the last effective `selfcal_apply` replaced back into use. A second call in a row has
 * nothing to undo. The estimate does not change.
 *
 * * `restored`: the calibration now in use; may be null.
 */
selfcal_error_t selfcal_undo(struct selfcal_t *cal,
                             struct selfcal_calibration_t *restored);

/**
 * Freezes the estimate and the calibration in use, or releases both. While they are frozen, pairs are still solved,
 * and end with `SELFCAL_ERROR_FROZEN`. `selfcal_apply` and `selfcal_undo` return this error, too.
 */
selfcal_error_t selfcal_set_frozen(struct selfcal_t *cal,
                                   bool frozen);

/**
 * Computes the two rectifying rotations.
 *
 * * `source`: a `selfcal_source_t`.
 */
selfcal_error_t selfcal_rotations(const struct selfcal_t *cal,
                                  uint32_t source,
                                  struct selfcal_rotations_t *rectifying);

/**
 * Chooses the common camera of both rectified images, which have the size of the left image. This is for cameras side
 * by side. It takes 136 undistortions: call it when the generation changes, and not for each frame.
 *
 * * `source`: a `selfcal_source_t`.
 * * `alpha`: 0 to 1. 0 zooms in until both cameras see every rectified pixel; 1 zooms out until every
 *   pixel of both is kept.
 */
selfcal_error_t selfcal_choose_camera(const struct selfcal_t *cal,
                                      uint32_t source,
                                      float alpha,
                                      struct selfcal_rectified_camera_t *camera);

/**
 * Computes the two rectifying homographies.
 *
 * * `source`: a `selfcal_source_t`.
 * * `camera`: from `selfcal_choose_camera`, or any other camera with finite numbers and a focal length above 0.
 */
selfcal_error_t selfcal_homographies(const struct selfcal_t *cal,
                                     uint32_t source,
                                     const struct selfcal_rectified_camera_t *camera,
                                     struct selfcal_homographies_t *homographies);

/**
 * Writes the calibration in use and the estimate as a record for non-volatile memory. The estimate is a prior: pose
 * and covariance, noise, vibration, and the knowledge of lens and mount. The record also contains the generation, the
 * calibration that `selfcal_undo` returns to, and whether the calibrator is frozen. It omits the factory calibration
 * (see `selfcal_factory_to_record`), the batch, and a pair that is being solved.
 *
 * The record has a layout number and a checksum, and the same bytes on every machine. Keep the previous
 * record until the new one is written: `selfcal_restore` detects a record that a loss of power has cut
 * short.
 *
 * * `record`: place for `SELFCAL_SNAPSHOT_BYTES` bytes.
 */
selfcal_error_t selfcal_snapshot(const struct selfcal_t *cal,
                                 uint8_t *record);

/**
 * Replaces everything that has been learnt by the content of a record of `selfcal_snapshot`. The rig may have changed
 * since: a restored estimate is `SELFCAL_STATE_SUSPECT` until a pair confirms it.
 *
 * Call it after `selfcal_init` with the same factory calibration. If the record is refused, the calibrator is in the
 * state after `selfcal_reset`: go on from the factory calibration.
 *
 * * `record`: from `selfcal_snapshot`, also of another machine or another capacity.
 * * `length`: number of bytes that were found. A record of another length than `SELFCAL_SNAPSHOT_BYTES` is damaged.
 */
selfcal_error_t selfcal_restore(struct selfcal_t *cal,
                                const uint8_t *record,
                                size_t length);

/**
 * Adds a point of known distance, which separates the yaw of the mount from the apparent yaw of the lens. Call it
 * after the end of the pair that shows the point, and before the next pair. It needs the length of the baseline
 * (`selfcal_factory_t.baseline_m`) and a match that fits the estimate: `right_px`, or a match of the pair within 3 px.
 * Five readings with an error of 1 %, or ten with an error of 3 %, are enough.
 *
 * A reading that contradicts the present yaw waits. The present yaw is replaced once more contradicting readings in a
 * row agree with each other than support the present yaw. This takes two to four readings.
 *
 * * `witnessed`: effect on the estimate; may be null.
 */
selfcal_error_t selfcal_push_range(struct selfcal_t *cal,
                                   const struct selfcal_range_t *range,
                                   selfcal_witnessed_t *witnessed);

/**
 * Computes the rays of a tracked match, with the cameras of the factory calibration, and writes them to `tracked`.
 *
 * * `before`, `after`: the match in the first and in the second pair.
 */
selfcal_error_t selfcal_track(const struct selfcal_t *cal,
                              const struct selfcal_correspondence_t *before,
                              const struct selfcal_correspondence_t *after,
                              struct selfcal_tracked_t *tracked);

/**
 * Adds matches that were tracked from one pair to a later pair while the rig moved by several lengths of its baseline.
 * They separate the yaw of the mount from the apparent yaw of the lens. Call it after the end of the later pair. Up to
 * 256 matches are read, at most 16 times each; on a controller, `selfcal_advance_tracks` divides this into calls. A
 * motion that contradicts the present yaw waits, as a reading of `selfcal_push_range` does.
 *
 * * `tracked`: array of `count` matches, written by `selfcal_track`.
 * * `witnessed`: effect on the estimate; may be null.
 */
selfcal_error_t selfcal_push_motion(struct selfcal_t *cal,
                                    const struct selfcal_tracked_t *tracked,
                                    size_t count,
                                    selfcal_witnessed_t *witnessed);

/**
 * Initialises tracks. Call it before all other functions of the tracks. For tracks in use, it forgets their frames.
 *
 * * `size`: size of the storage, bytes: `sizeof(selfcal_tracks_t)`.
 */
selfcal_error_t selfcal_tracks_init(struct selfcal_tracks_t *tracks,
                                    size_t size);

/**
 * Does the same as `selfcal_link_feed`, for a matcher that sends tracks: `tracks` also receive each frame.
 */
selfcal_error_t selfcal_link_feed_tracked(struct selfcal_link_t *link,
                                          struct selfcal_t *cal,
                                          struct selfcal_tracks_t *tracks,
                                          const uint8_t *bytes,
                                          size_t length,
                                          size_t *used,
                                          struct selfcal_frame_t *frame);

/**
 * Does the same as `selfcal_push_motion`, with the tracked matches that the earlier frame and the frame of the last
 * pair share. Call it after the end of the pair. Each frame is joined to the same earlier frame until the rig has
 * moved far enough for a measurement. Before that, `SELFCAL_ERROR_NO_MOTION` and `SELFCAL_ERROR_TOO_FEW` are normal.
 * After a measurement, and after `SELFCAL_ERROR_CONTRADICTS`, the last frame becomes the earlier frame. A frame that
 * shares fewer than half of the tracks of the earlier frame also replaces it.
 *
 * * `witnessed`: effect on the estimate; may be null.
 */
selfcal_error_t selfcal_push_tracks(struct selfcal_t *cal,
                                    struct selfcal_tracks_t *tracks,
                                    selfcal_witnessed_t *witnessed);

/**
 * Takes one step of `selfcal_push_tracks`: one pass over at most 256 matches. After at most 16 steps, effect and errors
 * equal those of `selfcal_push_tracks`, bit for bit. The next frame abandons the steps taken.
 *
 * * `ended`: whether no further step is needed; an error ends the steps, too.
 * * `witnessed`: effect on the estimate, written after the last step; may be null.
 */
selfcal_error_t selfcal_advance_tracks(struct selfcal_t *cal,
                                       struct selfcal_tracks_t *tracks,
                                       bool *ended,
                                       selfcal_witnessed_t *witnessed);

/**
 * Initialises the published method. Every pair is solved from the factory extrinsics. It has no verdict, no
 * calibration in use and no records.
 *
 * * `size`: size of the storage, bytes: `sizeof(selfcal_paper_t)`.
 * * `config`: copied; null for the default. `SELFCAL_ERROR_CONFIG` if a field is out of its range.
 * * `factory`: copied; only cameras and extrinsics are used.
 */
selfcal_error_t selfcal_paper_init(struct selfcal_paper_t *paper,
                                   size_t size,
                                   const struct selfcal_paper_config_t *config,
                                   const struct selfcal_factory_t *factory);

/**
 * Takes one stereo pair: solves an array of correspondences and fuses the result. Refused correspondences are left
 * out. An error from 500 on says why the pair is not part of the estimate, which is normal: go on with the next pair.
 *
 * * `correspondences`: array of `count`; may be null if `count` is 0.
 * * `outcome`: written with these errors, too; may be null.
 */
selfcal_error_t selfcal_paper_take_pair(struct selfcal_paper_t *paper,
                                        const struct selfcal_correspondence_t *correspondences,
                                        size_t count,
                                        struct selfcal_outcome_t *outcome);

/**
 * Reads the estimate over all fused pairs. Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`.
 */
selfcal_error_t selfcal_paper_estimate(const struct selfcal_paper_t *paper,
                                       struct selfcal_paper_estimate_t *estimate);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* STEREO_SELFCAL_H */
