"""Random roughness of a tread or a rail."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, doubt, warn
from ..inputs import shipped
from ..inputs.schema import Quantity, quantity
from ..inputs.tables import read_table
from ..runtime.arrays import Real
from .stretch import check_stretch, length, part_of, ramp, start
from .surface import RAILS, WHEELS, Patch, Surface, check_shape

LIMIT_WAVELENGTHS = (0.4, 0.0315, 0.00315)
LIMIT_LEVELS = (17.1, -5.0, -11.0)
"""Limit of the roughness of a test track, ISO 3095:2013: straight lines between these wavelengths, m, over their
logarithm; levels of third octaves in dB re 1 um."""

ACROSS = 4
"""Waves across for each wave along."""
COVERED = 0.5
"""Share of the band, over the logarithm of the wavelength, that a spectrum covers at least."""
EDGE = 1.26
"""A third octave: the next band beyond the ends of a spectrum has their levels."""
STEEPEST = 5e-3
"""Root mean square of a third octave over its wavelength at most: no surface that is run on is as steep."""
WAVELENGTH = Quantity("m", 0.0005, 20.0, "a wavelength")
LEVEL = Quantity("dB", -80.0, 80.0, "a level re 1 um")


@dataclass(frozen=True)
class Roughness:
    """Waves of random phase whose third octaves along the surface follow a spectrum, ``level`` dB above it.

    The spectrum is a table of wavelength, m, and level of its third octave, dB re 1 um, with straight lines over the
    logarithm of the wavelength between them; ``file`` is a text file of it. Without one it is the limit of ISO 3095.
    Treads are rough all around, rails all along or over a stretch. Lines along the surface ``d`` apart are coherent by
    exp(-k d) at the wavenumber ``k``, as those of a surface alike in all directions nearly are; no wave is shorter
    across than the shortest along.
    """

    type: ClassVar[str] = "roughness"

    on: Literal["wheel_1", "wheel_2", "rail_1", "rail_2"]
    seed: int = quantity("", 0, 2**32 - 1, "seed of the random phases", default=0)
    level: float = quantity("dB", -60.0, 40.0, "level above the spectrum", default=0.0)
    shortest: float = quantity("m", 0.002, 0.1, "shortest wavelength", default=0.005)
    longest: float = quantity("m", 0.002, 10.0, "longest wavelength", default=0.5)
    spectrum: tuple[tuple[float, float], ...] = ()
    """Wavelengths, m, and levels of their third octaves, dB re 1 um."""
    start: float = start()
    length: float | None = length()
    ramp: float = ramp()
    file: str = ""
    """File of the spectrum; read if ``spectrum`` is empty, so that a scenario and its bag need no other file."""

    def __post_init__(self) -> None:
        check_shape(self, (*WHEELS, *RAILS))
        if self.file and not self.spectrum:
            object.__setattr__(self, "spectrum", read_spectrum(self.file))
        if self.on in WHEELS and (self.length is not None or self.start):
            raise InputError(
                f"start and length apply to rails only: leave them out for {self.on}, which is rough all around"
            )
        check_stretch(self.start, self.length, self.ramp)
        if len(self.spectrum) == 1:
            raise InputError("spectrum has one entry: give at least two wavelengths with their levels, or none")
        for number, (wavelength, level) in enumerate(self.spectrum):
            for index, known, value in ((0, WAVELENGTH, wavelength), (1, LEVEL, level)):
                refusal = known.refusal(f"spectrum.{number}.{index}", value)
                if refusal:
                    raise InputError(refusal)
        if len({wavelength for wavelength, _ in self.spectrum}) != len(self.spectrum):
            raise InputError("spectrum names a wavelength twice: give each once")
        if self.longest < self.shortest:
            raise InputError(
                f"longest = {self.longest:g} m is less than shortest = {self.shortest:g} m: give a wider band"
            )
        self._check_spectrum()

    @property
    def end(self) -> float:
        """Position where the stretch ends, m."""
        return self.start + (self.length or 0.0)

    def levels(self, wavelength: ArrayLike) -> Real:
        """Levels, dB re 1 um, of the third octaves around wavelengths, m, ``level`` included."""
        known = np.array(sorted(self.spectrum) or sorted(zip(LIMIT_WAVELENGTHS, LIMIT_LEVELS, strict=True)))
        return np.asarray(np.interp(np.log(wavelength), np.log(known[:, 0]), known[:, 1]) + self.level)

    def _check_spectrum(self) -> None:
        """Refuse a spectrum that leaves most of the band to its ends, and warn of what looks wrong."""
        if not self.spectrum:
            return
        wavelength, level = np.array(sorted(self.spectrum)).T
        steep = 1e-6 * 10 ** ((level + self.level) / 20) / wavelength
        if steep.max() > STEEPEST:
            at = int(steep.argmax())
            warn(
                f"spectrum has {level[at] + self.level:g} dB re 1 um at a wavelength of {wavelength[at]:g} m, which is "
                f"{steep[at]:.2g} of the wavelength, and running surfaces have at most {STEEPEST:g}: check the "
                "units, m and dB"
            )
        covered = _covered(wavelength, self.shortest, self.longest)
        if self.shortest * EDGE >= wavelength[0] and self.longest <= wavelength[-1] * EDGE:
            return
        words = (
            f"spectrum covers wavelengths from {wavelength[0]:g} to {wavelength[-1]:g} m, and roughness is made from "
            f"shortest = {self.shortest:g} to longest = {self.longest:g} m"
        )
        if covered < COVERED:
            units = (("cm", 1e-2), ("mm", 1e-3))
            alike = [name for name, size in units if _covered(size * wavelength, self.shortest, self.longest) > COVERED]
            hint = f"give wavelengths in m, if these are in {alike[0]}, or" if alike else "give"
            doubt(f"{words}: {hint} a spectrum over the band, or a band within it")
            return
        missing = [
            f"{low:g} to {high:g} m"
            for low, high in ((self.shortest, wavelength[0]), (wavelength[-1], self.longest))
            if high > low * EDGE
        ]
        warn(f"{words}: its end levels are used from {' and '.join(missing)}, give levels there, or a band within it")

    def field(self, steps: int, dx: float, y: Real) -> Real:
        """Heights that repeat after ``steps`` of ``dx``, m, at lateral positions ``y``, m: (steps, len(y)), m.

        Raises InputError if no wave of the band repeats, or if waves are shorter than two steps.
        """
        length = steps * dx
        if self.shortest < 2 * dx * (1 - 1e-9):
            raise InputError(f"shortest = {self.shortest:g} m is less than two steps of {dx:g} m: give {2 * dx:g} m")
        waves = np.arange(np.ceil(length / self.longest), min(length // self.shortest, (steps - 1) // 2) + 1, dtype=int)
        if not len(waves):
            raise InputError(
                f"no wave between shortest = {self.shortest:g} m and longest = {self.longest:g} m repeats after "
                f"{length:g} m: give a wider band"
            )
        k = 2 * np.pi * waves / length
        in_band = 1e-12 * 10 ** (self.levels(2 * np.pi / k) / 10)  # mean square in the third octave around k, m^2
        density = in_band / (k * (2 ** (1 / 6) - 2 ** (-1 / 6)))
        amplitude = np.sqrt(2 * density * 2 * np.pi / length / ACROSS)
        random = np.random.default_rng(self.seed)
        # Cauchy's distribution of wavenumbers across, whose transform is exp(-k d), cut off.
        widest = np.arctan(2 * np.pi / self.shortest / k)
        across = k * np.tan(widest * random.uniform(-1.0, 1.0, (ACROSS, len(k))))
        phase = random.uniform(0.0, 2 * np.pi, (ACROSS, len(k)))
        heights = np.empty((steps, len(y)))
        for j, at in enumerate(y):
            spectrum = np.zeros(steps // 2 + 1, np.complex128)
            spectrum[waves] = steps / 2 * amplitude * np.exp(1j * (across * at + phase)).sum(axis=0)
            heights[:, j] = np.fft.irfft(spectrum, steps)
        return heights

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface`` at lateral positions ``y``, m; those of a stretch are of that stretch alone."""
        part = part_of(surface, self.start, self.length, self.ramp)
        of_tread = self.on in WHEELS
        heights = _tread(self, part.steps, surface.dx, tuple(y)) if of_tread else self.field(part.steps, surface.dx, y)
        yield Patch(part.first, heights * part.share[:, None])


@lru_cache(maxsize=8)
def _tread(roughness: Roughness, steps: int, dx: float, y: tuple[float, ...]) -> Real:
    """Heights of a rough tread, as of ``Roughness.field``: kept, for mostly other irregularities on it change."""
    return roughness.field(steps, dx, np.array(y))


def read_spectrum(file: str) -> tuple[tuple[float, float], ...]:
    """Wavelengths, m, and levels, dB re 1 um, of a text file, a path or one that is shipped.

    The columns are called wavelength and level, or they are the only ones, in this order. Headings have the unit of the
    wavelengths. Raises InputError for anything else.
    """
    table = read_table(shipped.located("measured", file))
    wavelength, level = (table.find(name) for name in ("wavelength", "level"))
    if wavelength is None and level is None and len(table.columns) == 2:
        wavelength, level = table.columns
    if wavelength is None or level is None:
        raise InputError(f"{file} has {table.listed()}: name the columns wavelength [m] and level [dB]")
    size = table.size(wavelength, "length")
    table.size(level, "level", None if level.unit else "dB")
    rows = np.column_stack([size * wavelength.values, level.values])
    return tuple((float(f"{at:.12g}"), value) for at, value in rows.tolist())


def _covered(wavelength: Real, shortest: float, longest: float) -> float:
    """Share of the band that a spectrum covers, over the logarithm of the wavelength."""
    low, high = max(shortest, wavelength[0] / EDGE), min(longest, wavelength[-1] * EDGE)
    if shortest == longest:
        return float(low <= high)
    return float(max(0.0, np.log(high / low)) / np.log(longest / shortest)) if high > low else 0.0
