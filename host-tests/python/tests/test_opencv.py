"""Lens models, rotations, homographies and maps against OpenCV.

Sign and order, side by side::

    here                                    OpenCV
    p_r = R p_l + t, |t| = 1                x_2 = R x_1 + T, any length
    R_l, R_r: camera to rectified frame     R1, R2
    x_r along -t                            x_rect along -T for a rig side by side
    y_r normal to x_r and to z of the       y_rect normal to x_rect and to the mean z of both
    right camera                            cameras
    K, one for both views                   P1, P2 with CALIB_ZERO_DISPARITY

The rectified frames differ by a common turn about the baseline, which leaves all rows equal.
"""

from __future__ import annotations

import os
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stereo_selfcal as sc
from stereo_selfcal._results import Array

from .conftest import make_rig, rotation

K = np.array([[534.0, 0, 342], [0, 531, 234.5], [0, 0, 1]])
SIZE = (640, 480)
LENSES: dict[str, list[float]] = {
    "pinhole": [0.0] * 5,
    "radial": [-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115],
    "four": [-0.2, 0.05, 1e-3, -5e-4],
    "barrel": [0.118, -0.230, -5.6e-4, -2.6e-3, 0.0285],
    "rational": [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2],
    "fourteen": [-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115, 0, 0, 0, 0, 0, 0, 0, 0, 0],
}
FISHEYE = [-0.013, 0.027, -0.031, 0.011]
PRECISE = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-14)

pixels = st.lists(st.tuples(st.floats(0, 639), st.floats(0, 479)), min_size=1, max_size=20)
angles = st.tuples(*[st.floats(-0.05, 0.05)] * 3)
baselines = st.tuples(st.just(-1.0), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))


@pytest.mark.parametrize("lens", LENSES)
@given(uv=pixels)
def test_undistortion_matches_cv2_undistort_points(lens: str, uv: list[tuple[float, float]]) -> None:
    dist, points = np.array(LENSES[lens]), np.array(uv)
    rays = sc.Camera.from_opencv(K, dist, SIZE).rays(points)
    expected = cv2.undistortPoints(points[:, None], K, dist, criteria=PRECISE)
    np.testing.assert_allclose(rays, expected[:, 0], atol=1e-8)


@given(uv=pixels)
def test_undistortion_of_a_fisheye_matches_cv2_fisheye(uv: list[tuple[float, float]]) -> None:
    dist, points = np.array(FISHEYE), np.array(uv)
    rays = sc.Camera.from_fisheye(K, dist, SIZE).rays(points)
    expected = cv2.fisheye.undistortPoints(points[:, None], K, dist)
    np.testing.assert_allclose(rays, expected[:, 0], atol=1e-7)


@pytest.mark.parametrize("lens", [*LENSES, "fisheye"])
@given(rays=st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4)), min_size=1, max_size=20))
def test_projection_matches_cv2_project_points(lens: str, rays: list[tuple[float, float]]) -> None:
    points, zero = np.array(rays), np.zeros(3)
    if lens == "fisheye":
        camera = sc.Camera.from_fisheye(K, FISHEYE, SIZE)
        expected = cv2.fisheye.distortPoints(points[:, None], K, np.array(FISHEYE))
    else:
        camera = sc.Camera.from_opencv(K, LENSES[lens], SIZE)
        space = np.column_stack([points, np.ones(len(points))])
        expected = cv2.projectPoints(space, zero, zero, K, np.array(LENSES[lens]))[0]
    np.testing.assert_allclose(camera.pixels(points), expected[:, 0], atol=1e-8)


def rectified(R: Array, t: Array, dist: list[float]) -> tuple[sc.Calibration, Any]:
    made = make_rig(R, t, dist, factory=True)
    k, d = made.rig.left.K, np.array(dist)
    by_opencv = cv2.stereoRectify(k, d, k, d, SIZE, made.R, made.t[:, None], flags=cv2.CALIB_ZERO_DISPARITY, alpha=0)
    return made.rig.calibration(), by_opencv


@given(angles=angles, t=baselines)
def test_rotations_match_cv2_stereo_rectify_but_for_a_turn_about_the_baseline(
    angles: tuple[float, float, float], t: tuple[float, float, float]
) -> None:
    calibration, (r1, r2, *_) = rectified(rotation(*angles), np.array(t), LENSES["four"])
    own1, own2, p1, p2, q = calibration.stereo_rectify()
    # OpenCV ignores a rotation below 1e-5 rad.
    turns = [r1 @ own1.T, r2 @ own2.T]
    for turn in turns:
        np.testing.assert_allclose(turn[0], [1, 0, 0], atol=1.2e-5)
        np.testing.assert_allclose(turn[:, 0], [1, 0, 0], atol=1.2e-5)
    np.testing.assert_allclose(turns[0], turns[1], atol=1.2e-5)
    # Without a length, in baselines.
    f, c = p1[0, 0], p1[:2, 2]
    np.testing.assert_allclose(p2, np.column_stack([p1[:, :3], [-f, 0, 0]]))
    x, y, disparity = c[0] + 30, c[1] - 20, f / 7
    point = q @ [x, y, disparity, 1]
    np.testing.assert_allclose(point[:3] / point[3], [30 * 7 / f, -20 * 7 / f, 7])


# A whole image for each example.
@settings(max_examples=100 if "CAMPAIGN" in os.environ else 12)
@given(angles=angles, t=baselines, lens=st.sampled_from(["pinhole", "four", "barrel"]))
def test_maps_match_cv2_init_undistort_rectify_map(
    angles: tuple[float, float, float], t: tuple[float, float, float], lens: str
) -> None:
    calibration, _ = rectified(rotation(*angles), np.array(t), LENSES[lens])
    maps = calibration.rectify_maps()
    r1, r2, p1, p2, _ = calibration.stereo_rectify()
    for own, r, p, camera in ((maps[0], r1, p1, calibration.left), (maps[1], r2, p2, calibration.right)):
        expected = cv2.initUndistortRectifyMap(camera.K, camera.dist, r, p[:, :3], SIZE, cv2.CV_32FC1)
        seen = own[0] > -1e4
        assert seen.mean() > 0.99
        for a, b in zip(own, expected, strict=True):
            assert a.dtype == np.float32 and a.shape == (480, 640)
            np.testing.assert_allclose(a[seen], b[seen], atol=2e-3)


@given(angles=angles, t=baselines, uv=pixels)
def test_homographies_take_undistorted_pixels_to_those_of_cv2_undistort_points(
    angles: tuple[float, float, float], t: tuple[float, float, float], uv: list[tuple[float, float]]
) -> None:
    calibration, _ = rectified(rotation(*angles), np.array(t), LENSES["four"])
    r1, r2, p1, p2, _ = calibration.stereo_rectify()
    for h, r, p, camera in zip(
        calibration.homographies(), (r1, r2), (p1, p2), (calibration.left, calibration.right), strict=True
    ):
        k, points = camera.K, np.array(uv)
        undistorted = np.column_stack([camera.rays(points), np.ones(len(points))]) @ k.T
        moved = undistorted @ h.T
        expected = cv2.undistortPoints(points[:, None], k, camera.dist, R=r, P=p[:, :3], criteria=PRECISE)
        np.testing.assert_allclose(moved[:, :2] / moved[:, 2:], expected[:, 0], atol=2e-3)


def test_alpha_0_shows_only_pixels_of_both_cameras_and_alpha_1_shows_all_of_them() -> None:
    made = make_rig(rotation(0.01, -0.02, 0.005), np.array([-1.0, 0.01, 0.02]), factory=True)
    calibration = made.rig.calibration()
    for x, y in calibration.rectify_maps(alpha=0.0):
        assert x.min() > -1 and x.max() < 640 and y.min() > -1 and y.max() < 480
    r1, r2, p1, p2, _ = calibration.stereo_rectify(alpha=1.0)
    corners = np.array([[0.0, 0.0], [639, 0], [0, 479], [639, 479], [320, 0], [320, 479], [0, 240], [639, 240]])
    for camera, r, p in ((calibration.left, r1, p1), (calibration.right, r2, p2)):
        seen = cv2.undistortPoints(corners[:, None], camera.K, camera.dist, R=r, P=p[:, :3])[:, 0]
        assert ((seen > -1) & (seen < (640, 480))).all()


def test_half_the_size_sees_the_same_rays() -> None:
    made = make_rig(rotation(0.01, -0.02, 0.005), np.array([-1.0, 0.01, 0.02]), factory=True)
    calibration = made.rig.calibration()
    whole, half = calibration.rectify_maps(), calibration.rectify_maps((320, 240))
    for a, b in zip(whole[0], half[0], strict=True):
        # A pixel of half the size lies in the middle of four.
        np.testing.assert_allclose(a.reshape(240, 2, 320, 2).mean((1, 3)), b, atol=0.02)


def test_matches_are_in_their_rows_after_the_maps_of_their_truth() -> None:
    made = make_rig(rotation(0.01, -0.02, 0.005), np.array([-1.0, 0.01, 0.02]), factory=True)
    left, right = made.pair(1, outliers=0)
    calibration = made.rig.calibration()
    (_, left_rows), (_, right_rows) = (
        cv2.undistortPoints(uv[:, None], camera.K, camera.dist, R=r, P=p[:, :3])[:, 0].T
        for uv, camera, r, p in zip(
            (left, right), (calibration.left, calibration.right), calibration.stereo_rectify()[:2],
            calibration.stereo_rectify()[2:4], strict=True,
        )
    )
    assert np.std(left_rows - right_rows) < 0.4
    assert np.std(calibration.row_offsets(left, right)) < 0.4
