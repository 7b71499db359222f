"""Online self-calibration of a stereo rig: matches in, calibrated rig out.

``p_r = R p_l + t`` with ``|t| = 1``; camera frames are x right, y down, z forward. Pixels ``(u, v)`` refer to the
images before undistortion, and ``(0, 0)`` is the centre of the top left one. Angles are in radians. Numbers equal
those of a vehicle with the same capacity, bit for bit.
"""

from ._errors import (
    ApplyError,
    BusyError,
    CameraError,
    ConfigError,
    ExtrinsicsError,
    FrameRefusal,
    MotionError,
    PairError,
    RangeError,
    RectifyError,
    Refusal,
    RestoreError,
    SelfcalError,
)
from ._native import (
    Calibration,
    Calibrator,
    Camera,
    Health,
    Pair,
    Result,
    Rig,
    check,
    encode_frame,
    match,
    read_rig,
    solve_pairs,
)
from ._plot import plot
from ._results import Check, Finding, Frame, Matches, Sd

__all__ = [
    "ApplyError",
    "BusyError",
    "Calibration",
    "Calibrator",
    "Camera",
    "CameraError",
    "Check",
    "ConfigError",
    "ExtrinsicsError",
    "Finding",
    "Frame",
    "FrameRefusal",
    "Health",
    "Matches",
    "MotionError",
    "Pair",
    "PairError",
    "RangeError",
    "RectifyError",
    "Refusal",
    "RestoreError",
    "Result",
    "Rig",
    "Sd",
    "SelfcalError",
    "check",
    "encode_frame",
    "match",
    "plot",
    "read_rig",
    "solve_pairs",
]
