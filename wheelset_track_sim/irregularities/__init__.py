"""Deviations of treads and rails from their nominal surfaces: one small class each, one protocol.

A height is negative where material is missing, exactly as Eq. (22) is printed. In the kinematic constraint of
Eq. (12) missing material must widen the gap, so there ``r = -height``: the contact subtracts heights.

Other packages may add kinds: ``irregularities.kinds`` says how, ``examples/irregularity_kind`` is such a package.
"""

from collections.abc import Iterable, Iterator

from ..inputs.schema import quantity
from .breakout import TREAD_HALF_WIDTH, Breakout
from .cluster import Cluster, LogNormal, Normal, Uniform
from .corrugation import Corrugation
from .flat import Flat
from .head_defect import HeadDefect, Squat
from .joint import DippedWeld, Joint
from .kinds import known_kinds, plain_irregularities, read_irregularities
from .measured import Profile
from .polygon import Harmonic, Polygon
from .roughness import Roughness
from .surface import Irregularity, Patch, RailHeights, Surface, check_shape, line_steps, rail_heights, tread_heights


def breakouts(irregularities: Iterable[Irregularity]) -> Iterator[Breakout]:
    """All breakouts, those of clusters among them."""
    for each in irregularities:
        if isinstance(each, Cluster):
            yield from each.breakouts
        elif isinstance(each, Breakout):
            yield each


__all__ = [
    "TREAD_HALF_WIDTH",
    "Breakout",
    "Cluster",
    "Corrugation",
    "DippedWeld",
    "Flat",
    "Harmonic",
    "HeadDefect",
    "Irregularity",
    "Joint",
    "LogNormal",
    "Normal",
    "Patch",
    "Polygon",
    "Profile",
    "RailHeights",
    "Roughness",
    "Squat",
    "Surface",
    "Uniform",
    "breakouts",
    "check_shape",
    "known_kinds",
    "line_steps",
    "plain_irregularities",
    "quantity",
    "rail_heights",
    "read_irregularities",
    "tread_heights",
]
