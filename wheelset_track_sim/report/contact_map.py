"""Contact pressure of a recorded instant: the force is in the bag, and with the treads it decides the pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..contact.law import build_contact_law
from ..contact.solutions import approach_for_force, solve_patch
from ..irregularities import Breakout, breakouts
from ..runtime.arrays import Real
from ..scenario import WHEELS, Scenario

MARGIN = 2
"""Elements shown around the contact."""


@dataclass(frozen=True, eq=False)
class ContactMap:
    """Pressure where wheel and rail touch, and the defects there."""

    force: float
    """N"""
    pressure: Real
    """(nx, ny), Pa."""
    x: Real
    """Of the elements, from the middle of the contact area, (nx,), m, ahead positive."""
    y: Real
    """From the middle of the rail's head, (ny,), m, to the left positive."""
    size: tuple[float, float]
    """Extent along and across, m."""
    defects: tuple[tuple[float, Breakout], ...]
    """How far ahead the centre is, m, and the defect; those that reach into the picture."""
    rolling_circle: float = 0.0
    """Where the rolling circle, from which defects count, is over the rail, m."""
    bound: float = math.inf
    """Largest pressure that the contact admits, Pa; infinite for an elastic one."""


def contact_map(scenario: Scenario, wheel: int, step: int, force: float) -> ContactMap:
    """Contact of ``wheel`` (0 or 1) at a step of a run of ``scenario``, under a force, N.

    Of all approaches of two bodies one bears the force, so nothing of the run is simulated again. Raises
    ContactError for a force that the contact cannot bear.
    """
    dx, around = scenario.step_length, scenario.steps_per_revolution
    geometry, shapes = scenario.geometry, scenario.irregularities
    hardness = scenario.contact.largest_pressure
    law = build_contact_law(
        shapes, geometry, dx, around, rail_steps=scenario.line_steps, hardness=hardness, tables=False
    )
    tread_step = step - scenario.tread_origin
    patch = solve_patch(law, wheel, tread_step, step, approach_for_force(law, wheel, tread_step, step, force))
    part_x, part_y = (_shown(patch.pressure.max(axis=axis) > 0) for axis in (1, 0))
    x, y = patch.x[part_x], patch.y[part_y]
    defects = []
    for defect in breakouts(scenario.irregularities):
        centre = round(defect.angle / (2 * math.pi) * around)
        ahead = ((centre - tread_step + around // 2) % around - around // 2) * dx
        if defect.on == WHEELS[wheel] and x[0] - defect.half_length < ahead < x[-1] + defect.half_length:
            defects.append((ahead, defect))
    size = tuple(
        float((patch.pressure.max(axis=axis) > 0).sum() * (line[1] - line[0])) for axis, line in ((1, x), (0, y))
    )
    circle = geometry.rolling_circle(wheel)
    shown, extent = patch.pressure[part_x, part_y], (size[0], size[1])
    return ContactMap(patch.force, shown, x, y, extent, tuple(defects), circle, patch.bound)


def _shown(touched: NDArray[np.bool_]) -> slice:
    """The elements in contact and a margin, symmetric about the middle."""
    middle = len(touched) // 2
    reach = int(np.abs(np.flatnonzero(touched) - middle).max(initial=2)) + MARGIN
    return slice(max(0, middle - reach), middle + reach + 1)
