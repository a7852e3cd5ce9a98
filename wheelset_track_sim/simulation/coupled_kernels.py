"""The coupled step: displacements from the dynamics, irregularities added, contact solved, forces fed back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contact.law_kernels import UNTABLED, ContactLaw, table_number, tabulated_force
from ..dynamics.interface_kernels import advance, displacements, sensed, stresses
from ..runtime.jit import kernel


@kernel
def run(
    dynamics: Any,
    law: ContactLaw,
    solver: Any,
    contact_filter: Any,
    preload: np.ndarray,
    tread_origin: int,
    first_step: int,
    forces: np.ndarray,
    stress: np.ndarray,
    signals: np.ndarray,
    xi: np.ndarray,
    untabled: np.ndarray,
) -> int:
    """Take one coupled step for each row of ``forces`` (n, 2); returns how many of them were solved.

    ``contact_filter``, if the law has hinges, and ``solver`` are asked where tables have no force
    (``contact.solutions``); with None, which is compiled without them and runs faster, such steps are not solved.
    ``preload`` (n, 2) m is the approach of wheel and rail without dynamics that loads each contact with the static
    force; ``tread_origin`` is the step at which angle 0 of the treads meets the rail. Fills ``forces`` in N, ``stress``
    (n, S) in Pa, ``signals`` (n, rows) of sensors, and ``xi`` (n, 2, 2) in m: wheels and rails, with what the force
    displaces at once. Adds to ``untabled`` (3,) the contacts that were solved and filtered, and keeps the largest
    estimate of an error there, N.
    A count below n means that the contact problem of that step is not solved; the state stays at that step.
    """
    none = np.empty((0, 0))
    turn, line = law.table.shape[1], law.rail_table.shape[1]
    tread, rail = (first_step - tread_origin) % turn, first_step % line
    bay = dynamics.rail_compliance.size
    for row in range(forces.shape[0]):
        step = first_step + row
        displacements(dynamics, step, xi[row])
        for wheel in range(2):
            approach = preload[row, wheel] - xi[row, 0, wheel] - xi[row, 1, wheel]
            of_wheel, of_rail = dynamics.wheel_compliance[wheel], dynamics.rail_compliance[step % bay]
            compliance = of_wheel + of_rail
            force = tabulated_force(law, wheel, tread, rail, approach, compliance)
            if solver is not None:  # alone, so that the compiler leaves out what follows
                nowhere = np.isnan(force) and table_number(law, wheel, tread, rail) == UNTABLED
                if nowhere and law.largest_estimate > 0.0:
                    force, estimate, _ = contact_filter(
                        law.hinges,
                        wheel,
                        law.separation.shape[1:],
                        law.tread[wheel],
                        law.rail_row[wheel],
                        law.rail,
                        tread,
                        rail,
                        law.element_area,
                        approach,
                        compliance,
                        law.largest_estimate,
                    )
                    if np.isfinite(force):
                        untabled[1] += 1
                        untabled[2] = max(untabled[2], estimate)
                if not np.isfinite(force):
                    force = solver(law, wheel, tread, step, approach, compliance, law.in_contact[wheel], none)[0]
                    untabled[0] += 1
            if not np.isfinite(force):
                return row
            forces[row, wheel] = force
            xi[row, 0, wheel] += of_wheel * force
            xi[row, 1, wheel] += of_rail * force
        stresses(dynamics, forces[row], stress[row])
        if signals.shape[1]:
            sensed(dynamics, forces[row], signals[row])
        advance(dynamics, step, forces[row])
        tread, rail = tread + 1, rail + 1
        tread, rail = 0 if tread == turn else tread, 0 if rail == line else rail
    return len(forces)
