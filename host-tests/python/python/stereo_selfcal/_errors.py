"""Errors of the core: one class for each of its operations, with a stable number and advice."""

from __future__ import annotations

__all__ = [
    "ApplyError", "BusyError", "CameraError", "ConfigError", "ExtrinsicsError", "FrameRefusal", "MotionError",
    "PairError", "RangeError", "RectifyError", "Refusal", "RestoreError", "SelfcalError",
]


class SelfcalError(Exception):
    """An error of the core.

    Attributes
    ----------
    kind : str
        Name of the error within its class, as in Rust: ``"TooFew"``.
    code : int
        Number of the remedy, as in the C API: errors with the same remedy have the same number.
    advice : str
        Remedy.
    """

    def __init__(self, message: str, kind: str, code: int) -> None:
        super().__init__(message, kind, code)
        self.kind = kind
        self.code = code
        self.advice = ADVICE.get(code, "")

    def __str__(self) -> str:
        message = str(self.args[0])
        return f"{message}. {self.advice}" if self.advice else message


class CameraError(SelfcalError, ValueError):
    """No camera has these intrinsics or lens coefficients."""


class ExtrinsicsError(SelfcalError, ValueError):
    """No stereo rig has this ``R`` and ``t``."""


class ConfigError(SelfcalError, ValueError):
    """A parameter is out of its range."""


class PairError(SelfcalError):
    """A pair could not be solved."""


class Refusal(SelfcalError):
    """A solved pair was not fused."""


class ApplyError(SelfcalError):
    """Nothing was applied."""


class RangeError(SelfcalError):
    """A known distance was refused."""


class MotionError(SelfcalError):
    """Tracked matches were refused."""


class RectifyError(SelfcalError, ValueError):
    """The rig has no common rectified camera."""


class RestoreError(SelfcalError, ValueError):
    """A record was refused."""


class FrameRefusal(SelfcalError, ValueError):
    """A frame does not belong to this rig."""


class BusyError(SelfcalError, RuntimeError):
    """Two threads use a calibrator at the same time."""


_CAMERA = "Correct the named quantity."
_CONFIG = "Correct the named parameter."
_PIXEL = "Drop the match; if there are many, the image size or lens is wrong."

#: Advice by number of the core. A test compares the numbers with those in the core's source.
ADVICE: dict[int, str] = {
    **dict.fromkeys(range(100, 104), _CAMERA),
    120: _PIXEL,
    121: _PIXEL,
    122: _PIXEL,
    200: "Correct R: rows orthonormal, determinant 1, left to right camera frame.",
    201: "Correct t: p_r = R p_l + t, any length above 0.",
    202: "A baseline along an optical axis cannot be rectified: correct R or t.",
    **dict.fromkeys([*range(300, 310), *range(311, 318)], _CONFIG),
    401: "Finish the pair first.",
    502: "The pair has too few matches: take the next pair, or match more points.",
    503: "The matches are nearly all wrong: take the next pair; if all pairs fail, check the matcher.",
    504: "Take a pair with points spread over the image and in depth.",
    506: "Exchange left and right, or change the sign of t; check that no image is mirrored.",
    507: "Pass points as (u, v), and a rig whose cameras stand side by side.",
    508: "Check that left and right come from two cameras; a plane alone gives no depth.",
    509: "Let the matcher search across rows, by a few pixels, and report the rows that it finds.",
    600: "Take the next pair.",
    601: "If it repeats, the factory extrinsics are wrong, or the mount has moved.",
    602: "Take the next pair.",
    603: "Take the next pair: three that agree with each other replace the estimate.",
    605: "The calibrator is frozen, as asked for.",
    700: "Fuse pairs first.",
    701: "Look for biased matches or wrong intrinsics.",
    702: "Fuse more pairs: at least four must agree.",
    703: "Look for biased matches or wrong intrinsics, and change the view.",
    705: "Nothing to do.",
    800: "Pass alpha from 0 to 1.",
    801: "The views share no rectangle: keep the last rectification, and check left and right.",
    802: "The rig is turned too far to be rectified.",
    803: "The lens model ends within the image: check its coefficients.",
    1000: "Use an older record, or start from the factory calibration.",
    1001: "It is another kind of record.",
    1002: "Start from the factory calibration: firmware and this package must have one layout.",
    1003: "Make the calibrator with the rig of the record, or start afresh.",
    1004: "Start from the factory calibration.",
    1005: "Make the calibrator with the options of the record, or raise max_correction_rad.",
    1102: "Make the rig with the images of this matcher.",
    1200: "Make the rig with baseline_m.",
    1202: "Pass a distance and a standard deviation, m, of a sensor.",
    1203: "Take another pair; for a range, pass a pixel within 3 px of a match of the last pair, or the right pixel.",
    1204: "The sensor or the tracker saw something else, or its scale is wrong.",
    1222: "Normal at rest and in a turn: the rig must move by several baselines.",
}
