"""Recorded sets, and rigs and matches that are made."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

import stereo_selfcal as sc
from stereo_selfcal._results import Array

DATA = Path(__file__).resolve().parents[2] / "data"
# The same examples in every run; many more in a campaign.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("campaign", deadline=None, max_examples=5000)
settings.load_profile("campaign" if "CAMPAIGN" in os.environ else "repeatable")

SETS = ("opencv_chess_corners", "opencv_chess_sift", "motorcycle_sift", "aloe_sift", "oak_sift")


@dataclass
class Recorded:
    """A recorded set: its rig, and ``(uv_left, uv_right, score)`` of each pair."""

    name: str
    rig: sc.Rig
    pairs: list[tuple[Array, Array, Array]]

    @classmethod
    def read(cls, name: str) -> Recorded:
        pairs = []
        for path in sorted((DATA / name / "pairs").glob("*.csv")):
            with path.open() as file:
                columns = ("ul", "vl", "ur", "vr", "score")
                rows = np.array([[float(row[c]) for c in columns] for row in csv.DictReader(file)])
            pairs.append((rows[:, 0:2], rows[:, 2:4], rows[:, 4]))
        return cls(name, sc.read_rig(DATA / name), pairs)

    def guess(self) -> sc.Rig:
        """The rig as ``selfcal replay`` starts from it: side by side, a calibration if the images are rectified."""
        meta = json.loads((DATA / self.name / "meta.json").read_text())
        is_rectified = not any(meta["dist_l"] + meta["dist_r"])
        factory = (np.eye(3), np.array([-1.0, 0.0, 0.0])) if is_rectified else None
        return sc.Rig(self.rig.left, self.rig.right, factory, baseline_m=meta["baseline_m"])


@dataclass
class Made:
    """A made rig with its truth, and matches of it."""

    rig: sc.Rig
    R: Array
    t: Array

    def pair(self, seed: int, count: int = 200, outliers: float = 0.1) -> tuple[Array, Array]:
        rng = np.random.default_rng(seed)
        width, height = self.rig.left.size
        found: list[Array] = []
        while sum(map(len, found)) < count:
            uv = rng.uniform((0, 0), (width, height), (4 * count, 2))
            rays = self.rig.left.rays(uv)
            depth = 1 / rng.uniform(0.02, 0.5, len(rays))
            points = np.column_stack([rays, np.ones(len(rays))]) * depth[:, None]
            moved = points @ self.R.T + self.t * 0.3
            right = self.rig.right.pixels(moved[:, :2] / moved[:, 2:])
            wrong = rng.random(len(right)) < outliers
            right[wrong] = rng.uniform((0, 0), (width, height), (int(wrong.sum()), 2))
            right += rng.normal(0, 0.2, right.shape)
            inside = ((right >= 0) & (right <= (width - 1, height - 1))).all(axis=1)
            found.append(np.column_stack([uv, right])[inside])
        rows = np.concatenate(found)[:count]
        return np.ascontiguousarray(rows[:, :2]), np.ascontiguousarray(rows[:, 2:])


def rotation(x: float, y: float, z: float) -> Array:
    """Rotation of a rotation vector, rad."""
    w = np.array([x, y, z])
    angle = float(np.linalg.norm(w))
    if angle == 0:
        return np.eye(3)
    a, b, c = w / angle
    k = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    turned: Array = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    return turned


def make_rig(r: Array, t: Array, dist: object = (-0.2, 0.05, 1e-3, -5e-4, 0.0), factory: bool = False) -> Made:
    """A rig of two like cameras, 640 x 480 px."""
    K = np.array([[500.0, 0, 322], [0, 501, 241], [0, 0, 1]])
    camera = sc.Camera.from_opencv(K, dist, (640, 480))  # type: ignore[arg-type]
    t = t / np.linalg.norm(t)
    return Made(sc.Rig(camera, camera, (r, t) if factory else None), r, t)


@pytest.fixture
def made() -> Made:
    return make_rig(rotation(0.01, -0.004, 0.006), np.array([-1.0, 0.01, 0.02]))


@pytest.fixture
def locked(made: Made) -> sc.Calibrator:
    calibrator = sc.Calibrator(made.rig)
    for seed in range(8):
        calibrator.fuse(*made.pair(seed))
    assert calibrator.state == "locked"
    return calibrator
