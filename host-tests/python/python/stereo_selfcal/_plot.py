"""A picture of a calibration; needs matplotlib (``pip install stereo-selfcal[plot]``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._native import Calibration, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot"]

#: Largest row offset of a match that fits, px.
FIT_PX = 3.0


def plot(
    results: Sequence[Result],
    before: Calibration,
    after: Calibration,
    uv_left: npt.ArrayLike,
    uv_right: npt.ArrayLike,
) -> Figure:
    """Show row offsets before and after, the run pair by pair, and where the image has matches.

    Parameters
    ----------
    results : sequence of Result
        Results of `Calibrator.fuse`, in order.
    before, after : Calibration
        For instance ``rig.calibration()`` and ``calibrator.apply()``.
    uv_left, uv_right : array_like, (n, 2)
        Matches for the row offsets, px.

    Returns
    -------
    matplotlib.figure.Figure
        With three axes; ``figure.savefig("calibration.png")`` writes it.
    """
    from matplotlib.figure import Figure

    left = np.asarray(uv_left, dtype=np.float64)
    offsets = [of.row_offsets(left, uv_right) for of in (before, after)]
    with np.errstate(invalid="ignore"):
        fits = np.abs(offsets[1]) <= FIT_PX

    figure = Figure(figsize=(13, 4), layout="constrained")
    rows, timeline, coverage = figure.subplots(1, 3)

    reach = max(FIT_PX, *(float(np.percentile(np.abs(of[fits]), 99)) for of in offsets)) if fits.any() else FIT_PX
    bins = np.linspace(-reach, reach, 61).tolist()
    for of, name in zip(offsets, ("before", "after"), strict=True):
        rms = float(np.sqrt(np.mean(of[fits] ** 2))) if fits.any() else float("nan")
        rows.hist(of[fits], bins=bins, alpha=0.6, label=f"{name}: {rms:.2f} px RMS")
    rows.set(xlabel="row offset, px", ylabel="matches", title="Row offsets")
    rows.legend()

    seen = [(i, result.details) for i, result in enumerate(results) if result.details is not None]
    pairs = [i for i, _ in seen]
    timeline.plot(pairs, [details.in_use_px for _, details in seen], label="in use")
    timeline.plot(pairs, [details.proposed_px for _, details in seen], label="estimate")
    for i, result in enumerate(results):
        if result.rejection is not None:
            timeline.axvline(i, color="0.8", zorder=0)
    locked = next((i for i, result in enumerate(results) if result.state == "locked"), None)
    if locked is not None:
        timeline.axvline(locked, color="tab:green", linestyle="--", label="locked")
    timeline.set(xlabel="pair (grey: not fused)", ylabel="RMS row offset, px", title="Pair by pair")
    timeline.legend()

    width, height = before.left.size
    coverage.scatter(*left[fits].T, s=6, label=f"{int(fits.sum())} fit")
    coverage.scatter(*left[~fits].T, s=6, color="0.7", zorder=0, label=f"{int((~fits).sum())} do not")
    coverage.set(xlim=(0, width), ylim=(height, 0), aspect="equal", title="Coverage of the left image")
    coverage.legend(loc="upper right")
    return figure
