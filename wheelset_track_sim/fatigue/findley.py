"""Findley's criterion: how near the stress of a turning point, in all six components, is to the fatigue limit.

On the plane of a material point where it is largest, with the amplitude of shear and the largest normal stress::

    usage = (tau_a + k sigma_max) / f

The constants follow from the fatigue limits in fully reversed bending, S, and torsion, T, in which a usage of 1 is
reached at the limit::

    k / sqrt(1 + k^2) = 2 T / S - 1          f = T sqrt(1 + k^2)

For proportional bending and torsion of the amplitudes s and t, both fully reversed, the usage has the closed form::

    (sqrt(1 + k^2) sqrt(s^2 / 4 + t^2) + k s / 2) / f

The amplitude of shear is half the longest chord of the path that the shear stress takes on the plane.

Source: W.N. Findley, A theory for the effect of mean stress on fatigue of metals under combined torsion and axial load
or bending, J. Engineering for Industry 81 (1959) 301-306.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, quantity, read
from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..scenario import Scenario
from ..simulation.superposition import Superposition, superposition
from ..wheelset.around import POLAR, SHEAR, Around, angles_of
from ..wheelset.reduced import ReducedWheelset
from ..wheelset.stress_points import in_axes
from .curve import ASSUMED

COARSE, FINE = math.radians(10.0), math.radians(1.0)
"""Angles between planes that are searched, first all around, then around the best one."""
TURNS, STRIDE = 12, 2
"""Turns that are searched, of which every second step is."""
CHORDS = 9
"""Directions of shear on a plane, over half a turn, in the first search; four times as many in the second."""


@dataclass(frozen=True)
class Findley:
    """Fatigue limits of a material in bending and torsion, with their source. SI units.

    Examples
    --------
    >>> criterion = load_findley("assumed_findley")
    >>> f"k = {criterion.k:.3f}, f = {criterion.f / 1e6:.1f} MPa"
    'k = 0.157, f = 116.9 MPa'
    """

    name: str
    source: str
    """Where the limits come from; begins with ``assumed`` if they are an assumption."""
    bending_limit: float = quantity("Pa", 1e6, 2e9, "the fatigue limit in fully reversed bending", usual=(1e7, 2e9))
    torsion_limit: float = quantity("Pa", 1e6, 2e9, "the fatigue limit in fully reversed torsion", usual=(1e7, 2e9))

    def __post_init__(self) -> None:
        check(self)
        if not self.source.strip():
            raise InputError("source is empty: say where the limits come from, or write 'assumed' and why")
        if not 0.5 <= self.torsion_limit / self.bending_limit < 1.0:
            raise InputError(
                f"torsion_limit = {self.torsion_limit:g} Pa is not between half of bending_limit and all of it: "
                "Findley's criterion is for ductile metals, give 0.5 to 1 of it"
            )

    @property
    def assumed(self) -> bool:
        """Whether the limits are an assumption by their own source."""
        return self.source.lower().startswith(ASSUMED)

    @property
    def note(self) -> str:
        """Constants with their source, as people read them beside numbers that depend on them."""
        return f"criterion of Findley {self.name}: k = {self.k:.3g}, f = {self.f / 1e6:.4g} MPa; source: {self.source}"

    @property
    def k(self) -> float:
        """Influence of the normal stress."""
        share = 2 * self.torsion_limit / self.bending_limit - 1
        return share / math.sqrt(1 - share**2)

    @property
    def f(self) -> float:
        """Limit of tau_a + k sigma_max, Pa."""
        return self.torsion_limit * math.sqrt(1 + self.k**2)

    def usage(self, stress: Real) -> float:
        """Share of the fatigue limit that a point reaches.

        Parameters
        ----------
        stress
            (6, n) Pa in the order of ``wheelset.around.POLAR``, over whole turns.
        """
        best = _planes()[int(np.argmax(self.coarse(stress)))]
        return float(self._values(stress, *_rows(_near(best), 4 * CHORDS)).max()) / self.f

    def coarse(self, stress: Real) -> Real:
        """tau_a + k sigma_max on planes 10 degrees apart, (planes,), Pa: up to 2 % less than the largest of all."""
        return self._values(stress, *_coarse())

    def _values(self, stress: Real, normal: Real, shear: Real) -> Real:
        """tau_a + k sigma_max on planes, (planes,), Pa."""
        longest = np.zeros(len(normal))
        for rows in shear:
            longest = np.maximum(longest, np.ptp(rows @ stress, axis=1))
        found: Real = longest / 2 + self.k * (normal @ stress).max(axis=1)
        return found


@dataclass(frozen=True)
class NodeUsage:
    """Largest share of the fatigue limit around a stress node."""

    name: str
    usage: float
    angle: float
    """Of the point from the top when angle 0 of the treads meets the rail, rad."""


@cache
def _planes() -> Real:
    """Normals (planes, 3) over half a sphere in r, y, t."""
    rings = []
    for polar in np.arange(0.0, np.pi / 2 + 1e-9, COARSE):
        count = max(1, math.ceil(2 * np.pi * math.sin(polar) / COARSE))
        azimuth = 2 * np.pi * np.arange(count) / count
        along = np.full(count, math.cos(polar))
        rings.append(np.stack([along, math.sin(polar) * np.cos(azimuth), math.sin(polar) * np.sin(azimuth)], axis=1))
    return np.concatenate(rings)


@cache
def _coarse() -> tuple[Real, Real]:
    """Rows of all planes."""
    return _rows(_planes(), CHORDS)


def _near(normal: Real) -> Real:
    """Normals around one, (planes, 3)."""
    first, second = _tangents(normal[np.newaxis])
    offsets = np.arange(-COARSE / 2, COARSE / 2 + FINE / 2, FINE)
    one, other = (each.reshape(-1, 1) for each in np.meshgrid(np.tan(offsets), np.tan(offsets)))
    found = normal + one * first + other * second
    normals: Real = found / np.linalg.norm(found, axis=1, keepdims=True)
    return normals


def _tangents(normals: Real) -> tuple[Real, Real]:
    """Two directions on each plane, (planes, 3)."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)


def _rows(normals: Real, chords: int) -> tuple[Real, Real]:
    """Rows that make of a stress the normal stress on each plane, (planes, 6), and its shear in a number of directions.

    The latter are (chords, planes, 6), over half a turn.
    """
    first, second = _tangents(normals)
    turned = np.pi * np.arange(chords)[:, np.newaxis, np.newaxis] / chords
    shear = np.cos(turned) * _of_tensor(normals, first) + np.sin(turned) * _of_tensor(normals, second)
    return _of_tensor(normals, normals), shear


def _of_tensor(one: Real, other: Real) -> Real:
    """Rows (planes, 6) for one . sigma . other."""
    axes = ["ryt".index(name[0]) for name in POLAR], ["ryt".index(name[1]) for name in POLAR]
    product = one[:, axes[0]] * other[:, axes[1]] + one[:, axes[1]] * other[:, axes[0]]
    found: Real = np.where(np.array(axes[0]) == np.array(axes[1]), product / 2, product)
    return found


def turning_stress(shown: Real, angle: float, added: Around, around: Real) -> Real:
    """All six components at points that turn, from those of a stress node.

    What the contact forces add to the node is bending in the vertical plane, so its shear on the sides is taken as
    none: the node does not show it. What is superposed is known around the axle.

    Parameters
    ----------
    shown
        (n, 6) Pa: xx, yy, zz, xy, xz, yz at the node.
    angle
        Of the node from the top, rad.
    added
        What is superposed at this node, one place, Pa.
    around
        (K, n) angle of each point from the top, rad.

    Returns
    -------
    Real
        (K, 6, n) Pa in the order of ``wheelset.around.POLAR``.
    """
    superposed = added.at(np.array([angle]))[0]
    polar = np.linalg.solve(in_axes(angle, 1.0, 1.0), (shown - superposed).T)
    bending = np.where(SHEAR[:, np.newaxis], 0.0, polar / math.cos(angle))
    mean, cosine, sine = (each[0][:, np.newaxis] for each in (added.mean, added.cosine, added.sine))
    found = np.empty((len(around), 6, around.shape[1]))
    for point, a in enumerate(around):
        found[point] = mean + (cosine + bending) * np.cos(a) + sine * np.sin(a)
    return found


def node_usages(
    criterion: Findley,
    scenario: Scenario,
    reduced: ReducedWheelset,
    blocks: Iterable[SampleBlock],
    nodes: Sequence[str],
    points: int = 36,
) -> tuple[NodeUsage, ...]:
    """Largest share of the fatigue limit around each stress node, over the first ``TURNS`` turns or all if less.

    Parameters
    ----------
    criterion
        Limits of the material.
    scenario
        What is simulated; its torque is constant.
    reduced
        Its wheelset.
    blocks
        Gap-free at full rate; only as many as needed are taken.
    nodes
        Names of stress nodes near the top or bottom of the axle.
    points
        Around the axle.

    Raises
    ------
    InputError
        If the torque changes, or there is less than a turn.
    """
    if scenario.loads.torque_plan or any(event.torque is not None for event in scenario.events):
        raise InputError(
            "the torque changes during the run, and the criterion takes a constant one: give loads.torque instead of a "
            "plan or events"
        )
    turn, parts, steps = scenario.steps_per_revolution, [], 0
    for block in blocks:
        parts.append(block)
        steps += len(block)
        if steps >= TURNS * turn:
            break
    turns = min(TURNS, steps // turn)
    if not turns:
        raise InputError(f"{steps} steps are less than one turn of {turn}: give more")
    start = parts[0].first_step + np.arange(0, turns * turn, STRIDE)
    turned = 2 * np.pi * (start - scenario.tread_origin) / turn
    around = 2 * np.pi * np.arange(points) / points
    added = superposition(scenario.loads, scenario.wheelset, reduced, nodes)
    angles = angles_of(reduced.node_positions)
    found = []
    for place, name in enumerate(nodes):
        column = parts[0].nodes.index(name)
        shown = np.concatenate([part.stresses[:, column] for part in parts])[: turns * turn : STRIDE]
        here = Around.none(1) if added is None else _constant(added, place)
        turning = turning_stress(shown, float(angles[reduced.node(name)]), here, turned + around[:, np.newaxis])
        stress = [_extremes(point) for point in turning]
        worst = int(np.argmax([criterion.coarse(point).max() for point in stress]))
        found.append(NodeUsage(name, criterion.usage(stress[worst]), float(around[worst])))
    return tuple(found)


def _extremes(stress: Real) -> Real:
    """Samples of a path (6, n) at which the normal stress on a plane is largest or smallest: its corners."""
    normal = _coarse()[0] @ stress
    found: Real = stress[:, np.unique(np.concatenate([normal.argmax(axis=1), normal.argmin(axis=1)]))]
    return found


def _constant(added: Superposition, place: int) -> Around:
    """What a constant torque and all else superposes at one place, Pa."""
    constant, unit = added.constant.chosen([place]), added.of_torque.chosen([place])
    torque = float(added.torque.at(np.zeros(1))[0])
    return constant + Around(torque * unit.mean, torque * unit.cosine, torque * unit.sine)


def load_findley(source: str | Path) -> Findley:
    """Load Findley's criterion.

    Parameters
    ----------
    source
        Name of a shipped file (``assumed_findley``), or path of a YAML file.

    Returns
    -------
    Findley
        Fatigue limits with their source.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used, or without a source.
    """
    return read(Findley, shipped.load_yaml("criteria", source), "")
