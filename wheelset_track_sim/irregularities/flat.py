"""Wheel flats, fresh and rounded."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import quantity
from ..runtime.arrays import Real
from .surface import WHEELS, Patch, Surface, check_shape


@dataclass(frozen=True)
class Flat:
    """A flat that sliding has ground into the tread, over its whole width.

    Fresh, it is a chord of ``length`` L: of the depth d = R - sqrt(R^2 - L^2/4), about L^2/(8 R), with sharp edges. In
    running, the edges are rounded: then the flat is ``worn_length`` L0 long, and the depth, which stays, falls to the
    ends as a cosine, h = -d/2 (1 + cos(2 pi s/L0)). Both shapes are those of Newton and Clark (J. Mech. Eng. Sci. 21,
    1979) and of Nielsen and Igeland (J. Sound Vib. 187, 1995).
    """

    type: ClassVar[str] = "flat"

    on: Literal["wheel_1", "wheel_2"]
    length: float = quantity("m", 0.005, 0.15, "length of the flat when it was fresh")
    worn_length: float | None = quantity("m", 0.005, 0.5, "the length of the rounded flat", default=None)
    """None if it is fresh."""
    angle: float = quantity(
        "rad", -2 * np.pi, 2 * np.pi, "angle of the centre, in the order in which the tread meets the rail", default=0.0
    )

    def __post_init__(self) -> None:
        check_shape(self, WHEELS)
        if self.worn_length is not None and self.worn_length < self.length:
            raise InputError(
                f"worn_length = {self.worn_length:g} m is less than the fresh length of {self.length:g} m: "
                f"give at least that"
            )

    def depth(self, radius: float) -> float:
        """Of the middle, m, on a wheel of ``radius``, m."""
        return float(radius - np.sqrt(radius**2 - self.length**2 / 4))

    def height(self, s: Real, radius: float) -> Real:
        """Height of the surface over a cylinder of ``radius``, m, at ``s`` from the middle along the tread, m."""
        depth = self.depth(radius)
        if self.worn_length is None:
            chord = s**2 / (radius + np.sqrt(radius**2 - s**2)) - depth
            return np.where(np.abs(s) < self.length / 2, chord, 0.0)
        worn = -0.5 * depth * (1.0 + np.cos(2 * np.pi * s / self.worn_length))
        return np.where(np.abs(s) < self.worn_length / 2, worn, 0.0)

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions."""
        half = (self.length if self.worn_length is None else self.worn_length) / 2
        yield surface.around(surface.at_angle(self.angle), half, lambda s: self.height(s, surface.radius))
