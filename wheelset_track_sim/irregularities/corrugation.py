"""Corrugation of a rail."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import quantity
from ..runtime.arrays import Real
from .stretch import check_stretch, length, part_of, ramp, start
from .surface import RAILS, Patch, Surface, check_shape


@dataclass(frozen=True)
class Corrugation:
    """Waves along a rail, the same over the width of its head, over a stretch or all along.

    All along, the wavelength is the nearest of which a whole number fits into the line. Phases are rounded to 1e-9 of
    a wave: a wavelength that is a whole number of steps repeats to the last bit, and has few different contacts.
    """

    type: ClassVar[str] = "corrugation"

    on: Literal["rail_1", "rail_2"]
    wavelength: float = quantity("m", 0.01, 3.0, "the wavelength")
    amplitude: float = quantity("m", 0.0, 0.002, "the amplitude, half of the waves' height")
    phase: float = quantity("rad", -2 * np.pi, 2 * np.pi, "the phase: 0 is a crest at the start", default=0.0)
    start: float = start()
    length: float | None = length()
    ramp: float = ramp()

    def __post_init__(self) -> None:
        check_shape(self, RAILS)
        check_stretch(self.start, self.length, self.ramp)

    @property
    def end(self) -> float:
        """Position where the stretch ends, m."""
        return self.start + (self.length or 0.0)

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions; InputError for waves shorter than two steps."""
        if self.wavelength < 2 * surface.dx:
            raise InputError(
                f"wavelength = {self.wavelength:g} m is less than two steps: give at least {2 * surface.dx:g} m"
            )
        part = part_of(surface, self.start, self.length, self.ramp)
        wavelength = self.wavelength
        if self.length is None:
            wavelength = surface.length / max(1, round(surface.length / wavelength))
        waves = np.round(np.arange(part.steps) * surface.dx / wavelength % 1.0, 9) % 1.0
        heights = self.amplitude * np.cos(2 * np.pi * waves + self.phase)
        yield Patch(part.first, (heights * part.share)[:, None])
