"""Online self-calibration of a stereo rig: matches in, calibrated rig out.

``p_r = R p_l + t`` with ``|t| = 1``; camera frames are x right, y down, z forward. Pixels ``(u, v)`` refer to the
images before undistortion, and ``(0, 0)`` is the centre of the top left one. Angles are in radians. Numbers equal
those of a vehicle with the same capacity, bit for bit.
"""

from importlib.metadata import version

from . import _errors, _native, _plot, _results
from ._errors import *
from ._native import *
from ._plot import *
from ._results import *

__version__ = version("stereo-selfcal")

__all__ = _errors.__all__ + _native.__all__ + _plot.__all__ + _results.__all__
