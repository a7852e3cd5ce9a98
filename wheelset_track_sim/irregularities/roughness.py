"""Random roughness of a tread or a rail, over the whole of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..schema import check, quantity

LIMIT_WAVELENGTHS = (0.4, 0.0315, 0.00315)
LIMIT_LEVELS = (17.1, -5.0, -11.0)
"""Limit of the roughness of a test track, ISO 3095:2013: straight lines between these wavelengths, m, over their
logarithm; levels of third octaves in dB re 1 um."""

ACROSS = 4
"""Waves across for each wave along."""


@dataclass(frozen=True)
class Roughness:
    """Waves of random phase whose third octaves along the surface follow the limit of ISO 3095, ``level`` dB above it.

    It repeats after ``length``: the circumference, or what is simulated of a rail. Lines along the surface ``d`` apart
    are coherent by exp(-k d) at the wavenumber ``k``, as those of a surface alike in all directions nearly are; no wave
    is shorter across than the shortest along.
    """

    type: ClassVar[str] = "roughness"
    angle: ClassVar[float] = 0.0
    position: ClassVar[float] = 0.0
    half_length: ClassVar[float] = float("inf")

    on: str
    length: float = quantity("m", 0.1, 1000.0, "length after which it repeats")
    seed: int = quantity("", 0, 2**32 - 1, "seed of the random phases", default=0)
    level: float = quantity("dB", -60.0, 40.0, "level above the limit of ISO 3095", default=0.0)
    shortest: float = quantity("m", 0.002, 0.1, "shortest wavelength", default=0.005)
    longest: float = quantity("m", 0.002, 10.0, "longest wavelength", default=0.5)

    def __post_init__(self) -> None:
        if self.on not in ("wheel_1", "wheel_2", "rail_1", "rail_2"):
            raise InputError(f"on = {self.on!r} is not a known surface: give wheel_1, wheel_2, rail_1 or rail_2")
        check(self)
        if not len(self.waves):
            raise InputError(
                f"no wave between shortest = {self.shortest:g} m and longest = {self.longest:g} m repeats after "
                f"{self.length:g} m: give a wider band"
            )

    @property
    def waves(self) -> NDArray[np.int64]:
        """Numbers of waves along the length."""
        return np.arange(np.ceil(self.length / self.longest), self.length // self.shortest + 1, dtype=np.int64)

    def height(self, s: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height of the surface over the nominal one, m.

        ``s`` is the distance from step 0 along the surface and ``y`` the lateral position, both in m; they broadcast.
        """
        k = 2 * np.pi * self.waves / self.length
        limit = np.interp(np.log(2 * np.pi / k), np.log(LIMIT_WAVELENGTHS[::-1]), LIMIT_LEVELS[::-1])
        in_band = 1e-12 * 10 ** ((limit + self.level) / 10)  # mean square in the third octave around k, m^2
        density = in_band / (k * (2 ** (1 / 6) - 2 ** (-1 / 6)))
        amplitude = np.sqrt(2 * density * 2 * np.pi / self.length / ACROSS)
        random = np.random.default_rng(self.seed)
        # Cauchy's distribution of wavenumbers across, whose transform is exp(-k d), cut off.
        widest = np.arctan(2 * np.pi / self.shortest / k)
        across = k * np.tan(widest * random.uniform(-1.0, 1.0, (ACROSS, len(k))))
        phase = random.uniform(0.0, 2 * np.pi, (ACROSS, len(k)))

        s, y = np.asarray(s, float), np.asarray(y, float)
        shape = np.broadcast_shapes(s.shape, y.shape)
        if shape != (s.size, y.size):  # but for a grid, point by point
            s, y = (each.ravel() for each in np.broadcast_arrays(s, y))
        height = np.zeros((s.size, y.size) if shape == (s.size, y.size) else s.size)
        along = np.exp(1j * np.outer(s, k))
        for m, turn in zip(across, phase, strict=True):
            sideways = amplitude * np.exp(1j * (np.outer(y, m) + turn))
            height += (along @ sideways.T if height.ndim == 2 else (along * sideways).sum(axis=1)).real
        return height.reshape(shape)
