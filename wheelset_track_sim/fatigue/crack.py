"""A crack in a turning axle: stress intensity, growth over distance, what is left until fracture.

A semi-elliptical crack of depth a, with its other semi-axis b along the surface of a solid shaft of diameter D, has at
its deepest point, under bending whose stress at the surface is S::

    K = F(a/D, a/b) S sqrt(pi a)

F is tabulated by Shin and Cai for a/D from 0.067 on. A shallow crack is one in a half-space, for which Newman and Raju
have::

    F(0, a/b) = (1.13 - 0.09 a/b) / sqrt(1 + 1.464 (a/b)^1.65)

Between, F is interpolated by monotone cubics. As the axle turns, the deepest point sees bending by its component across
the crack; bending along the crack is antisymmetric and has no K there. So K follows the rotating stress of the point
of the surface where the crack is.

Sources: C.S. Shin, C.Q. Cai, Experimental and finite element analyses on stress intensity factors of an elliptical
surface crack in a circular shaft under tension and bending, Int. J. Fracture 129 (2004) 239-264, values as tabulated in
easigrow (github.com/Easigrow/easigrow, src/beta.rs); J.C. Newman, I.S. Raju, An empirical stress-intensity factor
equation for the surface crack, Eng. Fracture Mechanics 15 (1981) 185-192.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..runtime.arrays import Real
from .growth import CrackGrowth
from .rainflow import StressSpectrum

DEPTHS = np.array([0.0, 0.067, 0.133, 0.2, 0.267, 0.333, 0.4, 0.467, 0.533, 0.6, 0.667, 0.733, 0.8])
"""a/D."""
ASPECTS = np.linspace(0.0, 1.0, 11)
"""a/b."""
DEEPEST = np.array(
    [
        [0.963, 0.954, 0.929, 0.878, 0.834, 0.786, 0.739, 0.692, 0.649, 0.609, 0.576],
        [0.897, 0.890, 0.870, 0.840, 0.801, 0.757, 0.710, 0.662, 0.618, 0.576, 0.537],
        [0.872, 0.866, 0.848, 0.820, 0.783, 0.739, 0.690, 0.640, 0.592, 0.547, 0.506],
        [0.879, 0.873, 0.856, 0.828, 0.790, 0.743, 0.692, 0.637, 0.583, 0.532, 0.486],
        [0.917, 0.911, 0.893, 0.863, 0.823, 0.773, 0.716, 0.654, 0.592, 0.532, 0.478],
        [0.991, 0.984, 0.964, 0.932, 0.888, 0.832, 0.767, 0.695, 0.621, 0.549, 0.482],
        [1.112, 1.104, 1.082, 1.045, 0.994, 0.930, 0.854, 0.768, 0.678, 0.588, 0.504],
        [1.302, 1.294, 1.268, 1.224, 1.164, 1.087, 0.995, 0.889, 0.775, 0.659, 0.550],
        [1.609, 1.599, 1.566, 1.512, 1.437, 1.341, 1.224, 1.088, 0.938, 0.783, 0.634],
        [2.126, 2.113, 2.070, 1.998, 1.899, 1.771, 1.614, 1.429, 1.222, 1.002, 0.787],
        [3.082, 3.063, 3.002, 2.899, 2.755, 2.570, 2.342, 2.069, 1.758, 1.421, 1.083],
        [5.140, 5.110, 5.011, 4.841, 4.606, 4.302, 3.923, 3.466, 2.934, 2.344, 1.737],
    ]
)
"""F at the deepest point, (depths but the first, aspects): bending, Shin and Cai (2004)."""
DEEPEST_CRACK = 0.5
"""a/D at which growth ends if no fracture comes before."""
STEPS = 400
"""Depths of an integration, even in their logarithm."""


@dataclass(frozen=True, eq=False)
class CrackSpectrum:
    """Cycles of axial stress at a point of an axle over a distance: n kinds, each (n,)."""

    span: Real
    """Range, Pa."""
    mean: Real
    """Pa."""
    per_metre: Real
    """Cycles a metre, 1/m."""

    @classmethod
    def of(cls, spectrum: StressSpectrum, channel: int, distance: float) -> CrackSpectrum:
        """Cycles of a channel that were counted over a distance, m."""
        span, mean, number = spectrum.cells(channel)
        return cls(span, mean, number / distance)


@dataclass(frozen=True, eq=False)
class CrackLife:
    """Depth of a crack over distance until it is critical."""

    depth: Real
    """(STEPS,) m, the last one critical."""
    distance: Real
    """(STEPS,) m to reach it; infinite where nothing grows."""
    fractures: bool
    """Whether the stress intensity reaches the toughness at the last depth; else it is ``DEEPEST_CRACK`` deep."""

    @property
    def left(self) -> float:
        """Distance until the crack is critical, m."""
        return float(self.distance[-1])


def geometry_factor(depth_ratio: Real, aspect: float) -> Real:
    """F at the deepest point of a semi-elliptical crack in a solid shaft in bending.

    Parameters
    ----------
    depth_ratio
        a/D, (n,), 0 to 0.8.
    aspect
        a/b, 0 (straight front) to 1.
    """
    from scipy.interpolate import PchipInterpolator

    shallow = (1.13 - 0.09 * ASPECTS) / np.sqrt(1.0 + 1.464 * ASPECTS**1.65)
    of_aspect = PchipInterpolator(ASPECTS, np.vstack([shallow, DEEPEST]), axis=1)(aspect)
    found: Real = PchipInterpolator(DEPTHS, of_aspect)(depth_ratio)
    return found


def growth_per_metre(spectrum: CrackSpectrum, growth: CrackGrowth, depth: Real, diameter: float) -> Real:
    """Growth over distance, m/m, of cracks of depths (m,), m, in a shaft of a diameter, m.

    The cycles are those of the spectrum, in no order: a large one does not slow the growth after it.
    """
    unit = geometry_factor(depth / diameter, growth.aspect) * np.sqrt(np.pi * depth)
    mean = spectrum.mean + growth.residual_stress
    high, low = mean + spectrum.span / 2, mean - spectrum.span / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(high > 0.0, low / high, 0.0)
    found: Real = growth.rate_of(np.outer(unit, high), ratio, depth[:, np.newaxis]) @ spectrum.per_metre
    return found


def fastest(spectra: Sequence[CrackSpectrum], growth: CrackGrowth, depth: float, diameter: float) -> int:
    """Number of the spectrum, of those at places around an axle, under which a crack grows fastest.

    A crack opens in tension, so this is not the place with most damage: an impact that finds a point at the bottom of
    the axle has the same range as one half a turn later, and the opposite mean.
    """
    rates = [growth_per_metre(each, growth, np.array([depth]), diameter)[0] for each in spectra]
    return int(np.argmax(rates))


def crack_life(spectrum: CrackSpectrum, growth: CrackGrowth, depth: float, diameter: float) -> CrackLife:
    """Grow a crack until the stress intensity reaches the toughness, or the crack is half as deep as the shaft.

    Examples
    --------
    >>> constant = CrackSpectrum(span=np.array([160e6]), mean=np.array([0.0]), per_metre=np.array([1 / 2.713]))
    >>> life = crack_life(constant, load_crack_growth("assumed_steel").at("fast"), depth=0.002, diameter=0.18)
    >>> print(f"{life.left / 1e3:.0f} km, then {1e3 * life.depth[-1]:.0f} mm deep")
    2508 km, then 90 mm deep

    Parameters
    ----------
    spectrum
        Cycles at the place of the crack; repeated over the distance.
    growth
        Law, constants and shape; scatter is left out: see ``CrackGrowth.at``.
    depth
        At the beginning, m.
    diameter
        Of the solid shaft, m.

    Raises
    ------
    InputError
        For a depth that is not between 0 and half the diameter, or is critical already.
    """
    deepest = DEEPEST_CRACK * diameter
    if not 0.0 < depth < deepest:
        raise InputError(f"depth = {depth:g} m is out of range: give more than 0 m, up to {deepest:g} m")
    depths = np.geomspace(depth, deepest, STEPS)
    high = float((spectrum.mean + growth.residual_stress + spectrum.span / 2).max(initial=0.0))
    intensity = geometry_factor(depths / diameter, growth.aspect) * np.sqrt(np.pi * depths) * high
    critical = np.flatnonzero(intensity >= growth.toughness)
    if len(critical) and critical[0] == 0:
        raise InputError(
            f"depth = {depth:g} m is critical already: {intensity[0] / 1e6:.3g} MPa sqrt(m) is not below the toughness"
        )
    if len(critical):
        place = critical[0]
        end = float(np.interp(growth.toughness, intensity[place - 1 : place + 1], depths[place - 1 : place + 1]))
        depths = np.geomspace(depth, end, STEPS)
    # The integral of da / (da/ds) in the logarithm of a, in which a power law is smooth; at the end K may be critical.
    with np.errstate(divide="ignore"):
        middle = np.sqrt(depths[1:] * depths[:-1])
        pieces = np.diff(np.log(depths)) * middle / growth_per_metre(spectrum, growth, middle, diameter)
    return CrackLife(depths, np.concatenate([[0.0], np.cumsum(pieces)]), bool(len(critical)))
