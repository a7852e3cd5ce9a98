"""Local defects of a rail head."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..inputs.schema import quantity
from ..runtime.arrays import Real
from .breakout import TREAD_HALF_WIDTH, hollow
from .surface import RAILS, Patch, Surface, check_shape


def position() -> Any:
    """Field for the position of a centre along the track."""
    return quantity("m", 0.0, 1e5, "position of the centre along the track")


def depth() -> Any:
    """Field for the depth of a defect."""
    return quantity("m", 0.0, 0.005, "depth")


@dataclass(frozen=True)
class HeadDefect:
    """A hollow in the head, such as a spall or a wheel burn: an ellipse, with the cosine of Eq. (22)."""

    type: ClassVar[str] = "head_defect"

    on: Literal["rail_1", "rail_2"]
    position: float = position()
    a: float = quantity("m", 0.001, 0.5, "longitudinal semi-axis")
    b: float = quantity("m", 0.001, TREAD_HALF_WIDTH, "lateral semi-axis")
    h: float = depth()
    y: float = quantity("m", -0.036, 0.036, "lateral position of the centre from the middle of the head", default=0.0)

    def __post_init__(self) -> None:
        check_shape(self, RAILS)

    @property
    def end(self) -> float:
        """Position where it ends, m."""
        return self.position + self.a

    def height(self, s: ArrayLike, y: ArrayLike) -> Real:
        """Height, m, at ``s`` from the centre along the rail and ``y`` across it, m."""
        return hollow(np.asarray(s, float) / self.a, (np.asarray(y, float) - self.y) / self.b, self.h)

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface`` at lateral positions ``y``, m."""
        yield surface.around(surface.at(self.position), self.a, lambda s: self.height(s, y))


@dataclass(frozen=True)
class Squat(HeadDefect):
    """A squat: the hollow of a head defect with a ridge across its middle, which makes two lobes of it."""

    type: ClassVar[str] = "squat"

    ridge: float = quantity("", 0.0, 1.0, "the height of the ridge as a share of the depth", default=0.5)

    def height(self, s: ArrayLike, y: ArrayLike) -> Real:
        """Height, m, at ``s`` from the centre along the rail and ``y`` across it, m."""
        on_ridge = 0.5 + 0.5 * np.cos(np.pi * np.minimum(np.abs(np.asarray(s, float)) / (self.a / 2), 1.0))
        return np.asarray(super().height(s, y) * (1.0 - self.ridge * on_ridge))
