"""The numbers equal those of `selfcal replay`, bit for bit."""

from __future__ import annotations

import csv
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import stereo_selfcal as sc

from .conftest import DATA, SETS, Recorded

SELFCAL = os.environ.get("SELFCAL", "")
needs_selfcal = pytest.mark.skipif(not SELFCAL, reason="SELFCAL names the program of the host")


def replayed(arguments: list[str], trace: Path) -> list[dict[str, str]]:
    subprocess.run([SELFCAL, "replay", *arguments, "--trace", str(trace)], check=True, capture_output=True)
    with trace.open() as file:
        return list(csv.DictReader(file))


def numbers(row: dict[str, str], names: list[str]) -> list[float]:
    return [float(row[name]) for name in names]


def assert_same(row: dict[str, str], result: sc.Result) -> None:
    assert row["state"] == result.state
    assert int(row["matches"]) == result.taken
    if result.R is not None and result.t is not None and result.sd_lens is not None:
        assert numbers(row, [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]) == result.R.ravel().tolist()
        assert numbers(row, ["t1", "t2", "t3"]) == result.t.tolist()
        assert numbers(row, ["sd_rotation", "sd_translation"]) == list(result.sd_lens)
    else:
        assert row["r11"] == ""
    assert row["armed"] == str(result.verdict.may_arm).lower()
    if result.details is not None:
        assert numbers(row, ["rms_px_in_use", "rms_px_proposed"]) == [
            result.details.in_use_px,
            result.details.proposed_px,
        ]
        assert int(row["fit"]) == result.details.fit_proposed
    else:
        assert row["rms_px_in_use"] == ""


@needs_selfcal
@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("given", ["guess", "factory"])
@pytest.mark.parametrize("capacity", [256, 2048])
def test_every_recorded_set_comes_to_the_bits_of_selfcal_replay(
    name: str, given: str, capacity: int, tmp_path: Path
) -> None:
    recorded = Recorded.read(name)
    rig = recorded.guess() if given == "guess" else recorded.rig
    initial = [] if given == "guess" else ["--initial", str(DATA / name / "meta.json")]
    rows = replayed([name, "--capacity", str(capacity), *initial], tmp_path / "trace.csv")
    calibrator = sc.Calibrator(rig, capacity=capacity)
    assert len(rows) == len(recorded.pairs)
    for row, pair in zip(rows, recorded.pairs, strict=True):
        assert_same(row, calibrator.fuse(*pair))


@needs_selfcal
def test_a_vehicle_that_applies_each_pair_comes_to_the_same_bits(tmp_path: Path) -> None:
    recorded = Recorded.read("opencv_chess_sift")
    options = ["--apply", "each", "--capacity", "256"]
    rows = replayed(["opencv_chess_sift", *options], tmp_path / "trace.csv")
    calibrator = sc.Calibrator(recorded.guess())
    for row, pair in zip(rows, recorded.pairs, strict=True):
        assert_same(row, calibrator.fuse(*pair))
        try:
            calibrator.apply()
        except sc.ApplyError:
            pass
        used = calibrator.in_use
        assert numbers(row, [f"u{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]) == used.R.ravel().tolist()
        assert numbers(row, ["v1", "v2", "v3"]) == used.t.tolist()


@needs_selfcal
@pytest.mark.parametrize("angle", ["mean", "median"])
def test_the_published_method_comes_to_the_bits_of_selfcal_replay(angle: str, tmp_path: Path) -> None:
    recorded = Recorded.read("opencv_chess_sift")
    options = ["--preset", "paper", "--angle", angle]
    rows = replayed(["opencv_chess_sift", *options], tmp_path / "trace.csv")
    estimates = sc.fuse_published(recorded.guess(), recorded.pairs, angle=angle)  # type: ignore[arg-type]
    for row, estimate in zip(rows, estimates, strict=True):
        assert estimate is not None
        assert numbers(row, [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]) == estimate.R.ravel().tolist()
        assert numbers(row, ["t1", "t2", "t3"]) == estimate.t.tolist()
    assert estimates[-1] is not None and estimates[-1].pairs == 12
    with pytest.raises(ValueError, match="angle"):
        sc.fuse_published(recorded.guess(), [], angle="mode")  # type: ignore[arg-type]


@needs_selfcal
@pytest.mark.parametrize("name", SETS)
def test_frames_with_damage_in_any_pieces_come_to_the_bits_of_selfcal_replay(name: str, tmp_path: Path) -> None:
    recorded = Recorded.read(name)
    stream = tmp_path / "stream"
    faults = ["--damaged", "0.2", "--seed", "3"] if len(recorded.pairs) > 1 else []
    subprocess.run([SELFCAL, "record", name, str(stream), *faults], check=True, capture_output=True)
    rows = replayed([str(stream), "--rig", name, "--capacity", "256"], tmp_path / "trace.csv")
    calibrator = sc.Calibrator(recorded.guess())
    data = stream.read_bytes()
    cuts = np.sort(np.random.default_rng(1).integers(0, len(data), 50)).tolist()
    pieces = [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)]
    results = [result for piece in pieces for result in calibrator.feed_frames(piece)]
    assert len(rows) == len(results) > 0
    for row, result in zip(rows, results, strict=True):
        assert_same(row, result)
    assert calibrator.link["good"] == len(results)


def test_frames_come_to_the_bits_of_their_matches() -> None:
    recorded = Recorded.read("opencv_chess_corners")
    by_frames, by_matches = sc.Calibrator(recorded.rig), sc.Calibrator(recorded.rig)
    for i, (left, right, score) in enumerate(recorded.pairs):
        # Coordinates in the resolution of the wire.
        left, right = np.round(left * 256) / 256, np.round(right * 256) / 256
        frame = sc.encode_frame(i, left, right, np.ones(len(score)), size=(640, 480))
        assert by_frames.feed_frames(frame[:100]) == []
        [of_frame] = by_frames.feed_frames(frame[100:])
        of_matches = by_matches.fuse(left, right, grid_step=1 / 256)
        assert of_frame.frame is not None and of_frame.frame.sequence == i
        assert of_matches.R is not None and of_frame.R is not None
        np.testing.assert_array_equal(of_frame.R, of_matches.R)
    assert by_frames.save() == by_matches.save()


@needs_selfcal
@pytest.mark.parametrize(
    ("layout", "name"), [("opencv", "opencv_chess_sift"), ("ros", "opencv_chess_sift"), ("kalibr", "oak_sift")]
)
def test_rigs_in_the_files_of_other_tools_are_read(layout: str, name: str, tmp_path: Path) -> None:
    folder = tmp_path / layout
    command = [SELFCAL, "export", name, "--format", layout, "--out", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    rig, expected = sc.read_rig(folder), Recorded.read(name).rig
    assert rig.left == expected.left and rig.right == expected.right
    np.testing.assert_allclose(rig.calibration().R, expected.calibration().R, atol=1e-6)
    np.testing.assert_allclose(rig.calibration().t, expected.calibration().t, atol=1e-6)
    with pytest.raises(ValueError, match="320"):
        sc.read_rig(folder, size=(320, 240))
