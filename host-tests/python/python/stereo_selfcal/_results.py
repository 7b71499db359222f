"""Parts of results as plain data."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Check", "Finding", "Frame", "Matches", "Sd"]

Array: TypeAlias = npt.NDArray[np.float64]

#: State of the estimate after a pair.
State: TypeAlias = Literal["acquiring", "locked", "suspect", "lost"]


class Sd(NamedTuple):
    """Standard deviations, rad."""

    #: Deviation of ``R``: root of the summed variances about the three axes.
    rotation: float
    #: Deviation of the direction ``t``.
    translation: float


class Finding(NamedTuple):
    """An estimated quantity with its standard deviation."""

    value: float
    sd: float


class Matches(NamedTuple):
    """Matches of a stereo pair: ``calibrator.fuse(*match(...))``."""

    #: Left points ``(u, v)``, (n, 2), px.
    left: Array
    #: Right points, (n, 2), px.
    right: Array
    #: Confidence, (n,), 0 to 1.
    score: Array


class Frame(NamedTuple):
    """The frame of a result."""

    sequence: int
    #: Time of exposure on the sender's clock, us.
    timestamp_us: int


@dataclass(frozen=True)
class Check:
    """Verdict of `check`.

    Attributes
    ----------
    verdict : str
        ``"good"``, ``"improvable"``, ``"recalibrate"`` or ``"unknown"``.
    reasons : tuple of str
        Why, the worst first.
    numbers : dict
        All numbers of ``selfcal check --json``, angles in rad.
    """

    verdict: Literal["good", "improvable", "recalibrate", "unknown"]
    reasons: tuple[str, ...]
    numbers: dict[str, object] = field(repr=False)

    @classmethod
    def _of(cls, text: str) -> Check:
        numbers = json.loads(text)
        return cls(numbers["verdict"], tuple(numbers["reasons"]), numbers)
