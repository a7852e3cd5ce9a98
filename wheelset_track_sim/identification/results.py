"""What identification finds: kinds with probabilities, sizes with intervals, and draws to predict from."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import InputError
from ..irregularities import Irregularity
from ..runtime.arrays import Real
from ..scenario import Scenario
from ..scenario.scenario import Wheel
from .kinds import KINDS, NONE, DamageKind
from .observation import Observation

EXPLAINS = 1.3
"""Largest sum of squares by sample of a fit that explains the data."""
LEAST = 0.05
"""Probability from which on a kind counts."""
LEVEL = 0.90
"""Of all intervals."""
TELLING = 0.6
"""Share of the standard deviation before the measurement that may be left of a size that the data tell."""


def explains(chi2_per_n: float) -> bool:
    """Whether a fit explains the data."""
    return bool(chi2_per_n <= EXPLAINS)


@dataclass(frozen=True)
class Interval:
    """An estimate, the median, with the ends of its 90 % interval."""

    estimate: float
    low: float
    high: float
    told: bool = True
    """Whether the data tell it; otherwise the interval is hardly narrower than what was assumed before."""

    @classmethod
    def of(cls, draws: Real, told: bool = True) -> Interval:
        """Of equally likely draws (n,)."""
        low, middle, high = np.quantile(draws, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2])
        return cls(float(middle), float(low), float(high), told)


@dataclass(frozen=True, eq=False)
class Band:
    """An observation with what a fit makes of it."""

    observation: Observation
    time: Real
    """(n,) since the peak, s."""
    measured: Real
    """(n,)"""
    fitted: Real
    """(n,)"""
    spread: Real
    """(n,) standard deviation of the fit with all that is uncertain, noise included."""


@dataclass(frozen=True, eq=False)
class KindFit:
    """What the data say about one kind."""

    kind: str
    meaning: str
    probability: float
    """Among the kinds that were looked at, all equally likely before."""
    chi2_per_n: float
    """Sum of squared residuals by sample; about 1 for a fit that explains the data."""
    explains: bool
    parameters: Mapping[str, Interval]
    """Sizes, and places of each observation: ``place_m``, ``lateral_m``; SI units."""
    correlations: Mapping[tuple[str, str], float]
    """Of each pair of sizes, -1 to 1."""
    draws: Real
    """(n, sizes) equally likely sizes; empty if the kind has none, or was not looked at more closely."""
    laterals: Real
    """(n, observations) lateral places of the same draws, m; zeros for a kind without."""
    bands: tuple[Band, ...] = ()

    def of_probability(self, probability: float) -> KindFit:
        """The same with another probability."""
        return dataclasses.replace(self, probability=probability)

    @cached_property
    def central(self) -> int:
        """Number of the draw nearest to the middle of all, in the directions and sizes of their spread."""
        z = np.log(self.draws)
        if z.size == 0:
            return 0
        away = z - np.median(z, axis=0)
        covariance = away.T @ away / len(away) + 1e-12 * np.eye(z.shape[1])
        return int(np.einsum("ni,ij,nj->n", away, np.linalg.inv(covariance), away).argmin())

    def damage(self, wheel: Wheel, draw: int, observation: int = 0, angle: float = 0.0) -> tuple[Irregularity, ...]:
        """Irregularities of a draw, in the lateral place of an observation."""
        if self.kind == NONE:
            return ()
        return (KINDS[self.kind].make(wheel, self.draws[draw].tolist(), angle, self.laterals[draw, observation]),)


@dataclass(frozen=True, eq=False)
class Identification:
    """What explains the data, the likeliest kind first."""

    scenario: Scenario
    """On which it was looked for, without damage."""
    wheel: Wheel
    kinds: tuple[KindFit, ...]
    sources: tuple[str, ...]
    """Names of the observations."""
    speeds: tuple[float, ...]
    """Of the observations, m/s."""
    axle_loads: tuple[float, ...]
    """Of the observations, N."""
    simulated: int
    """Passages that were simulated."""

    @property
    def best(self) -> KindFit:
        """The likeliest kind."""
        return self.kinds[0]

    @property
    def explaining(self) -> tuple[KindFit, ...]:
        """Kinds that explain the data and are not ruled out by a likelier one.

        Raises InputError if the likeliest kind does not explain the data.
        """
        self.fit()
        return tuple(each for each in self.kinds if each.explains and each.probability >= LEAST)

    def fit(self, kind: str | None = None) -> KindFit:
        """Fit of a kind, or of the likeliest one; raises InputError if it does not explain the data."""
        found = self.best if kind is None else next((each for each in self.kinds if each.kind == kind), None)
        if found is None:
            raise InputError(f"kind = {kind!r} was not looked for: give one of {[each.kind for each in self.kinds]}")
        if not found.explains:
            raise InputError(
                f"{found.kind} does not explain the data: chi2/n = {found.chi2_per_n:.2f} is above {EXPLAINS:g}: give "
                "the right speed, load and noise, other kinds, or data of one defect"
            )
        return found

    def damaged(self, kind: str | None = None) -> Scenario:
        """The scenario of the first observation with the central estimate on its wheel; errors as of ``fit``."""
        fit = self.fit(kind)
        own = self.scenario.irregularities
        return dataclasses.replace(
            self.scenario,
            name="identified",
            speed=self.speeds[0],
            axle_load=self.axle_loads[0],
            irregularities=(*own, *fit.damage(self.wheel, fit.central)),
        )


def correlations(kind: DamageKind | None, z: Real) -> dict[tuple[str, str], float]:
    """Of each pair of sizes, from draws z (n, sizes)."""
    if kind is None or len(kind.unknowns) < 2:
        return {}
    matrix = np.atleast_2d(np.corrcoef(z.T))
    names = [each.name for each in kind.unknowns]
    return {(names[i], names[j]): float(matrix[i, j]) for i in range(len(names)) for j in range(i + 1, len(names))}
