"""Bad input: an exception that names the argument, and a calibrator as it was."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import stereo_selfcal as sc

from .conftest import DATA, Made, make_rig, rotation

MADE = make_rig(rotation(0.01, -0.004, 0.006), np.array([-1.0, 0.01, 0.02]))
LEFT, RIGHT = MADE.pair(1)


def locked() -> sc.Calibrator:
    calibrator = sc.Calibrator(MADE.rig)
    for seed in range(6):
        calibrator.fuse(*MADE.pair(seed))
    return calibrator


LOCKED = locked()


def refused(error: type[Exception], text: str, *arguments: Any, **named: Any) -> None:
    before, state = LOCKED.save(), LOCKED.state
    with pytest.raises(error, match=text):
        LOCKED.fuse(*arguments, **named)
    assert LOCKED.save() == before and LOCKED.state == state


def with_value(value: float) -> np.ndarray[Any, Any]:
    points = LEFT.copy()
    points[17, 1] = value
    return points


@pytest.mark.parametrize(
    ("error", "text", "left", "right"),
    [
        (ValueError, r"uv_left: shape \(n, 2\) is expected, not \[200, 3\]", np.ones((200, 3)), RIGHT),
        (ValueError, r"uv_left: shape \(n, 2\) is expected, not \[400\]", LEFT.ravel(), RIGHT),
        (ValueError, r"uv_left: shape \(n, 2\) is expected, not \[1, 200, 2\]", LEFT[None], RIGHT),
        (ValueError, r"uv_right: 12 rows, not 200", LEFT, RIGHT[:12]),
        (ValueError, r"uv_left: no points, shape \(0, 2\)", LEFT[:0], RIGHT[:0]),
        (ValueError, r"uv_left\[17\] = \[.*, NaN\] is not finite", with_value(np.nan), RIGHT),
        (ValueError, r"uv_right\[17\] = \[.*, inf\] is not finite", LEFT, with_value(np.inf)),
        (ValueError, r"uv_left: shape .*, not \[480, 640\]: an image\?", np.zeros((480, 640), np.uint8), RIGHT),
        (ValueError, r"uv_left: shape .*, not \[480, 640, 3\]: an image\?", np.zeros((480, 640, 3), np.uint8), RIGHT),
        (ValueError, r"uv_left: shape \(n, 2\) is expected, .*an image\? `match`", np.zeros((48, 64), np.uint8), RIGHT),
        (TypeError, r"uv_left: real numbers are expected, not complex128", LEFT.astype(complex), RIGHT),
        (TypeError, r"uv_left", "points.csv", RIGHT),
        (TypeError, r"uv_left", None, RIGHT),
        (TypeError, r"uv_right", LEFT, [[1.0, 2.0], [3.0]]),
    ],
)
def test_the_argument_is_named_and_nothing_changes(error: type[Exception], text: str, left: Any, right: Any) -> None:
    refused(error, text, left, right)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (r"score\[3\] = 1.5 is not within 0 to 1", {"score": np.r_[np.ones(3), 1.5, np.ones(196)]}),
        (r"score\[0\] = NaN is not within 0 to 1", {"score": np.full(200, np.nan)}),
        (r"score: 3 rows, not 200", {"score": np.ones(3)}),
        (r"score: shape \(200,\) is expected, not \[200, 1\]", {"score": np.ones((200, 1))}),
        (r"grid_step: -1 px", {"grid_step": -1}),
        (r"grid_step: NaN px", {"grid_step": float("nan")}),
    ],
)
def test_scores_and_steps_out_of_range_are_named(text: str, named: dict[str, Any]) -> None:
    refused(ValueError, text, LEFT, RIGHT, **named)


anything = st.one_of(
    hnp.arrays(
        dtype=st.one_of(hnp.floating_dtypes(endianness="?"), hnp.integer_dtypes(), st.just(np.dtype(object))),
        shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=30),
    ),
    hnp.arrays(
        dtype=st.sampled_from([np.float16, np.float32, np.float64]),
        shape=st.tuples(st.integers(0, 40), st.just(2)),
        elements=st.floats(allow_nan=True, allow_infinity=True, width=16),
    ),
    st.none(),
    st.text(max_size=3),
    st.lists(st.floats(), max_size=4),
)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(left=anything, right=anything, score=anything)
def test_any_argument_gives_a_result_or_an_ordinary_exception(left: Any, right: Any, score: Any) -> None:
    calibrator = sc.Calibrator(MADE.rig)
    for call in (
        lambda: calibrator.fuse(left, right, score),
        lambda: calibrator.push_motion((left, right), (left, right)),
        lambda: MADE.rig.left.rays(left),
        lambda: MADE.rig.left.pixels(left),
        lambda: MADE.rig.calibration().row_offsets(left, right),
        lambda: sc.solve_pairs(MADE.rig, [(left, right, score)]),
        lambda: sc.match(left, right, MADE.rig),
        lambda: sc.Camera.from_opencv(left, right, (640, 480)),
        lambda: sc.Camera.from_fisheye(left, right, (640, 480)),
        lambda: sc.Rig(MADE.rig.left, MADE.rig.right, (left, right)),
        lambda: sc.encode_frame(1, left, right, score, size=(640, 480)),
    ):
        try:
            call()
        except (TypeError, ValueError, OSError, sc.SelfcalError):
            pass
    # A panic would be a BaseException; the calibrator still works.
    assert calibrator.fuse(LEFT, RIGHT).fused == "added"


@given(values=hnp.arrays(np.float32, (40, 4), elements=st.floats(width=32, allow_nan=False, allow_infinity=False)))
def test_any_finite_matches_give_finite_numbers(values: np.ndarray[Any, np.dtype[np.float32]]) -> None:
    calibrator = sc.Calibrator(MADE.rig)
    result = None
    try:
        result = calibrator.fuse(values[:, :2], values[:, 2:])
    except sc.PairError:
        pass
    if result is not None and result.R is not None and result.t is not None:
        assert np.isfinite(result.R).all() and np.isfinite(result.t).all()


@given(data=st.binary(max_size=400), cut=st.integers(0, 5000))
def test_random_bytes_do_no_harm_as_record_or_frames(data: bytes, cut: int) -> None:
    calibrator = sc.Calibrator(MADE.rig)
    record = LOCKED.save()
    for bad in (data, record[:cut] + data + record[cut + 1 :]):
        if bad != record:
            with pytest.raises(sc.RestoreError):
                calibrator.load(bad)
    assert calibrator.state == "acquiring"
    with pytest.raises(sc.RestoreError):
        sc.Rig.load(data)
    assert all(isinstance(result, sc.Result) for result in calibrator.feed_frames(data))


@given(numbers=st.lists(st.floats(), min_size=4, max_size=4), name=st.text(max_size=8), count=st.integers(-2, 10**6))
def test_any_numbers_make_a_calibrator_or_name_the_parameter(numbers: list[float], name: str, count: int) -> None:
    a, b, c, d = numbers
    for call in (
        lambda: sc.Calibrator(MADE.rig, capacity=count),
        lambda: sc.Calibrator(MADE.rig, lens=name),  # type: ignore[arg-type]
        lambda: sc.Calibrator(MADE.rig, max_correction_rad=a),
        lambda: sc.Calibrator(MADE.rig, memory_pairs=count),
        lambda: sc.Rig(MADE.rig.left, MADE.rig.right, baseline_m=c),
        lambda: sc.Rig(MADE.rig.left, MADE.rig.right, (np.eye(3), [-1.0, 0, 0]), yaw_sd_rad=d),
        lambda: sc.Rig(MADE.rig.left, MADE.rig.right, (np.diag([a, b, c]), [b, c, d])),
        lambda: LOCKED.push_range((a, b), c, d),
        lambda: MADE.rig.calibration().rectify_maps((count, count), a),
        lambda: MADE.rig.calibration().homographies(b),
    ):
        try:
            call()
        except (ValueError, OverflowError, sc.SelfcalError):
            pass


@pytest.mark.parametrize("mistake", ["u and v exchanged", "cameras one above the other"])
def test_disparities_along_columns_are_an_exception_and_never_lock(mistake: str) -> None:
    K = np.array([[500.0, 0, 320], [0, 500, 320], [0, 0, 1]])
    square = sc.Camera.from_opencv(K, None, (640, 640))
    is_exchanged = mistake == "u and v exchanged"
    made = Made(sc.Rig(square, square), MADE.R, MADE.t if is_exchanged else np.array([0.05, -1.0, 0.03]))
    calibrator, kinds = sc.Calibrator(made.rig), []
    for seed in range(20):
        pair = tuple(uv[:, ::-1] if is_exchanged else uv for uv in made.pair(seed, count=250, outliers=0))
        record = calibrator.save()
        try:
            assert calibrator.fuse(*pair).state == "acquiring"
        except sc.PairError as error:
            assert calibrator.save() == record
            kinds.append(error.kind)
    assert kinds.count("Columns") >= 10


def test_left_and_right_exchanged_is_named_and_never_replaces_the_estimate() -> None:
    calibrator = locked()
    before, named = calibrator.apply().R, 0
    for seed in range(30):
        left, right = MADE.pair(seed)
        try:
            assert calibrator.fuse(right, left).fused in (None, "kept_apart")
        except sc.PairError as error:
            assert "left and right exchanged" in str(error) and "Exchange left and right" in str(error)
            named += 1
    # Other pairs are not solved: points of negative disparity have no weight, so too few matches support a pose.
    assert named >= 12
    assert calibrator.state == "lost"
    np.testing.assert_array_equal(calibrator.in_use.R, before)


def test_a_pair_that_the_scene_spoils_raises_no_exception() -> None:
    calibrator = sc.Calibrator(MADE.rig)
    few = calibrator.fuse(LEFT[:5], RIGHT[:5])
    assert isinstance(few.rejection, sc.PairError) and few.rejection.kind == "TooFew"
    assert few.fused is None and few.R is None and few.details is None
    assert "5 usable correspondences, 12 needed" in str(few.rejection)
    rng = np.random.default_rng(0)
    noise = [rng.uniform(0, 479, (200, 2)) for _ in range(2)]
    assert calibrator.fuse(*noise).rejection is not None
    # A pixel outside the image is refused and counted, as on a vehicle.
    outside = calibrator.fuse(np.r_[LEFT, LEFT[:9] + 1e4], np.r_[RIGHT, RIGHT[:9]])
    assert (outside.offered, outside.taken, outside.refused) == (209, 200, 9)


def test_doubts_about_a_rig_file_are_warnings_and_its_cameras_may_be_exchanged(tmp_path: Path) -> None:
    k = [[700.0, 0.0, 320.0], [0.0, 700.0, 240.0], [0.0, 0.0, 1.0]]
    file = tmp_path / "stereo.json"
    rig = {"K1": k, "K2": k, "D1": [0.0] * 4, "D2": [0.0] * 4, "R": np.eye(3).tolist(), "T": [0.1, 0.0, 0.0]}
    file.write_text(json.dumps(rig))
    with pytest.raises(ValueError, match="to the left"):
        sc.read_rig(file, size=(640, 480))
    with pytest.warns(UserWarning, match="add distortion_model: equidistant"):
        assert sc.read_rig(file, size=(640, 480), cameras=(1, 0)).baseline_m == 0.1
    with pytest.warns(UserWarning, match="another size"):
        sc.read_rig(file, size=(1920, 1200), cameras=(1, 0))


def test_a_rig_of_another_size_or_sign_is_named() -> None:
    with pytest.raises(ValueError, match=r"640 x 480 px, not of size=\(1280, 960\)"):
        sc.read_rig(DATA / "opencv_chess_sift", size=(1280, 960))
    with pytest.raises(FileNotFoundError, match="nowhere"):
        sc.read_rig("nowhere.yaml")
    with pytest.raises(ValueError, match=r"factory t: t = \(1, 0, 0\): the right camera would stand"):
        sc.Rig(MADE.rig.left, MADE.rig.right, (np.eye(3), [1.0, 0, 0]))
    with pytest.raises(sc.ExtrinsicsError, match="factory: R is not a rotation"):
        sc.Rig(MADE.rig.left, MADE.rig.right, (np.ones((3, 3)), [-1.0, 0, 0]))
    with pytest.raises(sc.CameraError, match="K or size: focal length"):
        sc.Camera.from_opencv(np.eye(3) * [[0], [0], [1]], None, (640, 480))
    with pytest.raises(ValueError, match="thin prisms"):
        sc.Camera.from_opencv(MADE.rig.left.K, [0.1] * 14, (640, 480))
    with pytest.raises(ValueError, match="size: "):
        sc.Camera.from_opencv(MADE.rig.left.K)


def test_frames_of_another_size_are_refused_and_none_of_the_bytes_is_taken(made: Made) -> None:
    calibrator = sc.Calibrator(made.rig)
    good = sc.encode_frame(0, LEFT, RIGHT, size=(640, 480))
    wrong = sc.encode_frame(1, LEFT, RIGHT, size=(1280, 960))
    with pytest.raises(sc.FrameRefusal, match="1280 x 960"):
        calibrator.feed_frames(good + wrong)
    assert calibrator.link["good"] == 0 and calibrator.state == "acquiring"
    assert len(calibrator.feed_frames(good)) == 1
