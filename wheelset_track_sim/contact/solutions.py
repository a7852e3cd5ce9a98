"""Single solutions of a contact law: a patch, a force, the approach that gives a force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..errors import ContactError, InputError
from ..irregularities.surface import WHEELS
from ..runtime.arrays import Real
from ..runtime.jit import Address
from .active_set_kernels import AT_BORDER, CONVERGED, NOT_CONVERGED
from .hardness import flag, share_from, stated
from .law_kernels import ContactLaw, contact_force, solve_bounded, solve_contact, total_separation
from .ordered.hinge_kernels import filtered_force

REASONS = {
    NOT_CONVERGED: "the active set does not settle",
    AT_BORDER: "the contact reaches the border of the potential contact area",
}

MOST_STEPS = 200
"""Of the search for the approach that gives a force, which takes about ten."""


@dataclass(frozen=True, eq=False)
class ContactPatch:
    """Solution of one normal contact."""

    force: float
    """N."""
    stiffness: float
    """Derivative of the force by the approach, N/m."""
    approach: float
    """m."""
    pressure: Real
    """(nx, ny), Pa."""
    x: Real
    """Longitudinal positions of the elements, (nx,), m, ahead positive."""
    y: Real
    """Lateral positions of the elements, from the middle of the rail's head, (ny,), m, to the left positive."""
    bound: float = np.inf
    """Largest pressure that the contact law admits, Pa; infinite for an elastic contact."""

    @property
    def hardness(self) -> float:
        """What pressures are compared with, Pa: the bound, or the hardness of steel."""
        return stated(self.bound)

    @property
    def share_at_hardness(self) -> float:
        """Share of the force on elements at that hardness or above."""
        return share_from(self.pressure, self.hardness)

    @property
    def flag(self) -> str:
        """The same in words; empty if the share is zero."""
        return flag(self.pressure, self.bound)


def solve_patch(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float = 0.0
) -> ContactPatch:
    """Contact of ``wheel`` (0 or 1) solved for pressure, force and stiffness; leaves the state of ``law`` as it is.

    Arguments as in ``contact_force``. Raises ContactError with the inputs if there is no solution.
    """
    pressure = np.empty(law.separation.shape[1:])
    guess = np.zeros(law.separation.shape[1:], np.bool_)
    force, stiffness, status = _solving(law)(
        law, wheel, tread_index, rail_index, float(approach), float(compliance), guess, pressure
    )
    if status != CONVERGED:
        raise ContactError(
            f"contact of {WHEELS[wheel]} at tread step {tread_index}, rail step {rail_index}, approach {approach:g} m, "
            f"compliance {compliance:g} m/N: {REASONS.get(status, 'the inputs are not finite')}"
        )
    return ContactPatch(force, stiffness, float(approach), pressure, law.x, law.y[wheel], law.hardness)


NEAR = 1e-9
"""Share of a force within which an approach bears it."""

_SOLVERS: dict[Any, Address] = {}


def solver(law: ContactLaw) -> Address:
    """What solves a law in the coupled step; compiled when that is called, which takes half a minute, once."""
    return _called(_solving(law), (law, 0, 0, 0, 0.0, 0.0, law.in_contact[0], np.empty((0, 0))))


def contact_filter(law: ContactLaw) -> Address:
    """The filter of nearly smooth contacts, for the coupled step; likewise, in some seconds."""
    surfaces = law.tread[0], law.rail_row[0], law.rail
    return _called(filtered_force, (law.hinges, 0, (0, 0), *surfaces, 0, 0, 0.0, 0.0, 0.0, 0.0))


def _called(function: Any, call: tuple[Any, ...]) -> Address:
    if function not in _SOLVERS:  # to the compiler, all laws are of one type
        _SOLVERS[function] = Address(function, (0.0, 0.0, 0), call)
    return _SOLVERS[function]


def _solving(law: ContactLaw) -> Any:
    return solve_bounded if law.hardness < np.inf else solve_contact


def force_at(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float = 0.0
) -> float:
    """``contact_force`` that raises ContactError, with the inputs, where that returns NaN."""
    force = contact_force(law, wheel, tread_index, rail_index, float(approach), float(compliance))
    if not np.isfinite(force):
        force = solve_patch(law, wheel, tread_index, rail_index, approach, compliance).force
    return float(force)


def approach_for_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float, compliance: float = 0.0
) -> float:
    """Approach, m, at which the contact of ``wheel`` bears ``force``, N: the inverse of ``contact_force``.

    Zero force gives the approach of first touch. Raises InputError for a negative force and ContactError for one that
    the law cannot bear.
    """
    if not 0.0 <= force < np.inf:
        raise InputError(f"force = {force:g} N is out of range: give a compressive force, 0 N or more")
    number = law.table[wheel, tread_index % law.table.shape[1]]
    on_rail = law.rail_table[wheel, rail_index % law.rail_table.shape[1]]
    if on_rail != 0:
        number = on_rail if 0 <= number < law.smooth_tables else -1
    if number >= 0:
        curve = law.points[law.first_point[number] : law.first_point[number + 1]]
        if force <= curve[-1, 1]:
            return float(np.interp(force, curve[:, 1], curve[:, 0])) + compliance * force
    touch = float(np.min(total_separation(law, wheel, tread_index, rail_index)))
    if force == 0.0:
        return touch
    approach = _elastic_approach(law._replace(hardness=np.inf), wheel, tread_index, rail_index, force, touch)
    if law.hardness < np.inf:
        approach = _yielding_approach(law, wheel, tread_index, rail_index, force, touch, approach)
    return approach + compliance * force


def _elastic_approach(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float, touch: float
) -> float:
    """``approach_for_force`` of an elastic contact without a table; ``touch`` is the approach of first touch, m."""
    approach = touch + 1e-6
    low, high = touch, np.inf
    nearest, error = approach, np.inf
    for _ in range(MOST_STEPS):
        if np.isfinite(high) and high - low <= 1e-2 * (high - touch):
            break
        try:
            patch = solve_patch(law, wheel, tread_index, rail_index, approach)
        except ContactError:
            # Too deep for the area: come back half of the way.
            high = approach
            approach = 0.5 * (low + high)
            continue
        if abs(patch.force - force) < error:
            nearest, error = approach, abs(patch.force - force)
        if patch.force < force:
            low = approach
        # The force is convex in the approach and made of straight pieces: Newton's method ends exactly, from above
        # without a step too far. From far below it is taken on the power 2/3, which is nearly straight (Hertz).
        step = (force - patch.force) / patch.stiffness
        if force > 2.0 * patch.force:
            step = 1.5 * ((force / patch.force) ** (2 / 3) - 1.0) * patch.force / patch.stiffness
        if abs(step) <= 2 * np.spacing(max(abs(approach), abs(touch), approach - touch)):  # it may be next to zero
            return approach
        approach = approach + step if approach + step < high else 0.5 * (approach + high)
    if error <= NEAR * force:  # rounding keeps the last step above the bound
        return nearest
    raise _not_borne(wheel, tread_index, rail_index, force)


def _yielding_approach(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float, touch: float, elastic: float
) -> float:
    """``approach_for_force`` of a contact that may yield: no less than that of the ``elastic`` one, m.

    The force rises with the approach, in straight pieces, but is not convex: Brent's method.
    """

    def lacking(approach: float) -> float:
        return solve_patch(law, wheel, tread_index, rail_index, approach).force - force

    patch = solve_patch(law, wheel, tread_index, rail_index, elastic)
    if patch.pressure.max() < law.hardness:
        return elastic
    low, high = elastic, touch + 1.5 * (elastic - touch)
    try:
        while lacking(high) < 0.0:
            low, high = high, touch + 1.5 * (high - touch)
    except ContactError:
        raise _not_borne(wheel, tread_index, rail_index, force) from None
    return float(scipy.optimize.brentq(lacking, low, high, xtol=1e-3 * NEAR * (high - touch), rtol=1e-15))


def _not_borne(wheel: int, tread_index: int, rail_index: int, force: float) -> ContactError:
    return ContactError(
        f"contact of {WHEELS[wheel]} at tread step {tread_index}, rail step {rail_index} cannot carry {force:g} N"
    )
