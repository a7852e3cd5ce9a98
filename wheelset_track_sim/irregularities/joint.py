"""Joints and welds of rails, as heights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ..inputs.schema import quantity
from ..runtime.arrays import Real
from .head_defect import position
from .surface import RAILS, Patch, Surface, check_shape

OPEN = 0.5e-3
"""Depth of a gap, m: no wheel that bridges it bends so far into it."""


@dataclass(frozen=True)
class Joint:
    """A joint whose two rail ends dip to it, as parabolas over ``length``, with a gap or an end post between them.

    ``dip_angle`` is the whole angle between the two ends, 2 alpha of Jenkins, Stephenson, Clayton, Morland and Lyon
    (The effect of track and vehicle parameters on wheel/rail vertical dynamic forces, Railway Engineering Journal 3,
    1974): ends of the length l = length/2 meet at the depth alpha l/2. The softer support of a joint is the track's.
    """

    type: ClassVar[str] = "joint"

    on: Literal["rail_1", "rail_2"]
    position: float = position()
    dip_angle: float = quantity("rad", 0.0, 0.04, "the angle between the two rail ends")
    length: float = quantity("m", 0.05, 4.0, "the length of both dipped ends together", default=1.0)
    gap: float = quantity("m", 0.0, 0.020, "the width of the gap, without contact", default=0.006)

    def __post_init__(self) -> None:
        check_shape(self, RAILS)

    @property
    def end(self) -> float:
        """Position where it ends, m."""
        return self.position + self.length / 2

    @property
    def depth(self) -> float:
        """Of the ends where they meet, m."""
        return self.dip_angle * self.length / 8

    def height(self, s: Real) -> Real:
        """Height, m, at ``s`` from the middle along the rail, m."""
        rest = np.maximum(1.0 - np.abs(s) / (self.length / 2), 0.0)
        return -self.depth * rest**2 - np.where(np.abs(s) < self.gap / 2, OPEN, 0.0)

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions."""
        yield surface.around(surface.at(self.position), self.length / 2, self.height)


@dataclass(frozen=True)
class DippedWeld:
    """A weld that lies too low, or too high with a negative ``depth``: h = -d/2 (1 + cos(2 pi s/L)).

    Measured welds and their idealisation: Steenbergen and Esveld, Relation between the geometry of rail welds and the
    dynamic wheel-rail response, Proc. IMechE F 220, 2006.
    """

    type: ClassVar[str] = "dipped_weld"

    on: Literal["rail_1", "rail_2"]
    position: float = position()
    depth: float = quantity("m", -0.003, 0.005, "the depth of the middle")
    length: float = quantity("m", 0.05, 4.0, "the length", default=1.0)

    def __post_init__(self) -> None:
        check_shape(self, RAILS)

    @property
    def end(self) -> float:
        """Position where it ends, m."""
        return self.position + self.length / 2

    def height(self, s: Real) -> Real:
        """Height, m, at ``s`` from the middle along the rail, m."""
        inside = np.minimum(np.abs(s), self.length / 2)
        return -0.5 * self.depth * (1.0 + np.cos(2 * np.pi * inside / self.length))

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions."""
        yield surface.around(surface.at(self.position), self.length / 2, self.height)
