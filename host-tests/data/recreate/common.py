"""Common parts of the makers: SIFT matching, residuals against the reference, writing a set.

Conventions
    p_r = R p_l + t    a point in the left camera's frame to the right camera's, |t| = 1
    pixels             of the raw image as recorded (distorted); the centre of the first pixel is (0, 0)
    dist               k1 k2 p1 p2 k3, OpenCV's order
"""
import json
import pathlib

import cv2
import numpy as np

RATIO = 0.8  # the best match has to be this much closer than the second best
MAX_FEATURES = 4000  # per image, the strongest ones


def read_gray(path):
    """The image as 8-bit grey, or stop with a message."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise SystemExit(f"error: cannot read the image {path}")
    return image


def match_sift(left, right):
    """SIFT matches of two grey images as an N x 5 array: ul, vl, ur, vr in px, and the score 1 - d1/d2.

    A match passes the ratio test from left to right and is the right feature's own nearest neighbour. Nothing
    geometric is checked, so the wrong matches stay in. SIFT may put several features (orientations) at one point:
    of matches with the same four coordinates the best score is kept.
    """
    sift = cv2.SIFT_create(nfeatures=MAX_FEATURES)
    points_l, desc_l = sift.detectAndCompute(left, None)
    points_r, desc_r = sift.detectAndCompute(right, None)
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    nearest_left = {m.queryIdx: m.trainIdx for m in matcher.match(desc_r, desc_l)}
    scores = {}
    for best, second in matcher.knnMatch(desc_l, desc_r, k=2):
        clear = best.distance < RATIO * second.distance
        if not clear or nearest_left[best.trainIdx] != best.queryIdx:
            continue
        uv_l, uv_r = points_l[best.queryIdx].pt, points_r[best.trainIdx].pt
        key = tuple(round(x, 3) for x in uv_l + uv_r)
        scores[key] = max(scores.get(key, 0.0), 1.0 - best.distance / second.distance)
    return np.array([key + (score,) for key, score in scores.items()])


def undistort(uv, K, dist):
    """Raw pixels (N x 2) to rays with z = 1 (N x 3), by fixed-point iteration to convergence."""
    k1, k2, p1, p2, k3 = dist
    distorted = (uv - [K[0, 2], K[1, 2]]) / [K[0, 0], K[1, 1]]
    x, y = distorted.T
    for _ in range(60):
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        shift_x = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        shift_y = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        x, y = (distorted[:, 0] - shift_x) / radial, (distorted[:, 1] - shift_y) / radial
    return np.column_stack([x, y, np.ones(len(x))])


def residuals(meta, matches):
    """Per match, two residuals in px against the reference R and t.

    vertical    left row minus right row after rectification, times the mean focal length
    epipolar    the larger of the two distances to the epipolar line in the undistorted images
    """
    K_l, K_r, R, t = (np.asarray(meta[k], float) for k in ("K_l", "K_r", "R", "t"))
    t = t / np.linalg.norm(t)
    rays_l = undistort(matches[:, 0:2], K_l, meta["dist_l"])
    rays_r = undistort(matches[:, 2:4], K_r, meta["dist_r"])
    f_l, f_r = (K_l[0, 0] + K_l[1, 1]) / 2, (K_r[0, 0] + K_r[1, 1]) / 2

    # Rectified axes in the right camera's frame: x along the baseline, y square to the mean optical axis.
    x_axis = -t
    y_axis = np.cross(R[:, 2] + [0, 0, 1], x_axis)
    y_axis /= np.linalg.norm(y_axis)
    rectify_r = np.stack([x_axis, y_axis, np.cross(x_axis, y_axis)])
    flat_l, flat_r = rays_l @ (rectify_r @ R).T, rays_r @ rectify_r.T
    vertical = (f_l + f_r) / 2 * (flat_l[:, 1] / flat_l[:, 2] - flat_r[:, 1] / flat_r[:, 2])

    E = np.cross(t, R, axisb=0, axisc=0)  # [t]_x R
    lines_r, lines_l = rays_l @ E.T, rays_r @ E
    algebraic = np.abs(np.sum(rays_r * lines_r, axis=1))
    distance_r = f_r * algebraic / np.hypot(lines_r[:, 0], lines_r[:, 1])
    distance_l = f_l * algebraic / np.hypot(lines_l[:, 0], lines_l[:, 1])
    return vertical, np.maximum(distance_l, distance_r)


def write_set(folder, meta, pairs):
    """Write folder/meta.json and folder/pairs/NNNN.csv, and print one line of statistics."""
    folder = pathlib.Path(folder)
    (folder / "pairs").mkdir(parents=True)
    meta = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in meta.items()}
    (folder / "meta.json").write_text(json.dumps(meta, indent=1) + "\n")
    for i, matches in enumerate(pairs):
        rows = ["%.3f,%.3f,%.3f,%.3f,%.3f\n" % tuple(row) for row in matches]
        (folder / "pairs" / f"{i:04d}.csv").write_text("ul,vl,ur,vr,score\n" + "".join(rows))

    counts = [len(matches) for matches in pairs]
    vertical, epipolar = residuals(meta, np.round(np.concatenate(pairs), 3))
    inlier = epipolar <= 2
    rms = np.sqrt(np.mean(vertical[inlier] ** 2))
    print(f"  {folder.name}: pairs {len(pairs)}, matches min/median/max {min(counts)}/{np.median(counts):.0f}/"
          f"{max(counts)}, outliers {100 * np.mean(~inlier):.1f} %, inlier rms {rms:.3f} px")
