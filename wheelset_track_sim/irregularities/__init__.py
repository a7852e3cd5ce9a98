"""Deviations of treads and rails from their nominal surfaces: one small class each, one protocol.

A height is negative where material is missing, exactly as Eq. (22) is printed. In the kinematic constraint of
Eq. (12) missing material must widen the gap, so there ``r = -height``: the contact subtracts heights.
"""

from .breakout import TREAD_HALF_WIDTH, Breakout
from .rail import RailIrregularity, rail_heights
from .roughness import Roughness
from .tread import TreadIrregularity, tread_heights

__all__ = [
    "TREAD_HALF_WIDTH",
    "Breakout",
    "RailIrregularity",
    "Roughness",
    "TreadIrregularity",
    "rail_heights",
    "tread_heights",
]
