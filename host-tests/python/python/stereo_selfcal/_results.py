"""Results as plain data: read them, compare them, pickle them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ._errors import PairError, Refusal

Array: TypeAlias = npt.NDArray[np.float64]

#: State of the estimate, from the first pairs to confirmed.
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


@dataclass(slots=True, eq=False)
class Pair:
    """One stereo pair, solved.

    Attributes
    ----------
    R, t : ndarray
        (3, 3) and (3,): ``p_r = R p_l + t``, ``|t| = 1``.
    rms_px_before, rms_px_after : float
        RMS row offset of the matches that fit, at the start and at the solution, px.
    noise_px : float
        Standard deviation of a coordinate, estimated from the residuals, px.
    usable, fit, skipped : int
        Matches in front of both cameras, those that fit, and those behind.
    passes : int
        Passes over the matches.
    stop : str
        Why the solver stopped.
    """

    R: Array
    t: Array
    rms_px_before: float
    rms_px_after: float
    noise_px: float
    usable: int
    fit: int
    skipped: int
    passes: int
    stop: str


@dataclass(slots=True, eq=False)
class Health:
    """The calibration in use and the estimate, over the matches of the last pair.

    Attributes
    ----------
    may_arm : bool
        Yes or no to an arming check; the reasons of the result say why not.
    band : str
        ``"good"``, ``"improvable"``, ``"recalibrate"`` or ``"unknown"``: verdict on the calibration in use.
    in_use_px, proposed_px, off_px : float
        RMS row offset of the calibration in use, of the estimate, and of their difference, px.
    fit_in_use, fit_proposed : int
        Matches that fit each of both.
    coverage : float
        Share of the cells of an 8 x 6 grid over the image with a match that fits.
    corner_px : float
        Row offset that the apparent yaw of the lenses leaves in the corner of the image, px.
    contradicting_ranges, contradicting_motions : int
        Readings of `push_range` and `push_motion` since the last reset that contradicted the yaw: refused, or
        waiting until more of them agree.
    lens_yaw : Finding
        Apparent yaw of the lenses, rad.
    lens : dict or None
        Errors of the lens models that the pairs show: ``focal``, ``k1``, ``k1_mean``, ``p1``, ``principal_x_px``.
    weakest : tuple or None
        The least certain direction and its standard deviation, rad.
    yaw : float
        Expected error of the yaw in use, rad: depth ``Z`` is off by ``Z**2 * yaw / baseline``.
    vibration : Sd
        Motion of the rig about the estimate from pair to pair, rad RMS.
    """

    may_arm: bool
    band: str
    in_use_px: float
    proposed_px: float
    off_px: float
    fit_in_use: int
    fit_proposed: int
    coverage: float
    corner_px: float
    contradicting_ranges: int
    contradicting_motions: int
    lens_yaw: Finding
    lens: dict[str, Finding] | None
    weakest: tuple[str, float] | None
    yaw: float
    vibration: Sd


@dataclass(slots=True, eq=False)
class Result:
    """The estimate after a pair.

    Attributes
    ----------
    R, t : ndarray or None
        (3, 3) and (3,): ``p_r = R p_l + t``, ``|t| = 1``, over all fused pairs. None before the first.
    state : str
        ``"acquiring"``, ``"locked"``, ``"suspect"`` or ``"lost"``.
    health : Health or None
        Fit and reliability over this pair's matches; None before the first fused pair.
    reasons : tuple of str
        Reasons against relying on the calibration, the worst first; may be empty.
    cause : str or None
        The likeliest mistake in rig or matcher, in words, once four pairs show one: ``"u and v exchanged"``.
    sd, sd_lens : Sd or None
        Standard deviations of ``R`` and ``t``: with the lens models as given, and with them uncertain.
    fused : str or None
        How the pair was fused: ``"added"``, ``"repeated"``, ``"kept_apart"``, ``"renewed"``, ``"took_over"``,
        ``"lens_corrected"``. None if it was not fused: see `rejection`.
    rejection : PairError, Refusal or None
        Why the pair was not fused. This is normal now and then: take the next pair.
    pair : Pair or None
        The solved pair; None if it was not solved.
    pairs : int
        Number of pairs in the estimate.
    offered, taken, refused : int
        Matches of this pair: all, those in the batch, and those without a ray or outside the image.
    generation : int
        Changes with the calibration in use.
    frame : Frame or None
        The frame, if it came by `Calibrator.feed_frames`.
    """

    R: Array | None
    t: Array | None
    state: State
    health: Health | None
    reasons: tuple[str, ...]
    cause: str | None
    sd: Sd | None
    sd_lens: Sd | None
    fused: str | None
    rejection: PairError | Refusal | None
    pair: Pair | None
    pairs: int
    offered: int
    taken: int
    refused: int
    generation: int
    frame: Frame | None

    def __repr__(self) -> str:
        words = [f"{self.state}, {self.fused or self.rejection}"]
        if self.t is not None and self.sd_lens is not None:
            t = " ".join(f"{x:.5f}" for x in self.t)
            words.append(f"t {t}, sd {self.sd_lens.rotation:.5f} and {self.sd_lens.translation:.5f} rad")
        if self.health is not None:
            words.append(f"rows {self.health.in_use_px:.2f} px in use, {self.health.proposed_px:.2f} px by the estimate")
        if self.reasons:
            words.append("against it: " + ", ".join(self.reasons))
        if self.cause is not None:
            words.append(f"likely cause: {self.cause}")
        return f"<Result {'; '.join(words)}>"


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
