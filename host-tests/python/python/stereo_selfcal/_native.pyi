from collections.abc import Iterable, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt

from ._errors import MotionError, PairError, Refusal
from ._results import Array, Check, Finding, Frame, Matches, Sd, State

__all__ = [
    "Calibration",
    "Calibrator",
    "Camera",
    "Details",
    "Event",
    "History",
    "Pair",
    "Published",
    "Result",
    "Rig",
    "Verdict",
    "check",
    "encode_frame",
    "fuse_published",
    "match",
    "read_rig",
    "solve_pairs",
]

_Floats: TypeAlias = npt.ArrayLike
_Size: TypeAlias = tuple[int, int]
_Path: TypeAlias = str | PathLike[str]
_Map: TypeAlias = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]

@final
class Camera:
    """A calibrated camera: intrinsics and lens in OpenCV's conventions.

    Made by `from_opencv` or `from_fisheye`. Computes in float64.
    """

    @classmethod
    def from_opencv(cls, K: _Floats, dist: _Floats | None = None, size: _Size | None = None) -> Camera:
        """Make a camera from the results of ``cv2.calibrateCamera``.

        Parameters
        ----------
        K : array_like, (3, 3)
            ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]``, px.
        dist : array_like, (4,), (5,) or (8,), optional
            ``k1 k2 p1 p2 [k3 [k4 k5 k6]]``; 12 or 14 numbers if those beyond 8 are 0. None: a pinhole.
        size : (int, int)
            Image width and height, px.

        Raises
        ------
        CameraError
            If a quantity is out of range.
        ValueError, TypeError
            If an argument has another shape or type.
        """

    @classmethod
    def from_fisheye(cls, K: _Floats, dist: _Floats, size: _Size) -> Camera:
        """Make a camera from the results of ``cv2.fisheye.calibrate``.

        Parameters
        ----------
        K : array_like, (3, 3)
            Camera matrix without skew, px.
        dist : array_like, (4,)
            ``k1 k2 k3 k4``.
        size : (int, int)
            Image width and height, px.

        Raises
        ------
        CameraError
            If a quantity is out of range.
        """

    @property
    def K(self) -> Array:
        """Camera matrix, (3, 3), px."""

    @property
    def dist(self) -> Array:
        """Lens coefficients in OpenCV's order, (4,), (5,) or (8,)."""

    @property
    def size(self) -> _Size:
        """Image width and height, px."""

    @property
    def model(self) -> Literal["pinhole", "radial_tangential", "fisheye", "rational"]:
        """Lens model."""

    def rays(self, uv: _Floats) -> Array:
        """Undistort pixels, as ``cv2.undistortPoints``.

        Parameters
        ----------
        uv : array_like, (n, 2)
            Pixels, px.

        Returns
        -------
        ndarray, (n, 2)
            Rays ``(x, y)`` at unit depth. NaN for a pixel outside the image, or where the lens model is not invertible.
        """

    def pixels(self, rays: _Floats) -> Array:
        """Project rays, as ``cv2.projectPoints``.

        Parameters
        ----------
        rays : array_like, (n, 2)
            Rays ``(x, y)`` at unit depth.

        Returns
        -------
        ndarray, (n, 2)
            Pixels, px; they may be outside the image. NaN beyond the range of the lens model.
        """

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Rig:
    """Two cameras and their factory calibration.

    Parameters
    ----------
    left, right : Camera
        The left camera stands to the left.
    factory : (array_like, array_like), optional
        ``R`` (3, 3) and ``t`` (3,) of ``p_r = R p_l + t``, as ``cv2.stereoCalibrate`` returns them; ``t`` of any
        length. The calibrator starts from them, and trusts their yaw. None: no calibration; the calibrator starts
        side by side, as a guess.
    baseline_m : float, optional
        Length of the baseline, m. `Calibrator.push_range` needs it.
    yaw_sd_rad : float, optional
        Standard deviation of the yaw of `factory`, rad; ``math.inf``: `factory` is a guess. Default: 0.05 degrees, as
        for a calibration with boards.

    Raises
    ------
    ExtrinsicsError
        If no stereo rig has this `factory`.
    """

    def __new__(
        cls,
        left: Camera,
        right: Camera,
        factory: tuple[_Floats, _Floats] | None = None,
        *,
        baseline_m: float | None = None,
        yaw_sd_rad: float | None = None,
    ) -> Rig: ...
    @property
    def left(self) -> Camera:
        """Left camera."""

    @property
    def right(self) -> Camera:
        """Right camera."""

    @property
    def factory(self) -> tuple[Array, Array] | None:
        """``R`` (3, 3) and unit ``t`` (3,), or None."""

    @property
    def baseline_m(self) -> float | None:
        """Length of the baseline, m."""

    @property
    def yaw_sd_rad(self) -> float | None:
        """Standard deviation of the yaw of `factory`, rad."""

    def calibration(self) -> Calibration:
        """Return the factory calibration, or side by side without one."""

    def save(self) -> bytes:
        """Return the record of the factory calibration that a firmware reads, in float32."""

    @classmethod
    def load(cls, record: bytes) -> Rig:
        """Read the record of a factory calibration.

        Raises
        ------
        RestoreError
            If it is damaged, or another kind of record.
        """

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[Any, Any]: ...

@final
class Calibration:
    """Extrinsics, and the cameras that they belong to. With other cameras the extrinsics are wrong.

    ``p_r = R p_l + t``, ``|t| = 1``. Made by `Calibrator.apply`, `Calibrator.in_use` and `Rig.calibration`.
    """

    @property
    def R(self) -> Array:
        """Rotation, left to right camera frame, (3, 3)."""

    @property
    def t(self) -> Array:
        """Unit baseline direction, right camera frame, (3,). ``T`` of OpenCV is ``t * baseline_m``."""

    @property
    def baseline_m(self) -> float | None:
        """Length of the baseline of the rig, m."""

    @property
    def left(self) -> Camera:
        """Left camera."""

    @property
    def right(self) -> Camera:
        """Right camera: as given, or corrected with ``lens="compensate"``."""

    def rectify_maps(self, size: _Size | None = None, alpha: float = 0.0) -> tuple[_Map, _Map]:
        """Return maps for ``cv2.remap``, left and right.

        ``(left, right) = calibration.rectify_maps()``; ``cv2.remap(image, *left, cv2.INTER_LINEAR)``.

        Parameters
        ----------
        size : (int, int), optional
            Width and height of the rectified images, px, of the shape of the left image. Default: its size.
        alpha : float
            0 zooms in until both cameras see every pixel, 1 zooms out until every pixel of both is kept.

        Returns
        -------
        (map_x, map_y), (map_x, map_y) : ndarray of float32, (height, width)
            Pixels of the captured images, px; -10000 where a camera sees nothing.

        Raises
        ------
        RectifyError
            If `alpha` is out of range, or the views share no rectangle.
        """

    def homographies(self, alpha: float = 0.0, size: _Size | None = None) -> tuple[Array, Array]:
        """Return ``H_l`` and ``H_r``, (3, 3): undistorted pixels to rectified pixels, homogeneous.

        Parameters
        ----------
        alpha, size
            As in `rectify_maps`.
        """

    def stereo_rectify(
        self, alpha: float = 0.0, size: _Size | None = None
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Return ``R1, R2, P1, P2, Q`` in the conventions of ``cv2.stereoRectify`` with ``CALIB_ZERO_DISPARITY``.

        ``P2[0, 3]`` is ``-f * baseline_m``, and `Q` gives depth in m; for a baseline of unknown length, in baselines.
        OpenCV turns both views by another angle about the baseline, which does not change the rows.

        Parameters
        ----------
        alpha, size
            As in `rectify_maps`.
        """

    def row_offsets(self, uv_left: _Floats, uv_right: _Floats) -> Array:
        """Return the row offsets of matches.

        Parameters
        ----------
        uv_left, uv_right : array_like, (n, 2)
            Matches, px before undistortion.

        Returns
        -------
        ndarray, (n,)
            Row offsets, px of the mean focal length; NaN where a pixel has no ray.
        """

    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Calibrator:
    """The calibrator of one rig: pairs in, one at a time, the estimate out.

    Fusing never changes the calibration in use; `apply` does. The same matches give the same bits as on a vehicle
    with this capacity. Only one thread may call it at a time: a second thread gets a `BusyError` at once. The GIL is
    released while it computes. After ``os.fork`` parent and child each have a calibrator; a child of a fork during a
    call gets a `BusyError`. A pickle has the record of `save`: the restored estimate is suspect until a pair confirms
    it.

    Parameters
    ----------
    rig : Rig
        Cameras, and start of the estimate.
    capacity : int
        Capacity in matches of a pair: 64, 256, 1024 or 2048. From more matches it selects by image spread and score.
    lens : str
        Errors of the lens models: ``"report"`` them, take the models as ``"given"``, or ``"compensate"`` them.
    max_correction_rad : float, optional
        Pairs further than this from the factory extrinsics are refused, rad. Default 0.5.
    memory_pairs : int, optional
        Pairs after which the oldest fade. Default 1000.
    rows_limit_px, depth_limit_px : float, optional
        Limits of an arming check (`Verdict`), px. Defaults 1 and 2. ``inf`` for depth: the rig uses no metric depth.
    coverage_limit : float, optional
        Least coverage of an arming check. Default 0.7.
    motion : bool
        Whether the tracks of frames (`feed_frames`) tell motion, as `push_motion` does.

    Raises
    ------
    ConfigError, ValueError
        Names the parameter that is out of range.
    """

    def __new__(
        cls,
        rig: Rig,
        capacity: int = 256,
        *,
        lens: Literal["report", "given", "compensate"] = "report",
        max_correction_rad: float | None = None,
        memory_pairs: int | None = None,
        rows_limit_px: float | None = None,
        depth_limit_px: float | None = None,
        coverage_limit: float | None = None,
        motion: bool = False,
    ) -> Calibrator: ...
    def fuse(
        self,
        uv_left: _Floats,
        uv_right: _Floats,
        score: _Floats | None = None,
        *,
        grid_step: float = 0.0,
    ) -> Result:
        """Solve one stereo pair and fuse it into the estimate.

        A pair that the scene spoils gives a result with `Result.rejection`. A mistake of the caller raises an
        exception, and the calibrator is unchanged.

        Parameters
        ----------
        uv_left, uv_right : array_like of float, (n, 2)
            Matches, px before undistortion. Any strides; float32 and float64 are read in place.
        score : array_like of float, (n,), optional
            Confidence of each match, 0 to 1. Default 1.
        grid_step : float
            Step of the grid that the coordinates are rounded to, px; 0: continuous.

        Returns
        -------
        Result
            The estimate after this pair.

        Raises
        ------
        ValueError, TypeError
            Names the argument, its shape and the value.
        PairError
            ``Behind``: left and right are exchanged, or an image is mirrored. ``Columns``: u and v are exchanged.
        BusyError
            If another thread is in a call.
        """

    def feed_frames(self, data: bytes) -> list[Result]:
        """Take bytes of a matcher's stream, in pieces of any length, as the firmware does.

        Damaged frames are skipped and counted in `link`. As on a vehicle no pair raises an error. Tracks of a frame are
        used with ``motion=True``: see `Result.motion`.

        Parameters
        ----------
        data : bytes
            The next bytes.

        Returns
        -------
        list of Result
            One for each completed frame.

        Raises
        ------
        FrameRefusal
            If the images of a frame have another size: none of these bytes is taken.
        """

    @property
    def link(self) -> dict[str, int]:
        """Statistics of the frames: ``good``, ``bad_crc``, ``gaps``, .."""

    def push_range(
        self,
        pixel: Sequence[float],
        range_m: float,
        sd_m: float,
        *,
        along: Literal["ray", "axis"] = "ray",
        right: Sequence[float] | None = None,
    ) -> Literal["taken", "waiting"]:
        """Add a point of known distance, after `fuse`: it tells yaw from the lens.

        Parameters
        ----------
        pixel : (float, float)
            Pixel of the left image.
        range_m, sd_m : float
            Distance from the left camera and its standard deviation, m.
        along : str
            ``"ray"``: as a laser measures it; ``"axis"``: depth.
        right : (float, float), optional
            The same point in the right image. Default: a match of the last pair within 3 px of `pixel` tells it.

        Returns
        -------
        str
            ``"taken"``, or ``"waiting"``: it contradicts the yaw so far, and waits for others that agree with it.

        Raises
        ------
        RangeError
            The estimate is unchanged.
        """

    def push_motion(
        self, before: tuple[_Floats, _Floats], after: tuple[_Floats, _Floats]
    ) -> Literal["taken", "waiting"]:
        """Add matches that were tracked from one pair to a later one, after `fuse`: motion tells yaw from the lens.

        Parameters
        ----------
        before, after : (array_like, array_like)
            Left and right points, (n, 2) each, px. Row i of all four is one point. The rig has moved by several
            baselines.

        Returns
        -------
        str
            As in `push_range`.

        Raises
        ------
        MotionError
            The estimate is unchanged.
        """

    def apply(self) -> Calibration:
        """Apply the estimate.

        Raises
        ------
        ApplyError
            Normal until four pairs agree. Nothing changes.
        """

    def undo(self) -> Calibration:
        """Undo the last `apply`, once.

        Raises
        ------
        ApplyError
            If there is nothing to go back to.
        """

    def reset(self) -> None:
        """Forget all pairs: back to the factory extrinsics."""

    @property
    def verdict(self) -> Verdict:
        """The verdict after the last pair; it stays until the next one."""

    def details(self) -> Details | None:
        """Return the fit of calibration in use and estimate to the last pair; None before the first fused pair."""

    @property
    def in_use(self) -> Calibration:
        """The calibration of the last `apply`; before the first, that of the rig."""

    @property
    def state(self) -> State:
        """State of the estimate."""

    @property
    def generation(self) -> int:
        """Number that changes with the calibration in use."""

    @property
    def frozen(self) -> bool:
        """Whether the estimate and the calibration in use are frozen. May be set."""

    @frozen.setter
    def frozen(self, value: bool, /) -> None: ...
    @property
    def rig(self) -> Rig:
        """The rig."""

    @property
    def capacity(self) -> int:
        """Capacity in matches of a pair."""

    def save(self) -> bytes:
        """Return the record of a firmware: the estimate and the calibration in use, without the rig."""

    def load(self, record: bytes) -> None:
        """Restore a record of the same rig; it replaces everything learnt.

        The estimate is suspect until a pair confirms it.

        Raises
        ------
        RestoreError
            The calibrator is unchanged.
        """

    def __getnewargs_ex__(self) -> tuple[Any, Any]: ...
    def __setstate__(self, record: bytes, /) -> None: ...

@final
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

    @property
    def R(self) -> Array: ...
    @property
    def t(self) -> Array: ...
    @property
    def rms_px_before(self) -> float: ...
    @property
    def rms_px_after(self) -> float: ...
    @property
    def noise_px(self) -> float: ...
    @property
    def usable(self) -> int: ...
    @property
    def fit(self) -> int: ...
    @property
    def skipped(self) -> int: ...
    @property
    def passes(self) -> int: ...
    @property
    def stop(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Verdict:
    """Judgement of the calibration in use by the last pairs.

    Attributes
    ----------
    rows_px : float
        RMS row offset of the calibration in use beyond that of the pair's own pose, px; infinite before the first pair.
    depth_px : float
        Expected RMS error of the disparities in use, px; infinite without an estimate. Depth ``Z`` is off by
        ``Z**2 * depth_px / (focal * baseline)``.
    coverage : float
        Share of the matches that fit the calibration in use, among those that fit the pair's own pose.
    image_coverage : float
        Share of the cells of an 8 x 6 grid over the image with a match that fits the pair's own pose.
    rows_ok, depth_ok : bool
        Whether `rows_px` and `depth_px` are within their limits.
    may_arm : bool
        Yes or no to an arming check.
    should_apply : bool
        Whether `Calibrator.apply` is worthwhile.
    reasons : tuple of str
        Reasons against relying on the calibration, the worst first; may be empty.
    cause : str or None
        The likeliest mistake in rig or matcher, in words: ``"u and v exchanged"``.
    text : str
        All of it in one line.
    """

    @property
    def rows_px(self) -> float: ...
    @property
    def depth_px(self) -> float: ...
    @property
    def coverage(self) -> float: ...
    @property
    def image_coverage(self) -> float: ...
    @property
    def rows_ok(self) -> bool: ...
    @property
    def depth_ok(self) -> bool: ...
    @property
    def may_arm(self) -> bool: ...
    @property
    def should_apply(self) -> bool: ...
    @property
    def reasons(self) -> tuple[str, ...]: ...
    @property
    def cause(self) -> str | None: ...
    @property
    def text(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Details:
    """The calibration in use and the estimate, over the matches of the last pair.

    Attributes
    ----------
    in_use_px, proposed_px, off_px : float
        RMS row offset of the calibration in use, of the estimate, and of their difference, px.
    fit_in_use, fit_proposed : int
        Matches that fit each of both.
    corner_px : float
        Row offset that the apparent yaw of the lenses leaves in the corner of the image, px.
    contradicting_ranges, contradicting_motions : int
        Readings of `push_range` and `push_motion` since the last reset that contradicted the yaw: refused, or
        waiting until more of them agree.
    lens_yaw : Finding
        Apparent yaw of the lenses, rad.
    lens : dict or None
        Errors of the lens models that the pairs show: ``focal``, ``k1``, ``k1_mean``, ``p1``, ``principal_x_px``.
    weakest : tuple
        The least certain direction and its standard deviation, rad.
    yaw : float
        Expected error of the yaw in use, rad: depth ``Z`` is off by ``Z**2 * yaw / baseline``.
    vibration : Sd
        Motion of the rig about the estimate from pair to pair, rad RMS.
    """

    @property
    def in_use_px(self) -> float: ...
    @property
    def proposed_px(self) -> float: ...
    @property
    def off_px(self) -> float: ...
    @property
    def fit_in_use(self) -> int: ...
    @property
    def fit_proposed(self) -> int: ...
    @property
    def corner_px(self) -> float: ...
    @property
    def contradicting_ranges(self) -> int: ...
    @property
    def contradicting_motions(self) -> int: ...
    @property
    def lens_yaw(self) -> Finding: ...
    @property
    def lens(self) -> dict[str, Finding] | None: ...
    @property
    def weakest(self) -> tuple[str, float]: ...
    @property
    def yaw(self) -> float: ...
    @property
    def vibration(self) -> Sd: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Event:
    """A change of a calibrator, with the verdict after it.

    Attributes
    ----------
    time : int
        Time that the caller gave, in the caller's unit.
    pair : int
        Number of the pair.
    changes : tuple of str
        Parts that differ from the event before: ``"state"``, ``"arming"``, ``"applying"``, ``"reasons"``, ``"cause"``,
        ``"generation"``.
    generation : int
        Changes with the calibration in use.
    state : str
        As in `Result`.
    verdict : Verdict
        The verdict after the pair.
    json : str
        All of it as one line of JSON, with the fields of ``selfcal replay --events``.
    text : str
        All of it in one line of text.
    """

    @property
    def time(self) -> int: ...
    @property
    def pair(self) -> int: ...
    @property
    def changes(self) -> tuple[str, ...]: ...
    @property
    def generation(self) -> int: ...
    @property
    def state(self) -> State: ...
    @property
    def verdict(self) -> Verdict: ...
    @property
    def json(self) -> str: ...
    @property
    def text(self) -> str: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class History:
    """The last changes of one calibrator.

    Parameters
    ----------
    capacity : int
        Number of events that are kept.
    """

    def __new__(cls, capacity: int = 256) -> History: ...
    def note(self, calibrator: Calibrator, time: int = 0, pair: int | None = None) -> Event | None:
        """Compare the calibrator with the last event; after each pair, and after `Calibrator.apply` if that is called.

        Parameters
        ----------
        calibrator : Calibrator
            The calibrator of this history.
        time : int
            Time on a clock of the caller, 0 or later, in any unit.
        pair : int, optional
            Number of the pair. Default: one more than in the last call, from 0.

        Returns
        -------
        Event or None
            None if nothing has changed. The numbers of a verdict change with each pair, and are no change by themselves.
        """

    @property
    def events(self) -> list[Event]:
        """The events, the oldest first."""

    @property
    def capacity(self) -> int:
        """Number of events that are kept."""

@final
class Result:
    """The estimate after a pair.

    Attributes
    ----------
    R, t : ndarray or None
        (3, 3) and (3,): ``p_r = R p_l + t``, ``|t| = 1``, over all fused pairs. None before the first.
    state : str
        ``"acquiring"``, ``"locked"``, ``"suspect"`` or ``"lost"``.
    verdict : Verdict
        Whether to arm and to apply, and why not.
    details : Details or None
        Fit over this pair's matches; None before the first fused pair.
    sd, sd_lens : Sd or None
        Standard deviations of ``R`` and ``t``: with the lens models as given, and with them uncertain.
    fused : str or None
        How the pair was fused: ``"added"``, ``"repeated"``, ``"kept_apart"``, ``"renewed"``, ``"took_over"``,
        ``"lens_corrected"``. None if it was not fused: see `rejection`.
    rejection : PairError, Refusal or None
        Why the pair was not fused. This is normal now and then: take the next pair.
    pair : Pair or None
        The solved pair; None if it was not solved.
    motion : str, MotionError or None
        Effect of the tracks that the frame shares with an earlier one, with ``Calibrator(.., motion=True)``:
        ``"taken"``, ``"waiting"``, or why they were refused; ``NoMotion`` and ``TooFew`` are ordinary. None without such
        tracks.
    pairs : int
        Number of pairs in the estimate.
    grid_step : float
        Step of the grid that the rows lie on, px, stated or found: mean over the matches; 0 for continuous rows.
    offered, taken, refused : int
        Matches of this pair: all, those in the batch, and those without a ray or outside the image.
    generation : int
        Changes with the calibration in use.
    frame : Frame or None
        The frame, if it came by `Calibrator.feed_frames`.
    """

    @property
    def R(self) -> Array | None: ...
    @property
    def t(self) -> Array | None: ...
    @property
    def state(self) -> State: ...
    @property
    def verdict(self) -> Verdict: ...
    @property
    def details(self) -> Details | None: ...
    @property
    def sd(self) -> Sd | None: ...
    @property
    def sd_lens(self) -> Sd | None: ...
    @property
    def fused(self) -> str | None: ...
    @property
    def rejection(self) -> PairError | Refusal | None: ...
    @property
    def pair(self) -> Pair | None: ...
    @property
    def motion(self) -> str | MotionError | None: ...
    @property
    def pairs(self) -> int: ...
    @property
    def grid_step(self) -> float: ...
    @property
    def offered(self) -> int: ...
    @property
    def taken(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def generation(self) -> int: ...
    @property
    def frame(self) -> Frame | None: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

def solve_pairs(
    rig: Rig,
    pairs: Iterable[Sequence[_Floats | None]],
    capacity: int = 256,
) -> list[Result]:
    """Solve pairs alone, each from the factory extrinsics, on all processors.

    Parameters
    ----------
    rig : Rig
        Their rig.
    pairs : iterable of (uv_left, uv_right) or (uv_left, uv_right, score)
        As in `Calibrator.fuse`.
    capacity
        As in `Calibrator`.

    Returns
    -------
    list of Result
        In the order of the pairs, each solved by a fresh calibrator.
    """

@final
class Published:
    """The estimate of the published method after a pair (`fuse_published`).

    Attributes
    ----------
    R, t : numpy.ndarray
        ``p_r = R p_l + t``.
    sd : Sd
        Standard errors of the means, rad; after one pair the standard deviations of that pair.
    pairs : int
        Pairs in the estimate.
    axis_is_meaningful : bool
        Whether the rotation has an axis that the pairs agree on. Near ``R = I`` the axis is noise.
    """

    @property
    def R(self) -> Array: ...
    @property
    def t(self) -> Array: ...
    @property
    def sd(self) -> Sd: ...
    @property
    def pairs(self) -> int: ...
    @property
    def axis_is_meaningful(self) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

def fuse_published(
    rig: Rig,
    pairs: Iterable[Sequence[_Floats | None]],
    *,
    angle: Literal["mean", "median"] = "mean",
) -> list[Published | None]:
    """Fuse pairs by the published method, whose only defence against wrong matches is the Huber weight.

    Parameters
    ----------
    rig : Rig
        Their rig. Every pair is solved from its factory extrinsics.
    pairs : iterable of (uv_left, uv_right) or (uv_left, uv_right, score)
        As in `Calibrator.fuse`.
    angle : str
        Average of the rotation angles: ``"mean"`` or ``"median"``.

    Returns
    -------
    list of Published or None
        The estimate after each pair; None before the first fused pair.
    """

def read_rig(
    *paths: _Path,
    size: _Size | None = None,
    unit_m: float = 1.0,
    cameras: tuple[int, int] | None = None,
) -> Rig:
    """Read the rig of a file or folder: meta.json, or any format that ``selfcal import`` reads.

    Doubts about the rig, such as a size that the principal point contradicts, are issued as UserWarning.

    Parameters
    ----------
    *paths : path
        One, or several: OpenCV's ``intrinsics.yml`` and ``extrinsics.yml``.
    size : (int, int), optional
        Image width and height, px, which some formats lack. A rig of another size is refused.
    unit_m : float
        Length of OpenCV's unit of ``T``, m.
    cameras : (int, int), optional
        Numbers of the left and right camera in a file of several; ``(1, 0)`` exchanges them.

    Raises
    ------
    ValueError
        Names the file, the key and the expected value.
    FileNotFoundError
        If there is no such file.
    """

def match(
    left: npt.NDArray[np.uint8] | npt.NDArray[np.uint16] | _Path,
    right: npt.NDArray[np.uint8] | npt.NDArray[np.uint16] | _Path,
    rig: Rig,
    *,
    prior_deg: float = 6.0,
    keypoints: int = 3000,
) -> Matches:
    """Match two images, as ``selfcal images`` does.

    Parameters
    ----------
    left, right : ndarray, (height, width), or path
        Grey images as captured, 8 or 16 bits.
    rig : Rig
        Its factory extrinsics give the rows to search.
    prior_deg : float
        Largest turn of the cameras since the calibration, degrees, 0.1 to 20.
    keypoints : int
        Corners sought in each image.

    Returns
    -------
    Matches
        The most certain first: ``calibrator.fuse(*match(left, right, rig))``.

    Raises
    ------
    ValueError
        If an image has another size or is empty, or left and right are exchanged.
    """

def check(
    source: _Path | tuple[_Path, _Path],
    rig: Rig | _Path | Sequence[_Path] | None = None,
    *,
    focal_px: float | None = None,
    every: int = 1,
    pairs: int | None = None,
) -> Check:
    """Check whether a rig still fits its calibration, as ``selfcal check`` does.

    Parameters
    ----------
    source : path, or (path, path)
        A folder, an MCAP file or a ROS 1 bag; or the left and the right folder or pattern.
    rig : Rig or path, optional
        The calibration; None: the one beside the images.
    focal_px : float, optional
        Guess the calibration from this focal length, px.
    every, pairs : int
        Take one of so many pairs, and at most so many pairs in all.
    """

def encode_frame(
    sequence: int,
    uv_left: _Floats,
    uv_right: _Floats,
    score: _Floats | None = None,
    *,
    size: _Size,
    tracks: Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
) -> bytes:
    """Encode matches as a matcher sends them, with coordinates in 1/256 px; for tests of a receiver.

    Parameters
    ----------
    sequence : int
        Number of the frame.
    uv_left, uv_right, score
        As in `Calibrator.fuse`.
    size : (int, int)
        Image width and height, px.
    tracks : sequence of int, (n,), optional
        Track of each match, the same number in each frame, up to 4095; 0: not tracked.
    """
