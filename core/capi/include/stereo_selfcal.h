/*
 * Online self-calibration of stereo extrinsics from left/right correspondences. C API, f32.
 *
 * Generated from the Rust source: do not edit.
 *
 * Convention: p_r = R p_l + t, |t| = 1. Camera frames x right, y down, z forward; p_l and p_r are the
 * same point in the left and the right camera frame. Matrices row by row, angles in rad, pixels of the
 * image as it is, before undistortion, with the centre of the top left pixel at (0, 0).
 *
 * Every function returns a selfcal_error_t and gives its results through pointers, but for the _string
 * functions. No pointer may be null, unless its function says so; null and misaligned pointers and
 * storage that is not initialised are refused. A call that is refused changes no extrinsics, and gives no
 * results but those that its function names. Correspondences that are refused are counted; a pair that is
 * refused is noted in the health and may count against the estimate.
 *
 * Nothing allocates, blocks or keeps a pointer. One call at a time for each calibrator and
 * each link.
 *
 *     static selfcal_t cal;
 *
 *     selfcal_init(&cal, sizeof cal, NULL);
 *     selfcal_set_cameras(&cal, &left, &right);
 *     for each stereo pair:
 *         selfcal_push_array(&cal, matches, count, NULL);
 *         if (selfcal_solve_pair(&cal) == SELFCAL_OK)
 *             selfcal_fuse(&cal, NULL);
 *         selfcal_health(&cal, &health);
 *         selfcal_clear_pair(&cal);
 *     when it suits: selfcal_apply(&cal, &extrinsics);
 *
 * A matcher that sends frames (core/src/link/FORMAT.md) needs no code but this, behind any driver of a UART
 * or of SPI:
 *
 *     static selfcal_link_t wire;
 *
 *     selfcal_link_init(&wire, sizeof wire);
 *     for each piece of bytes that the driver has:
 *         do {
 *             selfcal_link_feed(&wire, &cal, bytes, length, &used, &frame);
 *             bytes += used;
 *             length -= used;
 *             if (frame.whole)
 *                 solve, fuse and look at the health, as above; the next frame clears the pair
 *         } while (used > 0 && length > 0);
 *
 * What was learnt outlasts a loss of power in a record, in whatever flash layer there is:
 *
 *     static uint8_t record[SELFCAL_SNAPSHOT_BYTES];
 *
 *     at each start, the cameras set: selfcal_restore(&cal, record, length);
 *     now and then: selfcal_snapshot(&cal, record, sizeof record, &length);
 *
 * SELFCAL_CAPACITY follows the library: define SELFCAL_CAPACITY_64, _128, _512 or _1024 if it was built
 * with the feature of that name. selfcal_init refuses storage that is too small.
 */


#ifndef STEREO_SELFCAL_H
#define STEREO_SELFCAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(SELFCAL_CAPACITY_1024)
/**
 * Correspondences a pair has room for; a full batch selects.
 */
#define SELFCAL_CAPACITY 1024
#endif

#if (defined(SELFCAL_CAPACITY_512) && !defined(SELFCAL_CAPACITY_1024))
/**
 * Correspondences a pair has room for; a full batch selects.
 */
#define SELFCAL_CAPACITY 512
#endif

#if (defined(SELFCAL_CAPACITY_128) && !(defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024)))
/**
 * Correspondences a pair has room for; a full batch selects.
 */
#define SELFCAL_CAPACITY 128
#endif

#if (defined(SELFCAL_CAPACITY_64) && !(defined(SELFCAL_CAPACITY_128) || defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024)))
/**
 * Correspondences a pair has room for; a full batch selects.
 */
#define SELFCAL_CAPACITY 64
#endif

#if !(defined(SELFCAL_CAPACITY_64) || defined(SELFCAL_CAPACITY_128) || defined(SELFCAL_CAPACITY_512) || defined(SELFCAL_CAPACITY_1024))
/**
 * Correspondences a pair has room for; a full batch selects.
 */
#define SELFCAL_CAPACITY 256
#endif

/**
 * Storage in words of 8 bytes: the same for every target, so with a little to spare.
 */
#define SELFCAL_STORAGE_WORDS (448 + ((5 * SELFCAL_CAPACITY) / 2))

/**
 * Storage, bytes.
 */
#define SELFCAL_STORAGE_SIZE (8 * SELFCAL_STORAGE_WORDS)

/**
 * Alignment of the storage that is enough on every target, bytes.
 */
#define SELFCAL_STORAGE_ALIGN 8

/**
 * Storage of a link in words of 8 bytes: the same for every target, so with a little to spare.
 */
#define SELFCAL_LINK_STORAGE_WORDS 26

/**
 * Storage of a link, bytes.
 */
#define SELFCAL_LINK_STORAGE_SIZE (8 * SELFCAL_LINK_STORAGE_WORDS)

/**
 * Length of the longest record of `selfcal_snapshot`, bytes; of any capacity.
 */
#define SELFCAL_SNAPSHOT_BYTES 2532

/**
 * Length of the longest record of `selfcal_factory_to_record`, bytes.
 */
#define SELFCAL_FACTORY_BYTES 160

/**
 * Why a function gave nothing. The numbers stay; new ones may come.
 */
enum selfcal_error_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    SELFCAL_OK = 0,
    /**
     * A pointer is null.
     */
    SELFCAL_ERROR_NULL = 1,
    /**
     * A pointer is not aligned for what it points to.
     */
    SELFCAL_ERROR_ALIGNMENT = 2,
    /**
     * The storage is too small: a header of another capacity?
     */
    SELFCAL_ERROR_STORAGE_SIZE = 3,
    /**
     * The storage is not initialised, has been overwritten, or belongs to another build.
     */
    SELFCAL_ERROR_NOT_INITIALISED = 4,
    /**
     * The configuration is not initialised: begin with `selfcal_config_default`.
     */
    SELFCAL_ERROR_CONFIG_NOT_INITIALISED = 5,
    /**
     * A number is none of its enumeration.
     */
    SELFCAL_ERROR_VALUE = 6,
    /**
     * An array is longer than the address space.
     */
    SELFCAL_ERROR_COUNT = 7,
    /**
     * `selfcal_set_cameras` comes first.
     */
    SELFCAL_ERROR_NO_CAMERAS = 8,
    /**
     * No pair has been solved since the batch was last begun or cleared.
     */
    SELFCAL_ERROR_NO_REPORT = 9,
    /**
     * No pair has been fused.
     */
    SELFCAL_ERROR_NO_ESTIMATE = 10,
    /**
     * There are no cameras, no fused pairs, or no matches in the batch that fit the estimate.
     */
    SELFCAL_ERROR_NO_HEALTH = 11,
    /**
     * Depth errors are only predicted while locked.
     */
    SELFCAL_ERROR_NO_DEPTH_ERROR = 12,
    /**
     * The length of the baseline is not finite or not above 0.
     */
    SELFCAL_ERROR_BASELINE = 13,
    /**
     * The rectified camera is not finite, or its focal length not above 0.
     */
    SELFCAL_ERROR_RECTIFIED_CAMERA = 14,
    /**
     * The core gave an error that this API does not know yet.
     */
    SELFCAL_ERROR_UNKNOWN = 99,
    /**
     * Left camera: a focal length is not finite or not within 1 to 1e6 px.
     */
    SELFCAL_ERROR_LEFT_FOCAL_LENGTH = 100,
    /**
     * Left camera: the principal point is not finite, or further from the image than its own size.
     */
    SELFCAL_ERROR_LEFT_PRINCIPAL_POINT = 101,
    /**
     * Left camera: the image is smaller than 2 x 2 px.
     */
    SELFCAL_ERROR_LEFT_IMAGE_SIZE = 102,
    /**
     * Left camera: a lens coefficient is not finite or above 1e3 in size.
     */
    SELFCAL_ERROR_LEFT_DISTORTION = 103,
    /**
     * Left camera: the lens model is none of `selfcal_lens_t`.
     */
    SELFCAL_ERROR_LEFT_LENS = 104,
    /**
     * Left camera: a coefficient that the lens model does not have is not 0.
     */
    SELFCAL_ERROR_LEFT_COEFFICIENT = 105,
    /**
     * Right camera: a focal length is not finite or not within 1 to 1e6 px.
     */
    SELFCAL_ERROR_RIGHT_FOCAL_LENGTH = 110,
    /**
     * Right camera: the principal point is not finite, or further from the image than its own size.
     */
    SELFCAL_ERROR_RIGHT_PRINCIPAL_POINT = 111,
    /**
     * Right camera: the image is smaller than 2 x 2 px.
     */
    SELFCAL_ERROR_RIGHT_IMAGE_SIZE = 112,
    /**
     * Right camera: a lens coefficient is not finite or above 1e3 in size.
     */
    SELFCAL_ERROR_RIGHT_DISTORTION = 113,
    /**
     * Right camera: the lens model is none of `selfcal_lens_t`.
     */
    SELFCAL_ERROR_RIGHT_LENS = 114,
    /**
     * Right camera: a coefficient that the lens model does not have is not 0.
     */
    SELFCAL_ERROR_RIGHT_COEFFICIENT = 115,
    /**
     * Ray: the pixel is not finite.
     */
    SELFCAL_ERROR_RAY_NOT_FINITE = 120,
    /**
     * Ray: the pixel is outside the image by more than half a pixel.
     */
    SELFCAL_ERROR_RAY_OUTSIDE_IMAGE = 121,
    /**
     * Ray: the lens model folds back before the pixel, or the ray is over 85 degrees off axis.
     */
    SELFCAL_ERROR_RAY_NOT_INVERTIBLE = 122,
    /**
     * Pixel: the ray is not finite.
     */
    SELFCAL_ERROR_PIXEL_NOT_FINITE = 130,
    /**
     * Pixel: the ray lies beyond the range in which the lens model is one to one.
     */
    SELFCAL_ERROR_PIXEL_BEYOND_LENS = 131,
    /**
     * Extrinsics: `R` is not finite, not orthonormal to about 0.1, or a reflection.
     */
    SELFCAL_ERROR_EXTRINSICS_NOT_A_ROTATION = 200,
    /**
     * Extrinsics: `t` is not finite or has no direction.
     */
    SELFCAL_ERROR_EXTRINSICS_NO_DIRECTION = 201,
    /**
     * Extrinsics: `t` is within 6 degrees of an optical axis: such a pair cannot be rectified.
     */
    SELFCAL_ERROR_EXTRINSICS_ALONG_OPTICAL_AXIS = 202,
    /**
     * Configuration: the Huber threshold must be finite and above 0 px.
     */
    SELFCAL_ERROR_CONFIG_HUBER_THRESHOLD = 300,
    /**
     * Configuration: there must be at least 2 passes.
     */
    SELFCAL_ERROR_CONFIG_MAX_PASSES = 301,
    /**
     * Configuration: the step tolerance must lie within 0 to 0.1 rad.
     */
    SELFCAL_ERROR_CONFIG_STEP_TOLERANCE = 302,
    /**
     * Configuration: at least 6 correspondences must be asked for.
     */
    SELFCAL_ERROR_CONFIG_MIN_CORRESPONDENCES = 303,
    /**
     * Configuration: the noise floor must be finite and above 0 px.
     */
    SELFCAL_ERROR_CONFIG_NOISE_FLOOR = 304,
    /**
     * Configuration: the standard deviation of the prior must lie within 1e-4 to 1 rad.
     */
    SELFCAL_ERROR_CONFIG_PRIOR_SD = 305,
    /**
     * Configuration: the largest standard deviation must be finite and above 0 rad.
     */
    SELFCAL_ERROR_CONFIG_MAX_SD = 306,
    /**
     * Configuration: the memory must be at least 20 pairs.
     */
    SELFCAL_ERROR_CONFIG_MEMORY = 307,
    /**
     * Configuration: the correction limit must be above 0 and below 1.5 rad.
     */
    SELFCAL_ERROR_CONFIG_MAX_CORRECTION = 308,
    /**
     * Push: `selfcal_set_cameras` comes first.
     */
    SELFCAL_ERROR_PUSH_NO_CAMERAS = 400,
    /**
     * Push: a pair is being solved; finish it or clear it first.
     */
    SELFCAL_ERROR_PUSH_BUSY = 401,
    /**
     * Push: the score is not within 0 to 1.
     */
    SELFCAL_ERROR_PUSH_SCORE = 402,
    /**
     * Push: the grid step is not within 0 to 255.99 px.
     */
    SELFCAL_ERROR_PUSH_GRID_STEP = 403,
    /**
     * Push: the left pixel is not finite.
     */
    SELFCAL_ERROR_PUSH_LEFT_NOT_FINITE = 410,
    /**
     * Push: the left pixel is outside the image by more than half a pixel.
     */
    SELFCAL_ERROR_PUSH_LEFT_OUTSIDE_IMAGE = 411,
    /**
     * Push: the lens model is not invertible at the left pixel.
     */
    SELFCAL_ERROR_PUSH_LEFT_NOT_INVERTIBLE = 412,
    /**
     * Push: the right pixel is not finite.
     */
    SELFCAL_ERROR_PUSH_RIGHT_NOT_FINITE = 420,
    /**
     * Push: the right pixel is outside the image by more than half a pixel.
     */
    SELFCAL_ERROR_PUSH_RIGHT_OUTSIDE_IMAGE = 421,
    /**
     * Push: the lens model is not invertible at the right pixel.
     */
    SELFCAL_ERROR_PUSH_RIGHT_NOT_INVERTIBLE = 422,
    /**
     * Pair: `selfcal_set_cameras` comes first.
     */
    SELFCAL_ERROR_PAIR_NO_CAMERAS = 500,
    /**
     * Pair: `selfcal_begin_pair` comes first.
     */
    SELFCAL_ERROR_PAIR_NOT_BEGUN = 501,
    /**
     * Pair: fewer usable correspondences than configured. Collect more; nothing is wrong.
     */
    SELFCAL_ERROR_PAIR_TOO_FEW = 502,
    /**
     * Pair: the correspondences agree on no extrinsics; mismatches only.
     */
    SELFCAL_ERROR_PAIR_NO_CONSENSUS = 503,
    /**
     * Pair: the correspondences leave a direction free: all alike, on a line, or at infinity.
     */
    SELFCAL_ERROR_PAIR_UNOBSERVABLE = 504,
    /**
     * Fuse: the weakest direction of the pair is too uncertain.
     */
    SELFCAL_ERROR_FUSE_TOO_UNCERTAIN = 600,
    /**
     * Fuse: further from the factory extrinsics than the correction limit.
     */
    SELFCAL_ERROR_FUSE_CORRECTION_LIMIT = 601,
    /**
     * Fuse: the pair leads to extrinsics that cannot be rectified.
     */
    SELFCAL_ERROR_FUSE_NO_RIG = 602,
    /**
     * Fuse: the pair disagrees with the estimate, and with the pairs kept apart from it.
     */
    SELFCAL_ERROR_FUSE_DISAGREES = 603,
    /**
     * Fuse: the pair has been fused, or the calibrator reset, since it was solved.
     */
    SELFCAL_ERROR_FUSE_STALE = 604,
    /**
     * Fuse: the calibrator is frozen.
     */
    SELFCAL_ERROR_FUSE_FROZEN = 605,
    /**
     * Fuse: a quantity of the report is not finite.
     */
    SELFCAL_ERROR_FUSE_NOT_FINITE = 606,
    /**
     * Apply: no pair has been fused.
     */
    SELFCAL_ERROR_APPLY_NO_PROPOSAL = 700,
    /**
     * Apply: the fused pairs agree on no extrinsics.
     */
    SELFCAL_ERROR_APPLY_INCONSISTENT = 701,
    /**
     * Apply: the estimate is not locked; `selfcal_state` says what it is.
     */
    SELFCAL_ERROR_APPLY_NOT_LOCKED = 702,
    /**
     * Apply: image halves disagree by more than 5 standard deviations; the matches are biased.
     */
    SELFCAL_ERROR_APPLY_DOUBTFUL = 703,
    /**
     * Apply: the calibrator is frozen.
     */
    SELFCAL_ERROR_APPLY_FROZEN = 704,
    /**
     * Undo: nothing has been applied since the last reset or undo.
     */
    SELFCAL_ERROR_APPLY_NOTHING_TO_UNDO = 705,
    /**
     * Rectify: `alpha` is not within 0 to 1.
     */
    SELFCAL_ERROR_RECTIFY_ALPHA = 800,
    /**
     * Rectify: the rectified views share no rectangle, or are not upright.
     */
    SELFCAL_ERROR_RECTIFY_NO_COMMON_VIEW = 801,
    /**
     * Rectify: a point on the border of the left image is not finite.
     */
    SELFCAL_ERROR_RECTIFY_LEFT_NOT_FINITE = 810,
    /**
     * Rectify: a point on the border of the left image is outside it.
     */
    SELFCAL_ERROR_RECTIFY_LEFT_OUTSIDE_IMAGE = 811,
    /**
     * Rectify: the lens model is not invertible on the border of the left image.
     */
    SELFCAL_ERROR_RECTIFY_LEFT_NOT_INVERTIBLE = 812,
    /**
     * Rectify: the left image border lies behind the rectified plane: turned too far.
     */
    SELFCAL_ERROR_RECTIFY_LEFT_BEHIND = 813,
    /**
     * Rectify: a point on the border of the right image is not finite.
     */
    SELFCAL_ERROR_RECTIFY_RIGHT_NOT_FINITE = 820,
    /**
     * Rectify: a point on the border of the right image is outside it.
     */
    SELFCAL_ERROR_RECTIFY_RIGHT_OUTSIDE_IMAGE = 821,
    /**
     * Rectify: the lens model is not invertible on the border of the right image.
     */
    SELFCAL_ERROR_RECTIFY_RIGHT_NOT_INVERTIBLE = 822,
    /**
     * Rectify: the right image border lies behind the rectified plane: turned too far.
     */
    SELFCAL_ERROR_RECTIFY_RIGHT_BEHIND = 823,
    /**
     * Snapshot: the record takes more room than there is.
     */
    SELFCAL_ERROR_SNAPSHOT_ROOM = 900,
    /**
     * Snapshot: `selfcal_set_cameras` comes first; a record is of one rig.
     */
    SELFCAL_ERROR_SNAPSHOT_NO_CAMERAS = 901,
    /**
     * Restore: the checksum of the record is wrong, or it ends where it should not. Use an older one.
     */
    SELFCAL_ERROR_RESTORE_DAMAGED = 1000,
    /**
     * Restore: it is a record of something else.
     */
    SELFCAL_ERROR_RESTORE_FOREIGN = 1001,
    /**
     * Restore: the record was written by later firmware, in a layout that is not known.
     */
    SELFCAL_ERROR_RESTORE_VERSION = 1002,
    /**
     * Restore: the numbers of the record are not of type float.
     */
    SELFCAL_ERROR_RESTORE_SCALAR = 1003,
    /**
     * Restore: the record is of the other preset.
     */
    SELFCAL_ERROR_RESTORE_PRESET = 1004,
    /**
     * Restore: it was learnt with other cameras or from other factory extrinsics. Start afresh.
     */
    SELFCAL_ERROR_RESTORE_OTHER_RIG = 1005,
    /**
     * Restore: a quantity of the record cannot be; it was not written by this library.
     */
    SELFCAL_ERROR_RESTORE_ABSURD = 1006,
    /**
     * Restore: further from the factory extrinsics than the correction limit is now.
     */
    SELFCAL_ERROR_RESTORE_CORRECTION_LIMIT = 1007,
    /**
     * Restore: the calibrator has learnt something already, or is solving a pair.
     */
    SELFCAL_ERROR_RESTORE_NOT_FRESH = 1008,
    /**
     * Restore: `selfcal_set_cameras` comes first.
     */
    SELFCAL_ERROR_RESTORE_NO_CAMERAS = 1009,
    /**
     * Link: a pair is being solved; no byte was used. Finish it or clear it, then feed on.
     */
    SELFCAL_ERROR_LINK_BUSY = 1100,
    /**
     * Link: `selfcal_set_cameras` comes first. The frame is not taken; feed on.
     */
    SELFCAL_ERROR_LINK_NO_CAMERAS = 1101,
    /**
     * Link: the matcher's images are not of the cameras' size. The frame is not taken; feed on.
     */
    SELFCAL_ERROR_LINK_IMAGE_SIZE = 1102,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_error_t selfcal_error_t;
#else
typedef int32_t selfcal_error_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What became of a valid correspondence.
 */
enum selfcal_pushed_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * There was room for it.
     */
    SELFCAL_PUSHED_KEPT = 0,
    /**
     * It is in the batch, and another one left.
     */
    SELFCAL_PUSHED_REPLACED = 1,
    /**
     * The full batch is worth more without it.
     */
    SELFCAL_PUSHED_LEFT_OUT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_pushed_t selfcal_pushed_t;
#else
typedef uint32_t selfcal_pushed_t;
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
     * The step fell below the tolerance.
     */
    SELFCAL_STOP_CONVERGED = 0,
    /**
     * No step lowers the cost any more: the optimum to the resolution of the numbers.
     */
    SELFCAL_STOP_NO_DESCENT = 1,
    /**
     * The allowed passes are used up; the result is the best seen.
     */
    SELFCAL_STOP_PASS_LIMIT = 2,
    /**
     * The core gave a reason that this API does not know yet.
     */
    SELFCAL_STOP_UNKNOWN = 255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_stop_t selfcal_stop_t;
#else
typedef uint32_t selfcal_stop_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What became of a fused pair.
 */
enum selfcal_fused_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * It is part of the estimate.
     */
    SELFCAL_FUSED_ADDED = 0,
    /**
     * It shows the scene of the pair before it, in whose place it counts.
     */
    SELFCAL_FUSED_REPEATED = 1,
    /**
     * It disagrees with the estimate and is kept apart, for another one.
     */
    SELFCAL_FUSED_KEPT_APART = 2,
    /**
     * It is part of the estimate, and the pairs of late have replaced the older ones.
     */
    SELFCAL_FUSED_RENEWED = 3,
    /**
     * The pairs kept apart agree with each other: theirs is the estimate now.
     */
    SELFCAL_FUSED_TOOK_OVER = 4,
    /**
     * The core gave an outcome that this API does not know yet.
     */
    SELFCAL_FUSED_UNKNOWN = 255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_fused_t selfcal_fused_t;
#else
typedef uint32_t selfcal_fused_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How far the estimate can be relied on.
 */
enum selfcal_state_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Not enough pairs agree yet.
     */
    SELFCAL_STATE_ACQUIRING = 0,
    /**
     * The last pair agrees with the estimate.
     */
    SELFCAL_STATE_LOCKED = 1,
    /**
     * The last pairs disagree with the estimate, or some did and speak for another.
     */
    SELFCAL_STATE_SUSPECT = 2,
    /**
     * Ten pairs in a row disagree with the estimate, and no three with each other.
     */
    SELFCAL_STATE_LOST = 3,
    /**
     * The core gave a state that this API does not know yet.
     */
    SELFCAL_STATE_UNKNOWN = 255,
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
     * None: the paper preset does not tell.
     */
    SELFCAL_DIRECTION_NONE = 0,
    /**
     * Turn of `R` about x: shifts all rows alike.
     */
    SELFCAL_DIRECTION_PITCH = 1,
    /**
     * Turn of `R` about y: shears rows with the product of column and row.
     */
    SELFCAL_DIRECTION_YAW = 2,
    /**
     * Turn of `R` about z: tilts rows.
     */
    SELFCAL_DIRECTION_ROLL = 3,
    /**
     * Turn of the baseline about y: `t_z`.
     */
    SELFCAL_DIRECTION_BASELINE_FORWARD = 4,
    /**
     * Turn of the baseline about z: `t_y`.
     */
    SELFCAL_DIRECTION_BASELINE_DOWN = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_direction_t selfcal_direction_t;
#else
typedef uint32_t selfcal_direction_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What speaks against an estimate.
 */
enum selfcal_doubt_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Nothing.
     */
    SELFCAL_DOUBT_NONE = 0,
    /**
     * Image halves disagree by more than 3 standard deviations: `t` is not applied.
     */
    SELFCAL_DOUBT_BASELINE = 1,
    /**
     * They disagree by more than 5: nothing is applied.
     */
    SELFCAL_DOUBT_EVERYTHING = 2,
    /**
     * Paper preset: the rotation is so near the identity, or a half turn, that its axis is noise.
     */
    SELFCAL_DOUBT_AXIS = 3,
    /**
     * The core gave a doubt that this API does not know yet.
     */
    SELFCAL_DOUBT_UNKNOWN = 255,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_doubt_t selfcal_doubt_t;
#else
typedef uint32_t selfcal_doubt_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What to make of the extrinsics in use, by the RMS row offset.
 */
enum selfcal_band_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Below 1 px, and the estimate would not improve it by a tenth.
     */
    SELFCAL_BAND_GOOD = 0,
    /**
     * Below 1 px, but the estimate fits better by a tenth or more.
     */
    SELFCAL_BAND_IMPROVABLE = 1,
    /**
     * 1 px or more: a matcher that searches along rows will miss.
     */
    SELFCAL_BAND_RECALIBRATE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_band_t selfcal_band_t;
#else
typedef uint32_t selfcal_band_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Yes or no to an arming check, and the reason.
 */
enum selfcal_arming_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * The extrinsics in use fit a confirmed estimate.
     */
    SELFCAL_ARMING_YES = 0,
    /**
     * The estimate is not confirmed, or the last pairs disagree with it.
     */
    SELFCAL_ARMING_NOT_LOCKED = 1,
    /**
     * Image halves disagree too much to trust any estimate.
     */
    SELFCAL_ARMING_DOUBTFUL = 2,
    /**
     * The extrinsics in use do not fit the matches.
     */
    SELFCAL_ARMING_MISALIGNED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_arming_t selfcal_arming_t;
#else
typedef uint32_t selfcal_arming_t;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Central tendency of the pairs' angles in fusion; paper preset.
 */
enum selfcal_angle_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Arithmetic mean: efficient where no pair is grossly wrong.
     */
    SELFCAL_ANGLE_MEAN = 0,
    /**
     * Median: unmoved by a minority of wrong pairs.
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
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum selfcal_lens_t selfcal_lens_t;
#else
typedef uint32_t selfcal_lens_t;
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
     * Left: the origin of the rig, `p_r = R p_l + t`.
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
 * Which extrinsics to rectify for.
 */
enum selfcal_source_t
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Those in use.
     */
    SELFCAL_SOURCE_IN_USE = 0,
    /**
     * The estimate.
     */
    SELFCAL_SOURCE_PROPOSED = 1,
    /**
     * What `selfcal_apply` would put into use.
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
 * What the library was built for.
 */
typedef struct selfcal_requirements_t {
    /**
     * Bytes of storage that it really uses.
     */
    size_t size;
    /**
     * Alignment that it really needs, bytes.
     */
    size_t align;
    /**
     * Correspondences a pair.
     */
    size_t capacity;
} selfcal_requirements_t;

/**
 * A calibrator of one stereo rig. The caller owns it, statically or wherever it likes; it holds no
 * pointers and nothing needs to be released. One call at a time; calibrators are independent.
 */
typedef struct selfcal_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_STORAGE_WORDS];
} selfcal_t;

/**
 * Parameters of a calibrator. Private: begin with `selfcal_config_default`, `selfcal_config_robust`
 * or `selfcal_config_paper`, then change it with the setters.
 */
typedef struct selfcal_config_t {
    /**
     * Private, as all that follows.
     */
    uint32_t magic;
    /**
     * Which preset.
     */
    uint32_t preset;
    /**
     * NaN, or 0 of an integer: that of the preset.
     */
    float prior_sd_rad;
    float huber_threshold_px;
    float step_tolerance_rad;
    float noise_floor_px;
    float max_sd_rad;
    float max_correction_rad;
    uint32_t memory_pairs;
    uint16_t max_passes;
    uint16_t min_correspondences;
    uint32_t angle;
    uint32_t automatic_apply;
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
     * Lens coefficients in OpenCV's order, dimensionless; 0 where the model has none.
     */
    float distortion[5];
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
     * `t`: position of the left camera in the right camera frame. Unit length where it comes out, any
     * length where it goes in.
     */
    float translation[3];
} selfcal_extrinsics_t;

/**
 * One left/right correspondence, in the images as they are, before undistortion.
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
     * The matcher's confidence, 0 (none) to 1 (certain).
     */
    float score;
    /**
     * Step of the grid that the coordinates were found on, px, 0 to 255.99: 1 for whole pixels, 0
     * where they are continuous.
     */
    float grid_step_px;
} selfcal_correspondence_t;

/**
 * What became of an array of correspondences.
 */
typedef struct selfcal_pushed_counts_t {
    /**
     * There was room for.
     */
    size_t kept;
    /**
     * In the batch, each in place of another one.
     */
    size_t replaced;
    /**
     * Valid, but the full batch is worth more without them.
     */
    size_t left_out;
    /**
     * Not valid.
     */
    size_t refused;
    /**
     * Why the first of these was refused; `SELFCAL_OK` if none was.
     */
    selfcal_error_t first_refusal;
} selfcal_pushed_counts_t;

/**
 * What the batch holds.
 */
typedef struct selfcal_batch_t {
    /**
     * Correspondences at hand.
     */
    uint32_t held;
    /**
     * Offered since the batch was last cleared: at hand, left out or refused.
     */
    uint32_t offered;
    /**
     * Valid ones that had to leave a full batch, or did not get in.
     */
    uint32_t left_out;
    /**
     * Refused ones.
     */
    uint32_t refused;
} selfcal_batch_t;

/**
 * What looks for the frames of a matcher in the bytes of a driver. The caller owns it, as a `selfcal_t`;
 * it holds no frame, only the place in one. One for each wire.
 */
typedef struct selfcal_link_t {
    /**
     * Private.
     */
    uint64_t opaque[SELFCAL_LINK_STORAGE_WORDS];
} selfcal_link_t;

/**
 * A whole frame and what was taken of it. All 0 where none is whole.
 */
typedef struct selfcal_frame_t {
    /**
     * When the images were taken: the matcher's clock, us; 0 without one. Not interpreted.
     */
    uint64_t timestamp_us;
    /**
     * Number of the frame; wraps around.
     */
    uint32_t sequence;
    /**
     * Matches in the frame.
     */
    uint32_t count;
    /**
     * Matches of it that the batch holds: a full one selects, and what is not valid is refused. See
     * `selfcal_batch`.
     */
    uint32_t taken;
    /**
     * Whether a frame is whole now: its matches are the batch. Solve it before you feed on.
     */
    bool whole;
    /**
     * The matcher dropped frames right before this one: nobody read them.
     */
    bool dropped_before;
    /**
     * The matcher found more matches than it sends.
     */
    bool more_found;
    /**
     * 0.
     */
    uint8_t reserved;
} selfcal_frame_t;

/**
 * What a link has been through since `selfcal_link_init`. Counts stay at their largest value.
 */
typedef struct selfcal_link_counters_t {
    /**
     * Frames handed out whole.
     */
    uint32_t good;
    /**
     * Frames whose CRC was wrong: look at the wiring and the clock of the bus.
     */
    uint32_t bad_crc;
    /**
     * Starts of a frame whose header had a wrong CRC.
     */
    uint32_t bad_header;
    /**
     * Headers or frames with a right CRC that version 1 of the format does not have: correct the sender.
     */
    uint32_t unsupported;
    /**
     * Frames that the next one began inside of: bytes are being lost.
     */
    uint32_t truncated;
    /**
     * Frames that never came whole, by the sequence numbers of those that did.
     */
    uint32_t gaps;
    /**
     * Frames with the sequence number of the frame before; not handed out.
     */
    uint32_t repeats;
    /**
     * Steps back in the sequence: the sender was restarted.
     */
    uint32_t restarts;
    /**
     * Whole frames before which the sender had dropped some, and calls of `selfcal_link_note_overrun`.
     */
    uint32_t overruns;
    /**
     * Frames that were refused: no cameras, or images of another size.
     */
    uint32_t refused;
    /**
     * Bytes passed over in search of a frame.
     */
    uint32_t skipped_bytes;
} selfcal_link_counters_t;

/**
 * What one pair says.
 */
typedef struct selfcal_report_t {
    /**
     * `R`, `t` of the pair alone.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * Information about them, 1/rad^2, symmetric. Order: turn of `R` about x, y, z, turn of the
     * baseline about y, z, in the rectified frame.
     */
    float information[5][5];
    /**
     * Why the solver stopped.
     */
    selfcal_stop_t stop;
    /**
     * Passes taken over the batch.
     */
    uint16_t passes;
    /**
     * Correspondences in front of both rectified cameras.
     */
    uint32_t usable;
    /**
     * Correspondences left out because they are not.
     */
    uint32_t skipped;
    /**
     * Usable ones that fit the solution.
     */
    uint32_t screened;
    /**
     * Cost at the start, px^2.
     */
    float cost_before;
    /**
     * Cost at the solution, px^2.
     */
    float cost_after;
    /**
     * RMS row offset of the screened correspondences at the start, px.
     */
    float rms_px_before;
    /**
     * The same at the solution, px.
     */
    float rms_px_after;
    /**
     * Estimated standard deviation, px: robust preset, of a coordinate; paper preset, of a row offset.
     */
    float noise_px;
} selfcal_report_t;

/**
 * Expected size of the error of an estimate.
 */
typedef struct selfcal_sd_t {
    /**
     * Of `R`, rad.
     */
    float rotation_rad;
    /**
     * Of the direction of `t`, rad.
     */
    float translation_rad;
} selfcal_sd_t;

/**
 * The least certain direction of an estimate.
 */
typedef struct selfcal_weakest_t {
    /**
     * Which; `SELFCAL_DIRECTION_NONE` in the paper preset.
     */
    selfcal_direction_t direction;
    /**
     * Its standard deviation, rad; 0 in the paper preset.
     */
    float sd_rad;
} selfcal_weakest_t;

/**
 * The estimate over all pairs so far.
 */
typedef struct selfcal_proposal_t {
    /**
     * The best `R`, `t`.
     */
    struct selfcal_extrinsics_t extrinsics;
    /**
     * What `selfcal_apply` puts into use: the same, but where the baseline is doubted `t` is that in
     * use, and `R` the best there is with it.
     */
    struct selfcal_extrinsics_t applicable;
    /**
     * Pairs behind it; those of a repeated scene count once.
     */
    uint32_t pairs;
    /**
     * Expected size of the error.
     */
    struct selfcal_sd_t sd;
    /**
     * Whether there is a covariance: not in the paper preset.
     */
    bool has_covariance;
    /**
     * Covariance, rad^2, symmetric; 0 without. Order: turn of `R` about x, y, z, turn of the baseline
     * about y, z, in the rectified frame.
     */
    float covariance[5][5];
    /**
     * The least certain direction.
     */
    struct selfcal_weakest_t weakest;
    /**
     * Whether it is confirmed. The paper preset confirms nothing: locked from the first pair on.
     */
    selfcal_state_t state;
    /**
     * What speaks against it.
     */
    selfcal_doubt_t doubt;
} selfcal_proposal_t;

/**
 * How what is in use and the estimate fit the batch at hand. The two RMS are over the same matches:
 * those that fit the estimate.
 */
typedef struct selfcal_health_t {
    /**
     * RMS row offset of the extrinsics in use, px; 0 is perfect.
     */
    float in_use_px;
    /**
     * RMS row offset of the proposed extrinsics, px.
     */
    float proposed_px;
    /**
     * Matches that fit the extrinsics in use.
     */
    uint32_t fit_in_use;
    /**
     * Matches that fit the proposed extrinsics.
     */
    uint32_t fit_proposed;
    /**
     * Share of the cells of an 8 x 6 grid over the left image with a match that fits, 0 to 1.
     */
    float coverage;
    /**
     * What to make of the two RMS.
     */
    selfcal_band_t band;
    /**
     * Whether the estimate is confirmed.
     */
    selfcal_state_t state;
    /**
     * What speaks against it.
     */
    selfcal_doubt_t doubt;
    /**
     * Expected size of the error of the estimate.
     */
    struct selfcal_sd_t sd;
    /**
     * Its least certain direction.
     */
    struct selfcal_weakest_t weakest;
    /**
     * Expected error of the yaw in use, rad.
     */
    float yaw_rad;
    /**
     * Why the last pair was not taken in; `SELFCAL_OK` if it was.
     */
    selfcal_error_t rejection;
    /**
     * Yes or no to an arming check.
     */
    selfcal_arming_t arming;
} selfcal_health_t;

/**
 * Rectifying rotations `R_l`, `R_r`: rows of both rectified views coincide.
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
 * The common camera of both rectified views, without distortion.
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

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * What an error code means, in English; never null, `"unknown"` for other numbers.
 */
const char *selfcal_error_string(int32_t error);

/**
 * Says what the library was built for: to size storage at run time, or to compare with the header.
 *
 * * `requirements`: the answer.
 */
selfcal_error_t selfcal_requirements(struct selfcal_requirements_t *requirements);

/**
 * Makes a calibrator without cameras, at `R = I`, `t = (-1, 0, 0)`. Comes before all other calls; on
 * a calibrator in use it begins anew.
 *
 * * `cal`: a `selfcal_t`, or other storage that is large enough.
 * * `size`: of the storage, bytes: `sizeof(selfcal_t)`.
 * * `config`: copied; null for the default.
 */
selfcal_error_t selfcal_init(struct selfcal_t *cal,
                             size_t size,
                             const struct selfcal_config_t *config);

/**
 * Back to the factory extrinsics: batch, report and fused pairs are forgotten. Not frozen any more.
 */
selfcal_error_t selfcal_reset(struct selfcal_t *cal);

/**
 * The default: the robust preset.
 */
selfcal_error_t selfcal_config_default(struct selfcal_config_t *config);

/**
 * The robust preset: survives half of the matches being wrong, follows a knock in three pairs.
 */
selfcal_error_t selfcal_config_robust(struct selfcal_config_t *config);

/**
 * The method as published: its only defence against mismatches is the Huber weight.
 */
selfcal_error_t selfcal_config_paper(struct selfcal_config_t *config);

/**
 * Standard deviation of the factory extrinsics about each axis; robust preset.
 *
 * * `rad`: 1e-4 to 1; default 0.1. Larger follows a rig that is further off; smaller steadies pairs
 *   that say little.
 */
selfcal_error_t selfcal_config_set_prior_sd_rad(struct selfcal_config_t *config, float rad);

/**
 * Huber threshold of the row offset; paper preset, and three times it screens for the health.
 *
 * * `px`: finite and above 0; default 1. Larger trusts more matches and bends to mismatches.
 */
selfcal_error_t selfcal_config_set_huber_threshold_px(struct selfcal_config_t *config, float px);

/**
 * Passes over the batch that a pair may take: the bound on its time.
 *
 * * `passes`: 2 or more; default 12 in the robust preset, which takes up to 9 where it is lower and
 *   twice as many with at most 128 matches; 100 in the paper preset.
 */
selfcal_error_t selfcal_config_set_max_passes(struct selfcal_config_t *config, uint16_t passes);

/**
 * The solver has converged when its step is below this.
 *
 * * `rad`: 0 to 0.1; default 1e-9, which is never taken as smaller than 1e-6.
 */
selfcal_error_t selfcal_config_set_step_tolerance_rad(struct selfcal_config_t *config, float rad);

/**
 * Fewest usable correspondences that a pair is solved from.
 *
 * * `count`: 6 or more; default 12.
 */
selfcal_error_t selfcal_config_set_min_correspondences(struct selfcal_config_t *config,
                                                       uint16_t count);

/**
 * Smallest noise believed: keeps the certainty finite on data without noise.
 *
 * * `px`: finite and above 0; default 0.15 of a coordinate in the robust preset, 0.02 of a row
 *   offset in the paper preset.
 */
selfcal_error_t selfcal_config_set_noise_floor_px(struct selfcal_config_t *config, float px);

/**
 * Central tendency of the pairs' angles in fusion; paper preset.
 *
 * * `angle`: a `selfcal_angle_t`; default the mean.
 */
selfcal_error_t selfcal_config_set_angle(struct selfcal_config_t *config, uint32_t angle);

/**
 * A pair whose weakest direction is less certain than this is refused; paper preset.
 *
 * * `rad`: finite and above 0; default 0.12.
 */
selfcal_error_t selfcal_config_set_max_sd_rad(struct selfcal_config_t *config, float rad);

/**
 * A pair that is further from the factory extrinsics than this is refused.
 *
 * * `rad`: above 0 and below 1.5; default 0.5.
 */
selfcal_error_t selfcal_config_set_max_correction_rad(struct selfcal_config_t *config, float rad);

/**
 * Pairs after which the oldest fade; robust preset.
 *
 * * `pairs`: 20 or more; default 1000. Larger averages longer; smaller follows a slow drift.
 */
selfcal_error_t selfcal_config_set_memory_pairs(struct selfcal_config_t *config, uint32_t pairs);

/**
 * Lets `selfcal_fuse` put the estimate into use whenever `selfcal_apply` would. Default: it does not.
 */
selfcal_error_t selfcal_config_set_automatic_apply(struct selfcal_config_t *config,
                                                   bool automatic);

/**
 * Sets both cameras and forgets all that was learnt with others.
 */
selfcal_error_t selfcal_set_cameras(struct selfcal_t *cal,
                                    const struct selfcal_camera_t *left,
                                    const struct selfcal_camera_t *right);

/**
 * The cameras, as they were set.
 */
selfcal_error_t selfcal_cameras(const struct selfcal_t *cal,
                                struct selfcal_camera_t *left,
                                struct selfcal_camera_t *right);

/**
 * Undistorts: the ray at unit depth through a pixel.
 *
 * * `side`: a `selfcal_side_t`.
 * * `pixel`: column u, row v in the image as it is, px.
 * * `ray`: x, y at z = 1, camera frame, dimensionless.
 *
 */
selfcal_error_t selfcal_ray(const struct selfcal_t *cal,
                            uint32_t side,
                            const float pixel[2],
                            float ray[2]);

/**
 * Distorts: the pixel of a ray at unit depth, wherever it falls.
 *
 * * `side`: a `selfcal_side_t`.
 * * `ray`: x, y at z = 1, camera frame, dimensionless.
 * * `pixel`: column u, row v in the image as it is, px; the image bounds are not applied.
 *
 */
selfcal_error_t selfcal_pixel(const struct selfcal_t *cal,
                              uint32_t side,
                              const float ray[2],
                              float pixel[2]);

/**
 * `R = I`, `t = (-1, 0, 0)`: two parallel cameras side by side.
 */
selfcal_error_t selfcal_side_by_side(struct selfcal_extrinsics_t *extrinsics);

/**
 * Sets the extrinsics that pairs start from, that corrections are measured from and that
 * `selfcal_reset` returns to; forgets all that was learnt.
 *
 * * `factory`: `R` orthonormal to about 0.1, `t` of any length.
 */
selfcal_error_t selfcal_set_factory(struct selfcal_t *cal,
                                    const struct selfcal_extrinsics_t *factory);

/**
 * The extrinsics in use.
 */
selfcal_error_t selfcal_in_use(const struct selfcal_t *cal,
                               struct selfcal_extrinsics_t *extrinsics);

/**
 * Changes exactly when the extrinsics in use do; wraps around.
 */
selfcal_error_t selfcal_generation(const struct selfcal_t *cal, uint32_t *generation);

/**
 * Offers one correspondence to the batch, which selects once it is full: matches spread over the left
 * image stay, of neighbours those with the better score.
 *
 * * `pushed`: what became of it; may be null.
 */
selfcal_error_t selfcal_push(struct selfcal_t *cal,
                             const struct selfcal_correspondence_t *correspondence,
                             selfcal_pushed_t *pushed);

/**
 * Offers an array of correspondences, one after the other. Some of them being refused is no error:
 * it is counted. Without cameras, or while a pair is being solved, none is offered.
 *
 * * `correspondences`: `count` of them; may be null where that is 0.
 * * `counts`: what became of them; may be null.
 */
selfcal_error_t selfcal_push_array(struct selfcal_t *cal,
                                   const struct selfcal_correspondence_t *correspondences,
                                   size_t count,
                                   struct selfcal_pushed_counts_t *counts);

/**
 * What the batch holds.
 */
selfcal_error_t selfcal_batch(const struct selfcal_t *cal, struct selfcal_batch_t *batch);

/**
 * A `selfcal_pushed_t` in words, English; never null.
 */
const char *selfcal_pushed_string(uint32_t pushed);

/**
 * Makes a link in search of its first frame. Comes before all other calls; on a link in use it begins
 * anew, and a frame half read is lost.
 *
 * * `size`: of the storage, bytes: `sizeof(selfcal_link_t)`.
 */
selfcal_error_t selfcal_link_init(struct selfcal_link_t *link,
                                  size_t size);

/**
 * Takes bytes as they come off the wire, in pieces of any length, up to the end of the first whole frame.
 * A frame replaces the batch. What was damaged or lost on the way costs the frames it hit; the next one
 * is found.
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
 * Push nothing and begin no pair while a frame comes in: half of it is in the batch. A pair that is being
 * solved is not given up for a frame: `SELFCAL_ERROR_LINK_BUSY`, nothing is used, and the same bytes are
 * to be fed later. After the other `SELFCAL_ERROR_LINK_` codes feed the rest: the frame is passed over,
 * and the batch is as it was. What was solved is forgotten with the batch: fuse it before.
 *
 * * `bytes`: `length` of them; may be null where that is 0. Not needed after the call.
 * * `used`: how many of them are done with, with errors too; 0 where nothing was done.
 * * `frame`: the frame, if one is whole now; all 0 if none is, and with errors.
 */
selfcal_error_t selfcal_link_feed(struct selfcal_link_t *link,
                                  struct selfcal_t *cal,
                                  const uint8_t *bytes,
                                  size_t length,
                                  size_t *used,
                                  struct selfcal_frame_t *frame);

/**
 * Counts an overrun on this side of the wire: a ring that was lapped, a UART that says so. Then feed on:
 * the next whole frame is found.
 */
selfcal_error_t selfcal_link_note_overrun(struct selfcal_link_t *link);

/**
 * What the link has been through.
 */
selfcal_error_t selfcal_link_counters(const struct selfcal_link_t *link,
                                      struct selfcal_link_counters_t *counters);

/**
 * Starts to solve the batch: the first pass over it. Then call `selfcal_advance_pair`. The report of
 * the pair before is forgotten.
 */
selfcal_error_t selfcal_begin_pair(struct selfcal_t *cal);

/**
 * Takes one more pass over the batch, or two to judge a pair that is solved.
 *
 * * `solved`: whether the pair is solved: then fuse it before the batch is cleared.
 */
selfcal_error_t selfcal_advance_pair(struct selfcal_t *cal, bool *solved);

/**
 * Solves the batch in one call: all passes. Fuse the pair before the batch is cleared.
 */
selfcal_error_t selfcal_solve_pair(struct selfcal_t *cal);

/**
 * What the last pair says, once it is solved and until the batch is begun anew or cleared.
 */
selfcal_error_t selfcal_report(const struct selfcal_t *cal, struct selfcal_report_t *report);

/**
 * Takes the solved pair into the estimate, once. What is in use does not change, unless
 * `selfcal_config_set_automatic_apply` lets it.
 *
 * * `fused`: what became of it; may be null.
 */
selfcal_error_t selfcal_fuse(struct selfcal_t *cal, selfcal_fused_t *fused);

/**
 * Empties the batch, forgets the report and abandons a pair being solved.
 */
selfcal_error_t selfcal_clear_pair(struct selfcal_t *cal);

/**
 * A `selfcal_stop_t` in words, English; never null.
 */
const char *selfcal_stop_string(uint32_t stop);

/**
 * A `selfcal_fused_t` in words, English; never null.
 */
const char *selfcal_fused_string(uint32_t fused);

/**
 * How far the estimate can be relied on.
 */
selfcal_error_t selfcal_state(const struct selfcal_t *cal, selfcal_state_t *state);

/**
 * The estimate over all fused pairs.
 */
selfcal_error_t selfcal_proposal(const struct selfcal_t *cal, struct selfcal_proposal_t *proposal);

/**
 * A `selfcal_state_t` in words, English; never null.
 */
const char *selfcal_state_string(uint32_t state);

/**
 * A `selfcal_doubt_t` in words, English; never null.
 */
const char *selfcal_doubt_string(uint32_t doubt);

/**
 * A `selfcal_direction_t` in words, English; never null.
 */
const char *selfcal_direction_string(uint32_t direction);

/**
 * How what is in use and the estimate fit the batch at hand: ask before the batch is cleared. One
 * pass over it.
 */
selfcal_error_t selfcal_health(const struct selfcal_t *cal, struct selfcal_health_t *health);

/**
 * Expected error of depth with the extrinsics in use, at 1, 2, 5 and 10 m in the middle of the
 * image. One pass over the batch. A matcher's own noise is not in it.
 *
 * * `baseline_m`: length of the baseline, m; finite and above 0.
 * * `errors`: m.
 *
 */
selfcal_error_t selfcal_depth_errors(const struct selfcal_t *cal,
                                     float baseline_m,
                                     float errors[4]);

/**
 * A `selfcal_band_t` in words, English; never null.
 */
const char *selfcal_band_string(uint32_t band);

/**
 * A `selfcal_arming_t` in words, English; never null.
 */
const char *selfcal_arming_string(uint32_t arming);

/**
 * Puts the estimate into use. The generation changes if the extrinsics do.
 *
 * * `applied`: what is in use now; may be null.
 */
selfcal_error_t selfcal_apply(struct selfcal_t *cal, struct selfcal_extrinsics_t *applied);

/**
 * Puts back what was in use before the last change, once; the estimate stays.
 *
 * * `restored`: what is in use now; may be null.
 */
selfcal_error_t selfcal_undo(struct selfcal_t *cal, struct selfcal_extrinsics_t *restored);

/**
 * Freezes both the estimate and what is in use, or lets go of them again.
 */
selfcal_error_t selfcal_set_frozen(struct selfcal_t *cal, bool frozen);

/**
 * Whether the calibrator is frozen.
 */
selfcal_error_t selfcal_is_frozen(const struct selfcal_t *cal, bool *frozen);

/**
 * The two rectifying rotations.
 *
 * * `source`: a `selfcal_source_t`.
 */
selfcal_error_t selfcal_rotations(const struct selfcal_t *cal,
                                  uint32_t source,
                                  struct selfcal_rotations_t *rectifying);

/**
 * Chooses a camera for rectified images of the left camera's size, for cameras side by side. 136
 * undistortions: call it when the generation changes, not per frame.
 *
 * * `source`: a `selfcal_source_t`.
 * * `alpha`: 0 zooms in until both cameras see every rectified pixel, 1 zooms out until every pixel
 *   of both is kept.
 */
selfcal_error_t selfcal_choose_camera(const struct selfcal_t *cal,
                                      uint32_t source,
                                      float alpha,
                                      struct selfcal_rectified_camera_t *camera);

/**
 * The two rectifying homographies for a rectified camera, chosen or one's own.
 *
 * * `source`: a `selfcal_source_t`.
 */
selfcal_error_t selfcal_homographies(const struct selfcal_t *cal,
                                     uint32_t source,
                                     const struct selfcal_rectified_camera_t *camera,
                                     struct selfcal_homographies_t *homographies);

/**
 * Writes all that was learnt as a record, to be kept where power loss does not reach. Not in it: cameras
 * and factory extrinsics, see `selfcal_factory_to_record`; the batch, and a pair being solved.
 *
 * The record is versioned, has its own checksum, and is the same on every machine. Keep the one before
 * until the new one is written: `selfcal_restore` recognises one that power loss has cut short.
 *
 * * `buffer`: where to; `SELFCAL_SNAPSHOT_BYTES` are always enough. What the record leaves of these is
 *   set to 0. May be null where `room` is 0.
 * * `room`: of the buffer, bytes.
 * * `length`: of the record, bytes; to be kept with it. Also set by `SELFCAL_ERROR_SNAPSHOT_ROOM`, after
 *   which the buffer holds no record.
 */
selfcal_error_t selfcal_snapshot(const struct selfcal_t *cal,
                                 uint8_t *buffer,
                                 size_t room,
                                 size_t *length);

/**
 * Takes up where a record left off: what was in use is in use, and the pairs behind the estimate count,
 * as if there had been no break. But the rig may have changed meanwhile: the state is
 * `SELFCAL_STATE_SUSPECT` until a pair confirms the estimate.
 *
 * For a calibrator that has learnt nothing yet, right after its cameras and factory extrinsics have been
 * set. Refused: it is as it was, and the rig starts from the factory.
 *
 * * `record`: from `selfcal_snapshot`, also of another machine, another capacity or an older version.
 * * `length`: what `selfcal_snapshot` gave as such.
 */
selfcal_error_t selfcal_restore(struct selfcal_t *cal,
                                const uint8_t *record,
                                size_t length);

/**
 * Writes cameras and factory extrinsics as a record: once, in production.
 *
 * * `buffer`: where to; `SELFCAL_FACTORY_BYTES` are always enough. What the record leaves of these is set
 *   to 0. May be null where `room` is 0.
 * * `room`: of the buffer, bytes.
 * * `length`: of the record, bytes; to be kept with it. Also set by `SELFCAL_ERROR_SNAPSHOT_ROOM`, after
 *   which the buffer holds no record.
 */
selfcal_error_t selfcal_factory_to_record(const struct selfcal_t *cal,
                                          uint8_t *buffer,
                                          size_t room,
                                          size_t *length);

/**
 * Sets cameras and factory extrinsics from a record, at each start; forgets all that was learnt. In the
 * place of `selfcal_set_cameras` and `selfcal_set_factory`, to the same bits as when it was written.
 *
 * * `record`: from `selfcal_factory_to_record`.
 * * `length`: what it gave as such.
 */
selfcal_error_t selfcal_factory_from_record(struct selfcal_t *cal,
                                            const uint8_t *record,
                                            size_t length);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* STEREO_SELFCAL_H */
