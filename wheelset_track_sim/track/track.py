"""The ballasted track as people give it: two rails on sleepers at equal spacing (Section 4 and Table 1 of the paper).

The track is symmetric about its centre, so two rails loaded by ``F1`` and ``F2`` are two independent half tracks with
one rail each: the symmetric half carries ``F_s = (F1 + F2) / 2``, the antisymmetric half ``F_a = (F1 - F2) / 2``, and
``xi_1 = xi_s + xi_a``, ``xi_2 = xi_s - xi_a``. With the receptances ``H_s`` and ``H_a`` of the halves the direct
receptance is ``(H_s + H_a) / 2`` and the cross receptance ``(H_s - H_a) / 2``.

What the paper leaves open, and what is chosen here:

* sleeper length: 2.5 m (it decides the cross receptance);
* ballast: shared among the sleeper's nodes by their tributary length;
* rotational pad springs, Eqs. (20) and (21), act about y. The sleeper bends in the y-z plane and does not turn about y,
  so their lower end is grounded;
* loads and responses are the vertical ones of the rail's axis, both positive downwards (away from the wheel).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, plain, quantity, read, unknown
from .supports import SupportLine, along

SLOWEST = 5.0
"""Lowest speed of a scenario, m/s."""
Half = Literal["symmetric", "antisymmetric"]
HALVES: tuple[Half, Half] = ("symmetric", "antisymmetric")


@dataclass(frozen=True)
class Beam:
    """Uniform Rayleigh-Timoshenko beam: one column of Table 1."""

    youngs_modulus: float = quantity("Pa", 1e8, 1e12, "Young's modulus")
    poissons_ratio: float = quantity("", 0.0, 0.49, "Poisson's ratio")
    density: float = quantity("kg/m3", 100.0, 3e4, "the density")
    shear_factor: float = quantity("", 0.05, 1.0, "the shear factor")
    area: float = quantity("m2", 1e-4, 1.0, "the cross-sectional area")
    moment_of_inertia: float = quantity("m4", 1e-8, 1e-1, "the moment of inertia of the cross-section")

    def __post_init__(self) -> None:
        check(self)

    @property
    def EI(self) -> float:
        """Bending stiffness, N m2."""
        return self.youngs_modulus * self.moment_of_inertia

    @property
    def kGA(self) -> float:
        """Shear stiffness with the shear factor, N."""
        return self.shear_factor * self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio)) * self.area

    @property
    def rhoA(self) -> float:
        """Mass a length, kg/m."""
        return self.density * self.area

    @property
    def rhoI(self) -> float:
        """Rotational inertia a length, kg m."""
        return self.density * self.moment_of_inertia


@dataclass(frozen=True)
class Rail(Beam):
    """Rail, with its division into finite elements."""

    elements_per_bay: int = quantity("", 2, 64, "the number of rail elements a sleeper bay", default=8)


@dataclass(frozen=True)
class Sleeper(Beam):
    """Sleeper, with its division into finite elements (an even number: half of them belong to each half track)."""

    length: float = quantity("m", 0.5, 10.0, "the sleeper length", default=2.5)
    elements: int = quantity("", 2, 200, "the number of sleeper elements", default=20)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.elements % 2:
            raise InputError(f"elements = {self.elements} of the sleeper is odd: give an even number")


@dataclass(frozen=True)
class Pad:
    """Rail pad of one rail on one sleeper: spring and dashpot in parallel, vertical and rotational."""

    stiffness: float = quantity("N/m", 1e6, 1e11, "the vertical pad stiffness")
    damping: float = quantity("N s/m", 1.0, 1e7, "the vertical pad damping")
    length: float = quantity("m", 0.0, 1.0, "the pad length along the rail", default=0.15)

    def __post_init__(self) -> None:
        check(self)

    @property
    def rotational_stiffness(self) -> float:
        """Stiffness about y, N m/rad: Eq. (20)."""
        return self.stiffness * self.length**2 / 12.0

    @property
    def rotational_damping(self) -> float:
        """Damping about y, N m s/rad: Eq. (21)."""
        return self.damping * self.length**2 / 12.0


@dataclass(frozen=True)
class Ballast:
    """Ballast and subgrade under one whole sleeper: springs and dashpots to the ground."""

    stiffness: float = quantity("N/m", 1e6, 1e11, "the ballast stiffness of a sleeper")
    damping: float = quantity("N s/m", 1.0, 1e7, "the ballast damping of a sleeper")

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Track:
    """Tangent track of two equal rails on supports at equal spacing, which stand at whole multiples of it."""

    name: str
    rail: Rail
    pad: Pad
    sleeper: Sleeper | None = None
    """Left out together with ``ballast`` on slab track: pads stand on the ground then."""
    ballast: Ballast | None = None
    spacing: float = quantity("m", 0.2, 3.0, "the sleeper spacing", default=0.6)
    rail_distance: float = quantity("m", 0.3, 3.0, "the distance between the rails", default=1.5)
    line: SupportLine | None = None
    """Supports that differ along the line; None if they are all the same."""

    def __post_init__(self) -> None:
        check(self)
        if (self.sleeper is None) != (self.ballast is None):
            missing = "sleeper" if self.sleeper is None else "ballast"
            raise InputError(f"{missing} is missing: give both sleeper and ballast, or neither of them for slab track")
        if self.sleeper is not None and self.rail_distance >= self.sleeper.length:
            raise InputError(
                f"rail_distance = {self.rail_distance:g} m is not below the sleeper length of "
                f"{self.sleeper.length:g} m: give a longer sleeper or a smaller rail distance"
            )
        if self.line is not None and self.sleeper is None:
            self._refuse_ballast(self.line)

    def check_step(self, dx: float) -> None:
        """Raise InputError for hanging sleepers that steps of ``dx``, m, cannot follow at the lowest speed."""
        if self.line is None or self.sleeper is None or self.ballast is None:
            return
        multiples = along(self.line)
        hanging = multiples.ballast_damping[~np.isnan(multiples.gap)] * self.ballast.damping
        mass = self.sleeper.rhoA * self.sleeper.length
        if hanging.size and hanging.max() * dx / SLOWEST > mass:
            raise InputError(
                f"the ballast damping of hanging sleepers, {hanging.max():g} N s/m, is too high for steps of {dx:g} m: "
                f"give up to {mass * SLOWEST / dx:.3g} N s/m"
            )

    def _refuse_ballast(self, line: SupportLine) -> None:
        """Raise InputError for what a line of slab track says about ballast."""
        for index, entry in enumerate(line.supports):
            if entry.gap is not None or entry.ballast_stiffness != 1.0 or entry.ballast_damping != 1.0:
                raise InputError(f"line.supports.{index} changes the ballast, and slab track has none: leave it out")
        if line.scatter.ballast_stiffness or line.scatter.ballast_damping:
            raise InputError("line.scatter changes the ballast, and slab track has none: leave it out")


def load_track(source: str | Path | Mapping[str, Any]) -> Track:
    """Load a track.

    Parameters
    ----------
    source
        Name of a shipped track (``ballasted_60e1``, ``ballasted_54e1``, ``slab_60e1``), path of a YAML file, or a
        mapping with the keys of such a file. With ``base`` it takes what it does not say itself from the track of that
        name or path.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.

    Examples
    --------
    >>> softer = load_track({"base": "ballasted_60e1", "name": "softer", "pad": {"stiffness": 9e7}})
    >>> softer.pad.stiffness, softer.spacing
    (90000000.0, 0.6)
    """
    if not isinstance(source, Mapping) and str(source) in shipped.names("tracks"):
        return _shipped(str(source))
    return read(
        Track, _with_base(source if isinstance(source, Mapping) else shipped.load_yaml("tracks", source)), "track"
    )


def read_track(data: Any, where: str) -> Track:
    """Track from the name of a shipped one or from a mapping; ``where`` is the key that messages begin with.

    Raises InputError.
    """
    if isinstance(data, Track):
        return data
    if isinstance(data, str):
        if data not in shipped.names("tracks"):
            raise InputError(unknown("track", f"{where} = {data!r}", data, shipped.names("tracks")))
        return _shipped(data)
    return read(Track, _with_base(data), where)


def plain_track(track: Track) -> Any:
    """Name of a shipped track, or a mapping of all that a track is; ``read_track`` reads both."""
    if track.name in shipped.names("tracks") and track == _shipped(track.name):
        return track.name
    return plain(track)


@cache
def _shipped(name: str) -> Track:
    return read(Track, _with_base(shipped.load_yaml("tracks", name)), "track")


def _with_base(data: Any, depth: int = 0) -> Any:
    """Mapping of a track with what its base says filled in, entry by entry of ``rail``, ``pad`` and the like."""
    if not isinstance(data, Mapping) or "base" not in data:
        return data
    named = data["base"]
    if not isinstance(named, (str, Mapping)) or depth > shipped.MAX_DEPTH:
        raise InputError(f"track.base = {named!r} is not a track: give the name of a shipped one, or a file")
    base = _with_base(named if isinstance(named, Mapping) else shipped.load_yaml("tracks", named), depth + 1)
    merged = dict(base) if isinstance(base, Mapping) else {}
    for key, value in data.items():
        inner = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping) and key != "line"
        merged[key] = {**merged[key], **value} if inner else value
    return {key: value for key, value in merged.items() if key != "base"}
