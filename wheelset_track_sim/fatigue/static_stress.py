"""Stress of static loads at the stress nodes: what a turning point of the axle has beside the measured bending.

A node shows the axial stress at its angle a_0 from the top in axes that do not turn::

    sigma_yy = m + b cos(a_0) + h sin(a_0)

m is the same all around: press fits, given stresses, the axial part of lateral forces. b is bending in the vertical
plane, of the contact forces and own weight, and follows from sigma_yy. h is bending in the horizontal plane by the
longitudinal forces of the rails, which the node does not show at the top; it follows from the torque. Torsion has no
axial stress.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, warn
from ..runtime.arrays import Real
from ..scenario import Scenario
from ..scenario.loads import Loads
from ..simulation.superposition import superposition
from ..wheelset.around import NEARLY_NONE, POLAR, angles_of
from ..wheelset.reduced import COMPONENTS, ReducedWheelset

AXIAL = COMPONENTS.index("yy")
"""Stress along the axle, which bends: its component."""


@dataclass(frozen=True, eq=False)
class StaticStress:
    """Axial stress of static loads at N stress nodes, Pa."""

    nodes: tuple[str, ...]
    mean: Real
    """(N,) m, which turns with the axle."""
    bending: Real
    """(N,) b of the static load of both wheels, without damage."""
    sideways: Real
    """(N,) h of a constant torque."""
    cosines: Real
    """(N,) cos(a_0)."""
    sines: Real
    """(N,) sin(a_0)."""

    @property
    def amplitude(self) -> Real:
        """Amplitude of rotating bending without damage, (N,): sqrt(b^2 + h^2)."""
        return np.hypot(self.bending, self.sideways)

    def bending_of(self, axial: Real) -> Real:
        """Bending b of axial stresses (n, N) at the nodes, (n, N)."""
        found: Real = (axial - self.mean - self.sideways * self.sines) / self.cosines
        return found


def static_stress(scenario: Scenario, reduced: ReducedWheelset, nodes: Sequence[str]) -> StaticStress:
    """Static stress at those of the nodes that show bending in the vertical plane; a warning names the others.

    Parameters
    ----------
    scenario
        With the loads of the whole run.
    reduced
        Its wheelset.
    nodes
        Names of stress nodes.

    Raises
    ------
    InputError
        If no node shows bending, or horizontal bending follows a torque that changes.
    """
    check_loads([scenario.loads])
    angles = angles_of(reduced.node_positions)
    shown = [name for name in nodes if abs(np.cos(angles[reduced.node(name)])) > NEARLY_NONE]
    hidden = ", ".join(name for name in nodes if name not in shown)
    if not shown:
        raise InputError(
            f"stress nodes {hidden or 'none'} do not show bending in the vertical plane: give output.stress_nodes at "
            "the top or bottom of the axle"
        )
    if hidden:
        warn(f"stress nodes {hidden} are at the side of the axle, where vertical bending is not seen: left out")
    rows = [reduced.node(name) for name in shown]
    at = angles[rows]
    cosines, sines = np.cos(at), np.sin(at)
    axial = reduced.static_stress()[rows, AXIAL] @ np.full(2, scenario.wheel_load)
    bending, mean, sideways = axial / cosines, np.zeros(len(rows)), np.zeros(len(rows))
    added = superposition(scenario.loads, scenario.wheelset, reduced, shown)
    if added is not None:
        yy = POLAR.index("yy")
        constant, torque = added.constant, added.torque.at(np.zeros(1))
        mean = constant.mean[:, yy]
        bending = bending + constant.cosine[:, yy]
        sideways = constant.sine[:, yy] + added.of_torque.sine[:, yy] * torque
    return StaticStress(tuple(shown), mean, bending, sideways, cosines, sines)


def check_loads(loads: Sequence[Loads]) -> None:
    """Raise InputError if horizontal bending changes between or within the loads of a run."""
    bent = [each for each in loads if each.horizontal_bending and each.with_torque]
    if bent and (any(each.torque_plan for each in bent) or any(each.torque != bent[0].torque for each in loads)):
        raise InputError(
            "loads.horizontal_bending follows a torque that changes during the run, and fatigue takes a constant one: "
            "give loads.torque instead of a plan or events, or set loads.horizontal_bending to false"
        )
