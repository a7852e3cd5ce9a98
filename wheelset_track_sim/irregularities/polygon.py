"""Polygonal wheels: periodic out-of-roundness."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from .surface import WHEELS, Patch, Surface, check_shape


@dataclass(frozen=True)
class Harmonic:
    """Waves around the wheel."""

    order: int = quantity("", 1, 300, "the number of waves around the wheel")
    amplitude: float = quantity("m", 0.0, 0.002, "the amplitude, half of the waves' height")
    phase: float = quantity("rad", -2 * np.pi, 2 * np.pi, "the phase: 0 is a crest at angle 0", default=0.0)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Polygon:
    """Sum of harmonics, h = sum of A cos(n angle + phase), the same over the width of the tread."""

    type: ClassVar[str] = "polygon"

    on: Literal["wheel_1", "wheel_2"]
    harmonics: tuple[Harmonic, ...]

    def __post_init__(self) -> None:
        check_shape(self, WHEELS)
        if not 1 <= len(self.harmonics) <= 300:
            raise InputError(f"harmonics has {len(self.harmonics)} entries: give 1 to 300")

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions; InputError for waves shorter than two steps."""
        heights = np.zeros(surface.steps)
        for each in self.harmonics:
            if 2 * each.order > surface.steps:
                raise InputError(
                    f"order = {each.order} has waves shorter than two steps: give up to {surface.steps // 2}"
                )
            turns = each.order * np.arange(surface.steps) % surface.steps / surface.steps
            heights += each.amplitude * np.cos(2 * np.pi * turns + each.phase)
        yield Patch(0, heights[:, None])
