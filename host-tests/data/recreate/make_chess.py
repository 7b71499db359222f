"""OpenCV's chessboard pairs: calibrate them offline, then write two sets with that reference.

The first set holds the board's corners, the second the SIFT matches of the same images. The board is 9 x 6 inner
corners; the size of its squares is not published, so lengths are in squares and only t's direction is kept.

The reference is OpenCV's stereoCalibrate with the five-coefficient lens on every pair whose corners it explains to
MAX_ROW_RMS; a pair that is left out stays in the sets. R and t belong to the K and dist beside them.
"""
import argparse
import pathlib
import re

import cv2
import numpy as np

import common

COLS, ROWS = 9, 6
MAX_ROW_RMS = 0.5  # px, rectified rows of one pair's corners
BOARD = np.zeros((COLS * ROWS, 3), np.float32)
BOARD[:, :2] = np.mgrid[0:COLS, 0:ROWS].T.reshape(-1, 2)
COUNT_OR_EPS = cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS
CORNER_STOP = (COUNT_OR_EPS, 100, 1e-4)
CALIB_STOP = (COUNT_OR_EPS, 300, 1e-9)

SOURCE = "OpenCV samples/data left01..14.jpg right01..14.jpg, Debian package opencv-doc 4.6.0+dfsg-12"
CORNER_NOTES = ("chessboard corners of both images, raw distorted pixels; the same corners gave the ground truth; "
                "score is 1")
MATCH_NOTES = ("sift matches on the raw images, ratio 0.8 and mutual check only, natural outliers (repeated pattern); "
               "score = 1 - d1/d2")


def by_number(folder, side):
    """{"01": path of left01.jpg, ...}"""
    found = {}
    for path in sorted(pathlib.Path(folder).iterdir()):
        name = re.fullmatch(side + r"(\d\d)\.jpg", path.name)
        if name:
            found[name[1]] = path
    return found


def find_corners(left, right):
    """The board's corners in both images, in the same order, as two arrays (54 x 1 x 2, px); None if not found."""
    found_l, corners_l = cv2.findChessboardCorners(left, (COLS, ROWS))
    found_r, corners_r = cv2.findChessboardCorners(right, (COLS, ROWS))
    if not (found_l and found_r):
        return None
    # The search window has to stay below half the smallest distance of two corners in a row.
    spacing = min(np.linalg.norm(np.diff(corners.reshape(ROWS, COLS, 2), axis=1), axis=2).min()
                  for corners in (corners_l, corners_r))
    half = int(np.clip(0.4 * spacing, 2, 11))
    corners_l = cv2.cornerSubPix(left, corners_l, (half, half), (-1, -1), CORNER_STOP)
    corners_r = cv2.cornerSubPix(right, corners_r, (half, half), (-1, -1), CORNER_STOP)
    if np.vdot(corners_l[-1] - corners_l[0], corners_r[-1] - corners_r[0]) < 0:
        corners_r = corners_r[::-1].copy()  # numbered from the board's other end
    return corners_l, corners_r


def calibrate(views, size):
    """Both cameras alone, then together: meta.json's K, dist, R and t (in squares), and the stereo RMS in px."""
    boards, lefts, rights = [BOARD] * len(views), *map(list, zip(*views))
    _, K_l, dist_l, _, _ = cv2.calibrateCamera(boards, lefts, size, None, None, flags=0, criteria=CALIB_STOP)
    _, K_r, dist_r, _, _ = cv2.calibrateCamera(boards, rights, size, None, None, flags=0, criteria=CALIB_STOP)
    rms, K_l, dist_l, K_r, dist_r, R, t, _, _ = cv2.stereoCalibrate(
        boards, lefts, rights, K_l, dist_l, K_r, dist_r, size,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS, criteria=CALIB_STOP)
    return dict(K_l=K_l, K_r=K_r, dist_l=dist_l.ravel()[:5], dist_r=dist_r.ravel()[:5], R=R, t=t.ravel()), rms


def calibrate_pose(views, size, held):
    """R and t with K and dist held."""
    boards, lefts, rights = [BOARD] * len(views), *map(list, zip(*views))
    fitted = cv2.stereoCalibrate(boards, lefts, rights, held["K_l"], held["dist_l"], held["K_r"], held["dist_r"],
                                 size, flags=cv2.CALIB_FIX_INTRINSIC)
    return dict(R=fitted[5], t=fitted[6].ravel())


def jackknife(views, reference, fit):
    """One standard error of R and of t's direction in degrees: fit again with each pair left out in turn."""
    turns, tilts = [], []
    for i in range(len(views)):
        other = fit(views[:i] + views[i + 1:])
        turns.append(np.linalg.norm(cv2.Rodrigues(other["R"] @ reference["R"].T)[0]))
        a, b = other["t"], reference["t"]
        tilts.append(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    n = len(views)
    return [float(np.degrees(np.sqrt((n - 1) / n * np.sum(np.square(x))))) for x in (turns, tilts)]


def as_matches(view):
    """A pair's corners as N x 5, with score 1."""
    return np.column_stack([view[0].reshape(-1, 2), view[1].reshape(-1, 2), np.ones(len(BOARD))])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", required=True, help="folder with left01.jpg, right01.jpg, ...")
    parser.add_argument("--corners", required=True, help="folder of the new set of corners")
    parser.add_argument("--matches", required=True, help="folder of the new set of SIFT matches")
    args = parser.parse_args()

    lefts, rights = by_number(args.images, "left"), by_number(args.images, "right")
    images, views = {}, {}
    for frame in sorted(lefts.keys() & rights.keys()):
        left, right = common.read_gray(lefts[frame]), common.read_gray(rights[frame])
        view = find_corners(left, right)
        if view is None:
            print(f"  pair {frame}: the board was not found in both images")
        else:
            images[frame], views[frame] = (left, right), view
    size = left.shape[::-1]

    print(f"  calibrating with {len(views)} pairs")
    first, rms = calibrate(list(views.values()), size)
    row_rms = {frame: np.sqrt(np.mean(common.residuals(first, as_matches(view))[0] ** 2))
               for frame, view in views.items()}
    kept = [frame for frame in views if row_rms[frame] <= MAX_ROW_RMS]
    left_out = [frame for frame in views if frame not in kept]
    print(f"  stereo RMS {rms:.3f} px; calibrating again without {' '.join(left_out)}, and with each pair left out")
    good = [views[frame] for frame in kept]
    fit, rms = calibrate(good, size)
    sigma = jackknife(good, fit, lambda some: calibrate(some, size)[0])
    sigma_held = jackknife(good, fit, lambda some: calibrate_pose(some, size, fit))
    print(f"  stereo RMS {rms:.3f} px; standard error of R {sigma[0]:.3f} deg, t {sigma[1]:.3f} deg; "
          f"with K and dist held {sigma_held[0]:.3f} and {sigma_held[1]:.3f} deg")

    fit["t"] = fit["t"] / np.linalg.norm(fit["t"])
    meta = dict(
        K_l=fit["K_l"], K_r=fit["K_r"], dist_l=fit["dist_l"], dist_r=fit["dist_r"], width=size[0], height=size[1],
        R=fit["R"], t=fit["t"], baseline_m=None, source=SOURCE, license="Apache-2.0 (OpenCV)",
        gt_sigma_R_deg=sigma[0], gt_sigma_t_deg=sigma[1],
        gt_sigma_R_given_K_deg=sigma_held[0], gt_sigma_t_given_K_deg=sigma_held[1],
        stereo_rms_px=float(rms), frames=list(views), calibrated_from=kept)
    common.write_set(args.corners, dict(meta, notes=CORNER_NOTES), [as_matches(view) for view in views.values()])
    print("  matching SIFT features")
    matches = [common.match_sift(left, right) for left, right in images.values()]
    common.write_set(args.matches, dict(meta, notes=MATCH_NOTES), matches)


main()
