"""S-N curves: how many cycles of an amplitude a material or a component endures, with the source of its constants."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.amounts import in_unit
from ..inputs.schema import check, quantity, read
from ..runtime.arrays import Real

ASSUMED = "assumed"
"""First word of a source that is an assumption."""


@dataclass(frozen=True)
class Curve:
    """Amplitude over cycles at mean stress 0: N = knee_cycles (limit / amplitude)^slope. SI units.

    Examples
    --------
    >>> curve = load_curve("assumed_body")
    >>> f"{curve.limit / 1e6:g} MPa, {curve.knee_cycles:g} cycles, slope {curve.slope:g}"
    '200 MPa, 1e+06 cycles, slope 5'
    """

    name: str
    source: str
    """Where the constants come from; begins with ``assumed`` if they are an assumption."""
    fatigue_limit: float = quantity("Pa", 1e6, 2e9, "the amplitude at the knee", usual=(1e7, 2e9))
    knee_cycles: float = quantity("", 1e3, 1e10, "the number of cycles at the knee")
    slope: float = quantity("", 1.0, 100.0, "the slope k above the knee")
    survival_probability: float = quantity("", 1e-6, 1.0 - 1e-12, "the survival probability of the curve")
    second_slope: float | None = quantity("", 1.0, 1000.0, "the slope below the knee", default=None)
    """Without one, only the rules of Miner say what happens below the knee."""
    amplitude_scatter: float | None = quantity(
        "", 1.0 + 1e-6, 10.0, "the ratio of the amplitudes that 10 % and 90 % survive", default=None
    )
    """See ``scatter``; without it, there is no band over scatter and no failure probability."""
    mean_stress: Literal["none", "fkm"] = "none"
    """``none`` ignores the mean; ``fkm`` uses ``mean_stress_sensitivity`` as ``equivalent_amplitude`` says."""
    mean_stress_sensitivity: float = quantity("", 0.0, 1.0, "the mean stress sensitivity M", default=0.0)
    size_factor: float = quantity("", 0.1, 2.0, "the size factor", default=1.0)
    surface_factor: float = quantity("", 0.1, 2.0, "the surface factor", default=1.0)

    def __post_init__(self) -> None:
        check(self)
        if not self.source.strip():
            raise InputError("source is empty: say where the constants come from, or write 'assumed' and why")
        if (self.mean_stress == "fkm") != (self.mean_stress_sensitivity > 0):
            raise InputError(
                f"mean_stress = {self.mean_stress} with mean_stress_sensitivity = {self.mean_stress_sensitivity:g}: "
                "give fkm with a sensitivity above 0, or none without one"
            )

    @property
    def assumed(self) -> bool:
        """Whether the constants are an assumption by their own source."""
        return self.source.lower().startswith(ASSUMED)

    @property
    def note(self) -> str:
        """Constants with their source, as people read them beside numbers that depend on them."""
        return (
            f"S-N curve {self.name}: {in_unit(self.limit, 'MPa', 'Pa')} at {self.knee_cycles:g} cycles, slope "
            f"{self.slope:g}, survival {self.survival_probability:g}, mean stress {self.mean_stress}; "
            f"source: {self.source}"
        )

    @property
    def limit(self) -> float:
        """Amplitude at the knee with the factors of size and surface, Pa."""
        return self.fatigue_limit * self.size_factor * self.surface_factor

    @property
    def rules(self) -> tuple[str, ...]:
        """Names of the rules below the knee: three of Miner, and that of the curve if it has a second slope."""
        return ("elementary", "haibach", "original", *(("curve",) if self.second_slope else ()))

    @cached_property
    def constants(self) -> Real:
        """Of each rule limit, Pa, knee, the slope above the limit and that below it: (rules, 4)."""
        below = (self.slope, 2 * self.slope - 1, math.inf, *((self.second_slope,) if self.second_slope else ()))
        return np.array([[self.limit, self.knee_cycles, self.slope, slope] for slope in below])


def load_curve(source: str | Path) -> Curve:
    """Load an S-N curve.

    Parameters
    ----------
    source
        Name of a shipped curve (``assumed_body``, ``assumed_body_mean_stress``), or path of a YAML file.

    Returns
    -------
    Curve
        Constants, source and survival probability of the curve.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.
    """
    return read(Curve, shipped.load_yaml("woehler", source), "")
