"""Types, threads, forks, pickles, records and texts."""

from __future__ import annotations

import os
import pickle
import re
import signal
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stereo_selfcal as sc
from stereo_selfcal._errors import ADVICE

from .conftest import DATA, Made, Recorded, make_rig, rotation

ROOT = Path(__file__).resolve().parents[3]
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no os.fork")


def test_floats_of_any_type_and_strides_give_the_same_bits(made: Made) -> None:
    left, right = (uv.astype(np.float32) for uv in made.pair(3))
    expected = sc.Calibrator(made.rig).fuse(left, right)
    wide = np.zeros((len(left), 10))
    wide[::-1, 1:9:4], wide[::-1, 2:10:4] = left, right
    for a, b in (
        (left.astype(np.float64), right.astype(">f8")),
        (np.asfortranarray(left), right.astype(np.longdouble)),
        (wide[::-1, 1:9:4], wide[::-1, 2:10:4]),
        (left.tolist(), right.tolist()),
    ):
        result = sc.Calibrator(made.rig).fuse(a, b)
        np.testing.assert_array_equal(result.R, expected.R)
    read_only = left.copy()
    read_only.flags.writeable = False
    np.testing.assert_array_equal(sc.Calibrator(made.rig).fuse(read_only, right).R, expected.R)


def test_the_estimate_is_the_rig(made: Made, locked: sc.Calibrator) -> None:
    calibration = locked.apply()
    np.testing.assert_allclose(calibration.R, made.R, atol=2e-3)
    np.testing.assert_allclose(calibration.t, made.t, atol=5e-3)
    assert locked.in_use == calibration and locked.generation == 1
    np.testing.assert_allclose(calibration.R @ calibration.R.T, np.eye(3), atol=1e-12)
    assert locked.undo() == made.rig.calibration()
    with pytest.raises(sc.ApplyError, match="Nothing to do") as error:
        locked.undo()
    assert (error.value.kind, error.value.code) == ("NothingToUndo", 705)


def test_a_frozen_calibrator_takes_nothing_until_it_is_released(made: Made, locked: sc.Calibrator) -> None:
    locked.frozen = True
    record = locked.save()
    frozen = locked.fuse(*made.pair(20)).rejection
    assert isinstance(frozen, sc.Refusal) and frozen.kind == "Frozen"
    assert locked.save() == record
    restored = sc.Calibrator(made.rig)
    assert not restored.frozen
    restored.load(record)
    assert restored.frozen and locked.frozen
    locked.frozen = False
    assert not locked.frozen
    assert locked.fuse(*made.pair(21)).fused is not None
    locked.reset()
    assert locked.state == "acquiring" and locked.details() is None


def test_ranges_tell_yaw(made: Made) -> None:
    left, right = made.rig.left, made.rig.right
    rig = sc.Rig(left, right, (made.R, made.t), baseline_m=0.3, yaw_sd_rad=float("inf"))
    calibrator = sc.Calibrator(rig)
    with pytest.raises(sc.RangeError, match="not locked"):
        calibrator.push_range((320, 240), 5.0, 0.05)
    points = np.array([[1.0, 0.3, 6.0], [-1.2, 0.5, 5.0], [0.1, -0.6, 4.0], [0.6, 0.2, 3.5], [-0.4, -0.3, 3.0]])
    taken = 0
    for seed in range(8):
        uv = left.pixels(points[:, :2] / points[:, 2:])
        moved = points @ made.R.T + made.t * 0.3
        uv_right = right.pixels(moved[:, :2] / moved[:, 2:])
        a, b = made.pair(seed, outliers=0)
        result = calibrator.fuse(np.r_[uv, a], np.r_[uv_right, b])
        if result.state == "locked":
            for pixel, depth in zip(uv, points[:, 2], strict=True):
                taken += calibrator.push_range(pixel, depth, 0.01, along="axis") == "taken"
    assert taken >= 10
    details = calibrator.details()
    assert details is not None and details.yaw < 1e-3
    before = details.contradicting_ranges
    with pytest.raises(sc.RangeError, match="contradicts"):
        calibrator.push_range(uv[3], 0.5, 0.01, along="axis")
    details = calibrator.details()
    assert details is not None
    assert (details.contradicting_ranges, details.contradicting_motions) == (before + 1, 0)
    with pytest.raises(sc.RangeError, match="within 3 px"):
        calibrator.push_range((5.0, 5.0), 5.0, 0.05)
    # A point that no pair has shown, with its own match.
    point = np.array([0.5, -0.2, 4.5])
    moved = made.R @ point + made.t * 0.3
    [pixel], [own] = left.pixels([point[:2] / 4.5]), right.pixels([moved[:2] / moved[2]])
    with pytest.raises(sc.RangeError, match="within 3 px"):
        calibrator.push_range(pixel, 4.5, 0.01, along="axis")
    assert calibrator.push_range(pixel, 4.5, 0.01, along="axis", right=own) == "taken"
    with pytest.raises(sc.RangeError, match="baseline_m"):
        sc.Calibrator(made.rig).push_range((5.0, 5.0), 5.0, 0.05)


def moving(made: Made) -> tuple[Any, Any]:
    """Left and right points of the same landmarks before and after a move."""
    rng = np.random.default_rng(4)
    points = np.column_stack([rng.uniform(-4, 4, 300), rng.uniform(-2, 2, 300), rng.uniform(6, 25, 300)])

    def seen(points: Any) -> tuple[Any, Any]:
        moved = points @ made.R.T + made.t * 0.3
        noise = rng.normal(0, 0.05, (2, len(points), 2))
        return (
            made.rig.left.pixels(points[:, :2] / points[:, 2:]) + noise[0],
            made.rig.right.pixels(moved[:, :2] / moved[:, 2:]) + noise[1],
        )

    def inside(*views: Any) -> Any:
        return np.all([((uv >= 0) & (uv <= (639, 479))).all(axis=1) for uv in views], axis=0)

    before, after = seen(points), seen(points - [0.3, 0.0, 2.0])
    keep = inside(*before, *after)
    return tuple(uv[keep] for uv in before), tuple(uv[keep] for uv in after)


def test_tracks_of_a_moving_rig_are_taken_and_those_of_a_resting_one_are_not(made: Made) -> None:
    calibrator = sc.Calibrator(made.rig)
    before, after = moving(made)
    with pytest.raises(sc.MotionError, match="not locked"):
        calibrator.push_motion(before, after)
    for seed in range(8):
        calibrator.fuse(*made.pair(seed))
    assert calibrator.push_motion(before, after) in ("taken", "waiting")
    with pytest.raises(sc.MotionError, match="no motion"):
        calibrator.push_motion(before, before)
    with pytest.raises(ValueError, match=r"after\[0\]: 3 rows"):
        calibrator.push_motion(before, (after[0][:3], after[1][:3]))


def test_tracks_of_frames_tell_motion_if_they_are_asked_for(made: Made) -> None:
    before, after = moving(made)
    numbers = np.arange(1, 1 + len(before[0]))
    size = made.rig.left.size

    def fed(calibrator: sc.Calibrator) -> tuple[sc.Result, sc.Result]:
        for seed in range(8):
            calibrator.feed_frames(sc.encode_frame(seed, *made.pair(seed), size=size))
        # The second frame shows the landmarks in another order, and comes in two pieces.
        first = sc.encode_frame(8, *before, size=size, tracks=numbers)
        second = sc.encode_frame(9, *(uv[::-1] for uv in after), size=size, tracks=numbers[::-1])
        results = [result for piece in (first, second[:99], second[99:]) for result in calibrator.feed_frames(piece)]
        return results[0], results[1]

    one, two = fed(sc.Calibrator(made.rig, motion=True))
    assert one.motion is None and two.motion in ("taken", "waiting")
    assert pickle.loads(pickle.dumps(two)).motion == two.motion
    copy = pickle.loads(pickle.dumps(sc.Calibrator(made.rig, motion=True)))
    assert fed(copy)[1].motion == two.motion
    ignored = sc.Calibrator(made.rig)
    assert [result.motion for result in fed(ignored)] == [None, None]
    pushed = sc.Calibrator(made.rig)
    fed(pushed)

    def on_wire(views: Any) -> Any:
        return tuple((np.round(uv * 256) / 256).astype(np.float32) for uv in views)

    assert pushed.push_motion(on_wire(before), on_wire(after)) == two.motion
    at_rest = sc.Calibrator(made.rig, motion=True)
    fed(at_rest)
    frame = sc.encode_frame(10, *after, size=size, tracks=numbers)
    [result] = at_rest.feed_frames(frame)
    assert isinstance(result.motion, sc.MotionError) and result.motion.kind == "NoMotion"
    with pytest.raises(ValueError, match=r"tracks\[1\] = 4096"):
        sc.encode_frame(1, *made.pair(1, 2), size=size, tracks=[0, 4096])
    with pytest.raises(ValueError, match="tracks: 3 rows"):
        sc.encode_frame(1, *made.pair(1, 2), size=size, tracks=[1, 2, 3])
    with pytest.raises(TypeError, match="motion: 3"):
        sc.Calibrator(made.rig, motion=3)  # type: ignore[arg-type]


def test_a_second_thread_is_told_at_once_and_harms_nothing(made: Made) -> None:
    calibrator = sc.Calibrator(made.rig, capacity=2048)
    pair = made.pair(1, count=2048)
    expected = sc.Calibrator(made.rig, capacity=2048)
    counts = {"fused": 0, "busy": 0}
    lock = threading.Lock()

    def work() -> None:
        for _ in range(60):
            try:
                calibrator.fuse(*pair)
                key = "fused"
            except sc.BusyError as error:
                assert isinstance(error, RuntimeError) and "another thread" in str(error)
                key = "busy"
            with lock:
                counts[key] += 1

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert counts["fused"] + counts["busy"] == 240 and counts["busy"] > 0
    for _ in range(counts["fused"]):
        expected.fuse(*pair)
    assert calibrator.save() == expected.save()


def test_calibrators_of_several_threads_run_side_by_side(made: Made) -> None:
    pairs = [made.pair(seed) for seed in range(6)]

    def record(_: int) -> bytes:
        calibrator = sc.Calibrator(made.rig)
        for pair in pairs:
            calibrator.fuse(*pair)
        return calibrator.save()

    with ThreadPoolExecutor(4) as pool:
        assert len(set(pool.map(record, range(8)))) == 1


@needs_fork
def test_after_a_fork_parent_and_child_have_a_calibrator_each(made: Made, locked: sc.Calibrator) -> None:
    pair = made.pair(30)
    # Threads of the parent, which a child does not have.
    made.rig.calibration().rectify_maps()
    sc.solve_pairs(made.rig, [pair] * 4)
    record = locked.save()
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        ok = locked.save() == record and locked.fuse(*pair).fused is not None
        ok = ok and len(sc.solve_pairs(made.rig, [pair] * 4)) == 4
        ok = ok and made.rig.calibration().rectify_maps()[0][0].shape == (480, 640)
        os.write(writer, b"1" if ok else b"0")
        os._exit(0)
    assert os.read(reader, 1) == b"1"
    os.waitpid(child, 0)
    assert locked.save() == record


def _solved(rig: sc.Rig, pair: Any) -> sc.Result:
    return sc.Calibrator(rig).fuse(*pair)


def test_results_come_back_from_other_processes(made: Made) -> None:
    pairs = [made.pair(seed) for seed in range(3)]
    with get_context("spawn").Pool(2) as pool:
        results = pool.starmap(_solved, [(made.rig, pair) for pair in pairs])
    for pair, result in zip(pairs, results, strict=True):
        np.testing.assert_array_equal(result.R, _solved(made.rig, pair).R)


def test_pickles_are_equal_to_the_bit(made: Made, locked: sc.Calibrator) -> None:
    fisheye = sc.Camera.from_fisheye(made.rig.left.K, [0.01, 0.02, 0.0, 0.0], (640, 480))
    rational = sc.Camera.from_opencv(made.rig.left.K, [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2], (640, 480))
    rig = sc.Rig(fisheye, rational, (made.R, made.t), baseline_m=0.3, yaw_sd_rad=1e-3)
    for value in (fisheye, rational, made.rig, rig, rig.calibration(), locked.apply(), locked.in_use):
        copy = pickle.loads(pickle.dumps(value))
        assert copy == value and type(copy) is type(value) and repr(copy) == repr(value)
    result = locked.fuse(*made.pair(40))
    few = locked.fuse(*(uv[:4] for uv in made.pair(41)))
    for given in (result, few):
        copy = pickle.loads(pickle.dumps(given))
        assert repr(copy) == repr(given) and copy.sd == given.sd
        np.testing.assert_array_equal(copy.R, given.R)
    assert str(pickle.loads(pickle.dumps(few.rejection))) == str(few.rejection)
    calibrator = pickle.loads(pickle.dumps(locked))
    assert calibrator.state == "suspect" and calibrator.rig == made.rig
    assert calibrator.fuse(*made.pair(42)).state == "locked"


def test_records_match_a_firmware(made: Made, locked: sc.Calibrator) -> None:
    record = locked.save()
    restored = sc.Calibrator(made.rig)
    restored.load(record)
    assert restored.state == "suspect"
    assert restored.fuse(*made.pair(50)).state == "locked"
    other = make_rig(rotation(0, 0, 0), np.array([-1.0, 0.0, 0.0]), dist=(0.1, 0, 0, 0))
    with pytest.raises(sc.RestoreError, match="another rig"):
        sc.Calibrator(other.rig).load(record)
    found = locked.apply()
    rig = sc.Rig(found.left, found.right, (found.R, found.t), baseline_m=0.25, yaw_sd_rad=2.0**-10)
    factory = sc.Rig.load(rig.save())
    assert (factory.baseline_m, factory.yaw_sd_rad) == (0.25, 2.0**-10)
    np.testing.assert_allclose(factory.left.K, made.rig.left.K, rtol=1e-7)
    np.testing.assert_allclose(factory.calibration().R, found.R, atol=1e-7)
    assert sc.Rig.load(factory.save()) == factory
    assert sc.Rig.load(made.rig.save()).yaw_sd_rad == float("inf")


@given(seeds=st.lists(st.integers(0, 1000), min_size=1, max_size=6), outliers=st.floats(0, 0.3))
def test_pairs_solved_at_once_are_those_solved_one_by_one(seeds: list[int], outliers: float) -> None:
    made = make_rig(rotation(0.01, -0.004, 0.006), np.array([-1.0, 0.01, 0.02]))
    pairs = [made.pair(seed, outliers=outliers) for seed in seeds]
    together = sc.solve_pairs(made.rig, pairs)
    assert len(together) == len(seeds)
    for i, pair in enumerate(pairs):
        alone = sc.Calibrator(made.rig).fuse(*pair)
        assert repr(together[i]) == repr(alone) and together[i].sd == alone.sd
        np.testing.assert_array_equal(together[i].R, alone.R)
        np.testing.assert_array_equal(together[i].t, alone.t)


def test_a_bad_pair_among_many_is_named() -> None:
    made = make_rig(rotation(0, 0, 0), np.array([-1.0, 0, 0]))
    with pytest.raises(ValueError, match=r"pairs\[1\]: uv_right: 3 rows"):
        sc.solve_pairs(made.rig, [made.pair(1), (made.pair(1)[0], made.pair(1)[1][:3])])
    assert len(sc.solve_pairs(made.rig, [])) == 0


def test_texts_read_well(made: Made, locked: sc.Calibrator) -> None:
    assert repr(made.rig.left) == (
        "<Camera 640 x 480 px, radial-tangential, focal length 500.00 501.00 px, principal point 322.00 241.00 px>"
    )
    assert "no factory calibration" in repr(made.rig)
    assert repr(locked).startswith("<Calibrator locked, 256 matches, <Rig")
    assert re.match(r"<Result locked, added; t -0\.99.* sd .* rad; rows .* px, depth .* px, coverage ", repr(locked.fuse(*made.pair(9))))
    assert repr(locked.apply()).startswith("<Calibration R 0.0")


def numbers_of_the_core() -> dict[str, dict[str, int]]:
    """Number of each value of each enumeration, from the lists `codes!` in the source of the core."""
    sources = [path.read_text() for path in (ROOT / "core/src").rglob("*.rs")]
    constants = {name: n for text in sources for name, n in re.findall(r"const ([A-Z_]+): u16 = (\d+);", text)}
    lists = [codes for text in sources for codes in re.findall(r"(?m)^codes! \{(.*|\n(?: .*\n)*)\}$", text)]
    found = {}
    for name, values in re.findall(r"(\w+)(?:<\w+>)? \{((?:[^{}]|\{[^{}]*\})*)\}", "\n".join(lists)):
        numbers = re.findall(r"(\w+)(?: \{[^{}]*\})? = ([A-Z_]+|\d+)\b", values)
        found[name] = {value: int(constants.get(number, number)) for value, number in numbers}
    return found


def test_every_error_that_is_raised_has_advice_and_no_other_number_has() -> None:
    source = (ROOT / "host-tests/python/src/errors.rs").read_text()
    listed = re.search(r"core_errors! \{([\w\s,]+)\}", source)
    assert listed
    # `core_errors!` lists neither `Rejection`, which becomes two classes, nor `UndistortError`, which is raised inside
    # `RangeError::Pixel` (a pixel of a range reading has no ray) with its own number.
    raised = {*re.findall(r"\w+", listed[1]), "Rejection", "UndistortError"}
    numbers = numbers_of_the_core()
    assert raised <= set(numbers), raised - set(numbers)
    # A `Calibrator` never returns `NotBegun`.
    ours = {n for name in raised for value, n in numbers[name].items() if value != "NotBegun"}
    assert ours == set(ADVICE), f"without advice: {sorted(ours - set(ADVICE))}; no error: {sorted(set(ADVICE) - ours)}"


def test_every_public_name_has_a_docstring() -> None:
    for name in sc.__all__:
        assert (getattr(sc, name).__doc__ or "").strip(), name


def test_the_package_has_the_version_of_the_workspace() -> None:
    from importlib.metadata import version

    assert f'version = "{version("stereo-selfcal")}"' in (ROOT / "Cargo.toml").read_text()


def blocks(*documents: str) -> str:
    """The blocks of Python of documents: one program, in their order."""
    found = [re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL) for name in documents]
    assert all(found)
    return "\n".join(sum(found, []))


def test_the_blocks_of_the_readme_and_of_metric_depth_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    exec(compile(blocks("README.md", "core/docs/depth.md"), "README.md", "exec"), names)
    assert capsys.readouterr().out.count("<Result locked") == 10
    assert names["depth_m"].shape == (480, 640)


def test_the_block_of_the_package_runs() -> None:
    cv2 = pytest.importorskip("cv2")
    rig = Recorded.read("opencv_chess_sift").rig
    images = [
        [cv2.imread(str(DATA / f"images/chess/{side}{n:02}.jpg"), cv2.IMREAD_GRAYSCALE) for side in ("left", "right")]
        for n in range(1, 6)
    ]
    r, t = rig.factory or (None, None)
    names = {"K": rig.left.K, "dist": rig.left.dist, "R": r, "T": t, "pairs": images}
    exec(compile(blocks("host-tests/python/README.md"), "README.md", "exec"), names)
    assert names["rectified"].shape == (480, 640)  # type: ignore[union-attr]


def test_plot_shows_three_axes(made: Made) -> None:
    pytest.importorskip("matplotlib")
    calibrator = sc.Calibrator(made.rig)
    results = [calibrator.fuse(*made.pair(seed)) for seed in range(6)]
    figure = sc.plot(results, made.rig.calibration(), calibrator.apply(), *made.pair(3))
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == ["Row offsets", "Pair by pair", "Coverage of the left image"]
    legend = figure.axes[0].get_legend()
    assert legend is not None
    before, after = (float(text.get_text().split()[1]) for text in legend.get_texts())
    assert after < 0.5 < before


def test_matches_of_images_calibrate_the_rig() -> None:
    cv2 = pytest.importorskip("cv2")
    recorded = Recorded.read("opencv_chess_sift")
    images = DATA / "images/chess"
    calibrator = sc.Calibrator(recorded.guess())
    for path in sorted(images.glob("left*.jpg"))[:6]:
        right = images / path.name.replace("left", "right")
        left_image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        matches = sc.match(left_image, right, recorded.rig)
        result = calibrator.fuse(*matches)
    assert result.state == "locked"
    np.testing.assert_allclose(calibrator.apply().R, recorded.rig.calibration().R, atol=3e-3)
    with pytest.raises(ValueError, match="left, right: exchanged"):
        sc.match(right, path, recorded.rig)
    with pytest.raises(TypeError, match="cv2.cvtColor"):
        sc.match(cv2.imread(str(path)), right, recorded.rig)
    with pytest.raises(ValueError, match=r"left: an image of 320 x 240 px, the rig's have 640 x 480"):
        sc.match(left_image[::2, ::2], right, recorded.rig)
    with pytest.raises(ValueError, match="is empty"):
        sc.match(np.zeros((480, 640), np.uint8), right, recorded.rig)


def test_check_is_selfcal_check() -> None:
    by_name = sc.check("chess")
    assert by_name.verdict in ("good", "improvable") and "rows are" in by_name.reasons[0]
    images = DATA / "images/chess"
    by_rig = sc.check((str(images / "left*.jpg"), str(images / "right*.jpg")), sc.read_rig(DATA / "opencv_chess_sift"))
    assert by_rig == by_name
    with pytest.raises(ValueError, match="not one of the shipped images"):
        sc.check("nowhere")


def test_ctrl_c_ends_a_check() -> None:
    # A shell may start its background jobs with the signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.05, lambda: os.kill(os.getpid(), signal.SIGINT))
    has_ended = False
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        sc.check("chess")
        has_ended = True
        time.sleep(60)
    assert not has_ended


@pytest.mark.skipif("SELFCAL" not in os.environ, reason="SELFCAL names the program of the host")
def test_check_has_the_numbers_of_selfcal_check() -> None:
    import json
    import subprocess

    ran = subprocess.run([os.environ["SELFCAL"], "check", "chess", "--json"], capture_output=True, check=False)
    assert json.loads(ran.stdout) == sc.check("chess").numbers
